// SPDX-License-Identifier: MIT
// A world that needs no model: a floor, a ball above it, and the sun, seen by a camera that drifts sideways.
// What a host with a tracer of its own has in every pixel: depth, normal, motion, and whether one ray to a
// random point of the sun was blocked.
#pragma once

#include <penumbra/blocks.h>
#include <penumbra/frame_block.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

namespace world {

struct V3 {
    double x, y, z;
};
inline V3 operator+(V3 a, V3 b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline V3 operator-(V3 a, V3 b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline V3 operator*(double s, V3 a) {
    return {s * a.x, s * a.y, s * a.z};
}
inline double dot(V3 a, V3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline V3 unit(V3 a) {
    return 1 / std::sqrt(dot(a, a)) * a;
}

constexpr double near_m = 0.1, vertical_fov = 0.9, sun_radius = 0.06;
constexpr V3 ball{0, 1.2, -5};
constexpr double ball_radius = 0.8;
inline const V3 to_sun = unit({0.5, 0.8, 0.3});

inline V3 eye(int frame) {
    return {0.02 * frame - 0.3, 1.7, 0};
}

// Metres along a ray to the ball.
inline std::optional<double> hit_ball(V3 from, V3 direction) {
    const V3 to = ball - from;
    const double along = dot(to, direction),
                 discriminant = along * along - dot(to, to) + ball_radius * ball_radius;
    if (discriminant < 0 || along - std::sqrt(discriminant) < 1e-6) return std::nullopt;
    return along - std::sqrt(discriminant);
}

struct Surface {
    V3 position, normal;
};
inline std::optional<Surface> seen(V3 from, V3 direction) {
    if (const auto t = hit_ball(from, direction)) {
        const V3 p = from + *t * direction;
        return Surface{p, unit(p - ball)};
    }
    if (direction.y >= -1e-3) return std::nullopt;
    return Surface{from + -from.y / direction.y * direction, {0, 1, 0}};
}

struct Size {
    uint32_t width, height;
};

// The camera looks along -z; its rays through pixels' centres, and where it sees a point.
inline V3 ray(Size s, double x, double y) {
    const double half = std::tan(vertical_fov / 2);
    return {half * s.width / s.height * (2 * (x + 0.5) / s.width - 1), half * (1 - 2 * (y + 0.5) / s.height),
            -1};
}
inline std::array<double, 2> uv_of(Size s, V3 from, V3 point) {
    const V3 d = point - from;
    const double half = std::tan(vertical_fov / 2);
    return {0.5 + 0.5 * (d.x / -d.z) / (half * s.width / s.height), 0.5 - 0.5 * (d.y / -d.z) / half};
}

inline double random(uint32_t& state) {  // PCG (O'Neill 2014), to [0, 1)
    state = state * 747796405u + 2891336453u;
    const uint32_t word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737u;
    return ((word >> 22) ^ word) / 4294967296.0;
}

// One ray to a point of the sun's disc.
inline bool blocked(const Surface& surface, uint32_t& state) {
    const V3 side = unit({to_sun.z, 0, -to_sun.x}),
             up{to_sun.y * side.z - to_sun.z * side.y, to_sun.z * side.x - to_sun.x * side.z,
                to_sun.x * side.y - to_sun.y * side.x};
    const double r = std::tan(sun_radius) * std::sqrt(random(state)),
                 angle = 6.283185307179586 * random(state);
    const V3 direction = unit(to_sun + r * std::cos(angle) * side + r * std::sin(angle) * up);
    return dot(surface.normal, direction) <= 0 ||
           hit_ball(surface.position + 1e-4 * surface.normal, direction).has_value();
}

inline uint16_t half(double value) {  // of numbers whose magnitude is less than 1
    const float f = static_cast<float>(value);
    uint32_t bits;
    std::memcpy(&bits, &f, 4);
    const int exponent = static_cast<int>(bits >> 23 & 255) - 112;
    if (exponent <= 0) return static_cast<uint16_t>(bits >> 16 & 0x8000);
    return static_cast<uint16_t>((bits >> 16 & 0x8000) | static_cast<uint32_t>(exponent) << 10 |
                                 (bits >> 13 & 1023));
}

struct Frame {
    std::vector<float> depth, normal;  // r; rgba
    std::vector<uint16_t> motion;      // rgba16f
    std::vector<uint32_t> hits;        // words of 8x4 pixels, bit (y % 4) * 8 + x % 8: 1 = blocked
};

inline Frame render(Size size, int frame) {
    Frame out;
    const uint32_t tiles = (size.width + 7) / 8;
    out.hits.resize(size_t{tiles} * ((size.height + 3) / 4));
    for (uint32_t y = 0; y < size.height; ++y)
        for (uint32_t x = 0; x < size.width; ++x) {
            const V3 from = eye(frame), d = ray(size, x, y);  // d.z is -1: its multiples are view depths
            const auto surface = seen(from, unit(d));
            if (!surface) {
                out.depth.push_back(0);
                out.normal.insert(out.normal.end(), 4, 0.0f);
                out.motion.insert(out.motion.end(), 4, uint16_t{0});
                continue;
            }
            out.depth.push_back(static_cast<float>(near_m / (from.z - surface->position.z)));
            for (const double n : {surface->normal.x, surface->normal.y, surface->normal.z, 0.0})
                out.normal.push_back(static_cast<float>(n));
            const auto now = uv_of(size, from, surface->position),
                       then = uv_of(size, eye(frame > 0 ? frame - 1 : 0), surface->position);
            for (const double m : {then[0] - now[0], then[1] - now[1], 0.0, 0.0})
                out.motion.push_back(half(m));
            uint32_t state = (static_cast<uint32_t>(frame) * size.height + y) * size.width + x;
            random(state);
            if (blocked(*surface, state))
                out.hits[size_t{y / 4} * tiles + x / 8] |= 1u << (y % 4 * 8 + x % 8);
        }
    return out;
}

inline penumbra::FrameDescription describe(Size size, int frame) {
    penumbra::FrameDescription d;
    for (const int previous : {0, 1}) {
        penumbra::Camera& camera = previous ? d.previous : d.camera;
        const V3 at = eye(previous && frame > 0 ? frame - 1 : frame);
        camera.position = {at.x, at.y, at.z};
        camera.clip_from_view = penumbra::perspective(vertical_fov, double(size.width) / size.height, near_m);
        camera.near_m = near_m;
    }
    d.size = {size.width, size.height};
    d.index = static_cast<uint32_t>(frame);
    d.dt_s = 1.0f / 60;
    return d;
}

inline penumbra::blocks::Sun sun() {
    return {{float(to_sun.x), float(to_sun.y), float(to_sun.z)}, float(sun_radius)};
}

// The share of the sun that is seen, from many rays; nothing where there is no surface.
inline std::optional<double> truth(Size size, int frame, uint32_t x, uint32_t y) {
    const auto surface = seen(eye(frame), unit(ray(size, x, y)));
    if (!surface) return std::nullopt;
    uint32_t state = 77 * (y * size.width + x), lit = 0;
    for (int i = 0; i < 256; ++i) lit += !blocked(*surface, state);
    return lit / 256.0;
}

}  // namespace world
