// SPDX-License-Identifier: MIT
// Triangle scenes and shadow rays that the hierarchy's tests and benchmark share. All deterministic.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "host/bvh/bvh.h"

namespace penumbra::test {

// PCG, O'Neill 2014 (RXS-M-XS 32): the standard distributions differ between libraries, this does not.
class Random {
  public:
    explicit Random(uint32_t seed) : state_(seed * 2654435761u + 1u) {}
    uint32_t bits() {
        state_ = state_ * 747796405u + 2891336453u;
        const uint32_t word = ((state_ >> ((state_ >> 28) + 4)) ^ state_) * 277803737u;
        return word >> 22 ^ word;
    }
    float unit() { return float(bits() >> 8) * 0x1p-24f; }
    float in(float lo, float hi) { return lo + (hi - lo) * unit(); }

  private:
    uint32_t state_;
};

struct Vec {
    float x, y, z;
    friend Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend Vec operator*(Vec a, float s) { return {a.x * s, a.y * s, a.z * s}; }
};

inline Vec normalised(Vec v) {
    const double l = std::sqrt(double(v.x) * v.x + double(v.y) * v.y + double(v.z) * v.z);
    return {float(v.x / l), float(v.y / l), float(v.z / l)};
}

inline Triangle triangle(Vec a, Vec b, Vec c) {
    return {{{a.x, a.y, a.z}, {b.x, b.y, b.z}, {c.x, c.y, c.z}}};
}

inline Vec random_direction(Random& random) {
    const float z = random.in(-1, 1), phi = random.in(0, 2 * std::numbers::pi_v<float>);
    const float r = std::sqrt(std::max(1 - z * z, 0.0f));
    return normalised({r * std::cos(phi), r * std::sin(phi), z});
}

inline std::vector<Triangle> soup(uint32_t count, uint32_t seed) {
    Random random(seed);
    std::vector<Triangle> out;
    for (uint32_t i = 0; i < count; ++i) {
        const Vec c{random.in(-10, 10), random.in(-10, 10), random.in(-10, 10)};
        const float size = 0.02f * std::exp2(random.in(0, 5));
        const auto corner = [&] { return c + random_direction(random) * (size * random.unit()); };
        const Vec a = corner(), b = corner();
        out.push_back(triangle(a, b, corner()));
    }
    return out;
}

inline float hill(float x, float z) {
    float y = 0, amplitude = 2.5f, f = 0.35f;
    for (int octave = 0; octave < 7; ++octave, amplitude *= 0.47f, f *= 1.97f)
        y += amplitude * std::sin(x * f + 1.3f * float(octave)) *
             std::cos(z * f * 1.1f - 0.7f * float(octave));
    return y;
}

// 2 * n * n triangles over 20 m x 20 m.
inline std::vector<Triangle> terrain(uint32_t n) {
    const auto at = [n](uint32_t i, uint32_t j) {
        const float x = 20 * (float(i) / float(n) - 0.5f), z = 20 * (float(j) / float(n) - 0.5f);
        return Vec{x, hill(x, z), z};
    };
    std::vector<Triangle> out;
    for (uint32_t j = 0; j < n; ++j)
        for (uint32_t i = 0; i < n; ++i) {
            out.push_back(triangle(at(i, j), at(i, j + 1), at(i + 1, j)));
            out.push_back(triangle(at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)));
        }
    return out;
}

inline void add_quad(std::vector<Triangle>& out, Vec a, Vec b, Vec c, Vec d) {
    out.push_back(triangle(a, b, c));
    out.push_back(triangle(a, c, d));
}

inline void add_box(std::vector<Triangle>& out, Vec lo, Vec hi) {
    const auto p = [&](int i) { return Vec{i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z}; };
    constexpr int faces[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                 {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    for (const auto& f : faces) add_quad(out, p(f[0]), p(f[1]), p(f[2]), p(f[3]));
}

// Bars 1 mm thick and up to 20 m long, along the axes and slanted.
inline std::vector<Triangle> thin_bars(uint32_t count, uint32_t seed) {
    Random random(seed);
    std::vector<Triangle> out;
    for (uint32_t i = 0; i < count; ++i) {
        const Vec a{random.in(-10, 10), random.in(-10, 10), random.in(-10, 10)};
        Vec d = random_direction(random);
        if (i % 2) d = {float(i % 6 == 1), float(i % 6 == 3), float(i % 6 == 5)};
        const Vec b = a + d * random.in(1, 20);
        const Vec side = std::abs(d.y) < 0.9f ? Vec{0.001f, 0, 0} : Vec{0, 0, 0.001f};
        const Vec up = {0.0004f, 0.001f, 0.0007f};
        add_quad(out, a, b, b + side, a + side);
        add_quad(out, a, b, b + up, a + up);
    }
    return out;
}

// Rows of fluted columns on a floor with a roof: 2 * sides * rings triangles per column.
inline std::vector<Triangle> colonnade(uint32_t columns, uint32_t sides, uint32_t rings) {
    std::vector<Triangle> out;
    const uint32_t per_row = uint32_t(std::ceil(std::sqrt(double(columns))));
    const float span = float(per_row) * 3;
    for (uint32_t c = 0; c < columns; ++c) {
        const float cx = float(c % per_row) * 3 - span / 2, cz = float(c / per_row) * 3 - span / 2;
        const auto at = [&](uint32_t s, uint32_t r) {
            const float h = float(r) / float(rings),
                        phi = 2 * std::numbers::pi_v<float> * float(s % sides) / float(sides);
            const float radius =
                (0.55f - 0.15f * h) * (1 + 0.06f * std::cos(phi * 20)) + (h < 0.04f ? 0.15f : 0.0f);
            return Vec{cx + radius * std::cos(phi), 6 * h, cz + radius * std::sin(phi)};
        };
        for (uint32_t r = 0; r < rings; ++r)
            for (uint32_t s = 0; s < sides; ++s)
                add_quad(out, at(s, r), at(s + 1, r), at(s + 1, r + 1), at(s, r + 1));
    }
    add_quad(out, {-span, 0, -span}, {-span, 0, span}, {span, 0, span}, {span, 0, -span});
    for (uint32_t i = 0; i < per_row; ++i)  // beams along every row
        add_box(out, {-span / 2 - 1, 6, float(i) * 3 - span / 2 - 0.4f},
                {span / 2 + 1, 6.8f, float(i) * 3 - span / 2 + 0.4f});
    return out;
}

// A closed ball: a subdivided octahedron with irregular radii, translated.
inline std::vector<Triangle> closed_ball(uint32_t levels, Vec centre, float radius) {
    std::vector<Triangle> out;
    const auto on_sphere = [&](Vec v) {
        v = normalised(v);
        const float r = radius * (1 + 0.1f * std::sin(9 * v.x) * std::sin(7 * v.y + 3 * v.z));
        return centre + v * r;
    };
    // Points on the sphere depend on their parameters alone, so neighbours agree bit for bit.
    const std::function<void(Vec, Vec, Vec, uint32_t)> divide = [&](Vec a, Vec b, Vec c, uint32_t level) {
        if (level == 0) {
            out.push_back(triangle(on_sphere(a), on_sphere(b), on_sphere(c)));
            return;
        }
        const Vec ab = (a + b) * 0.5f, bc = (b + c) * 0.5f, ca = (c + a) * 0.5f;
        divide(a, ab, ca, level - 1);
        divide(ab, b, bc, level - 1);
        divide(ca, bc, c, level - 1);
        divide(ab, bc, ca, level - 1);
    };
    for (int i = 0; i < 8; ++i)
        divide({i & 1 ? -1.0f : 1.0f, 0, 0}, {0, i & 2 ? -1.0f : 1.0f, 0}, {0, 0, i & 4 ? -1.0f : 1.0f},
               levels);
    return out;
}

inline std::vector<Triangle> scaled(std::vector<Triangle> triangles, float scale) {
    for (Triangle& t : triangles)
        for (auto& v : t.v)
            for (float& x : v) x *= scale;
    return triangles;
}

// Every split cuts off its largest members only: SAH alone would go 250 levels deep.
inline std::vector<Triangle> geometric_series(int copies) {
    std::vector<Triangle> series;
    for (int i = -60; i < 38; ++i)
        for (int copy = 0; copy < copies; ++copy) {
            const float s = std::ldexp(1.0f, i), o = s * (1 + 0.6f * float(copy) / float(copies));
            series.push_back(triangle({o, o, o}, {o + s, o, o}, {o, o + s, o}));
        }
    return series;
}

struct TriangleScene {
    std::string name;
    std::vector<Triangle> triangles;
};

// Made by formula; tests/bvh_shipped_scenes.h has those that come from files.
inline std::vector<TriangleScene> made_scenes() {
    return {{"soup", soup(20000, 1)},
            {"terrain", terrain(150)},
            {"thin_bars", thin_bars(3000, 2)},
            {"colonnade", colonnade(25, 40, 24)},
            {"terrain_small", scaled(terrain(60), 1e-3f)},
            {"terrain_large", scaled(terrain(60), 1e3f)}};
}

// Shadow rays from points on the surface (or anywhere in the bounds), half of them towards one sun.
inline std::vector<Ray> shadow_rays(const std::vector<Triangle>& triangles, uint32_t count, uint32_t seed) {
    Random random(seed);
    const Vec sun = normalised({0.4f, 0.7f, -0.3f});
    std::vector<Ray> rays;
    rays.reserve(count);
    for (uint32_t i = 0; i < count; ++i) {
        const auto& t = triangles[random.bits() % triangles.size()].v;
        float u = random.unit(), v = random.unit();
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        float p[3], size = 0;
        for (int a = 0; a < 3; ++a) {
            p[a] = t[0][a] + u * (t[1][a] - t[0][a]) + v * (t[2][a] - t[0][a]);
            size = std::max({size, std::abs(t[1][a] - t[0][a]), std::abs(t[2][a] - t[0][a])});
        }
        const Vec offset = random_direction(random) * (size * (i % 4 == 0 ? 3.0f : 0.01f));
        const Vec d = i % 2 ? normalised(sun + random_direction(random) * (0.05f * random.unit()))
                            : random_direction(random);
        const float t_max = i % 8 == 7 ? size * 8 : std::numeric_limits<float>::infinity();
        rays.push_back({{p[0] + offset.x, p[1] + offset.y, p[2] + offset.z}, {d.x, d.y, d.z}, 0, t_max});
    }
    return rays;
}

}  // namespace penumbra::test
