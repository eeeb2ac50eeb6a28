// SPDX-License-Identifier: MIT
// Shapes from grids of points: every curved one is a tube of rings joined by quads.
#include "host/models/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace penumbra {

namespace {

constexpr double two_pi = glm::two_pi<double>();

void add_quad(Shape& shape, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    shape.indices.insert(shape.indices.end(), {a, b, c, a, c, d});
}

// Joins `rings` rings of `segments` points each, stored one after the other; `closed` joins the last to the
// first.
void join_rings(Shape& shape, uint32_t first, uint32_t rings, uint32_t segments, bool closed) {
    for (uint32_t ring = 0; ring + (closed ? 0 : 1) < rings; ++ring) {
        const uint32_t low = first + ring * segments, high = first + (ring + 1) % rings * segments;
        for (uint32_t i = 0; i < segments; ++i) {
            const uint32_t next = (i + 1) % segments;
            add_quad(shape, low + i, high + i, high + next, low + next);
        }
    }
}

// A fan over a ring; `up`: the cap faces the direction in which the rings were stacked.
void cap(Shape& shape, uint32_t ring, uint32_t segments, const glm::dvec3& centre, bool up) {
    const auto middle = static_cast<uint32_t>(shape.positions.size());
    shape.positions.emplace_back(centre);
    for (uint32_t i = 0; i < segments; ++i) {
        const uint32_t a = ring + i, b = ring + (i + 1) % segments;
        shape.indices.insert(shape.indices.end(), {middle, up ? b : a, up ? a : b});
    }
}

}  // namespace

void Shape::append(const Shape& other) {
    const auto first = static_cast<uint32_t>(positions.size());
    positions.insert(positions.end(), other.positions.begin(), other.positions.end());
    for (const uint32_t index : other.indices) indices.push_back(first + index);
    if (uv.empty() && other.uv.empty()) return;
    uv.resize(first);
    uv.insert(uv.end(), other.uv.begin(), other.uv.end());
    uv.resize(positions.size());
}

void Shape::transform(const glm::dmat4& matrix) {
    for (glm::vec3& p : positions) p = glm::vec3(matrix * glm::dvec4(p, 1));
}

Shape box(const glm::dvec3& low, const glm::dvec3& high) {
    Shape shape;
    for (int corner = 0; corner < 8; ++corner) {
        shape.positions.emplace_back(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                                     corner & 4 ? high.z : low.z);
    }
    add_quad(shape, 0, 4, 6, 2);  // -x
    add_quad(shape, 1, 3, 7, 5);  // +x
    add_quad(shape, 0, 1, 5, 4);  // -y
    add_quad(shape, 2, 6, 7, 3);  // +y
    add_quad(shape, 0, 2, 3, 1);  // -z
    add_quad(shape, 4, 5, 7, 6);  // +z
    return shape;
}

Shape ground(double half_x, double half_z, int cells_x, int cells_z) {
    Shape shape;
    for (int z = 0; z <= cells_z; ++z) {
        for (int x = 0; x <= cells_x; ++x) {
            shape.positions.emplace_back(half_x * (2.0 * x / cells_x - 1), 0,
                                         half_z * (2.0 * z / cells_z - 1));
        }
    }
    const auto row = static_cast<uint32_t>(cells_x + 1);
    for (uint32_t z = 0; z < static_cast<uint32_t>(cells_z); ++z) {
        for (uint32_t x = 0; x + 1 < row; ++x) {
            const uint32_t a = z * row + x;
            add_quad(shape, a, a + row, a + row + 1, a + 1);
        }
    }
    return shape;
}

Shape lathe(std::span<const ProfilePoint> profile, int segments,
            const std::function<double(double)>& ripple) {
    Shape shape;
    const auto count = static_cast<uint32_t>(segments);
    for (const ProfilePoint& point : profile) {
        for (uint32_t i = 0; i < count; ++i) {
            const double angle = two_pi * i / count;
            const double radius = point.radius * (ripple ? ripple(angle) : 1);
            shape.positions.emplace_back(radius * std::cos(angle), point.height, radius * std::sin(angle));
        }
    }
    const auto rings = static_cast<uint32_t>(profile.size());
    join_rings(shape, 0, rings, count, false);
    cap(shape, 0, count, {0, profile.front().height, 0}, false);
    cap(shape, (rings - 1) * count, count, {0, profile.back().height, 0}, true);
    return shape;
}

Shape rod(const glm::dvec3& a, const glm::dvec3& b, double radius, int segments) {
    const glm::dvec3 axis = b - a;
    const std::array<ProfilePoint, 2> profile{{{0, radius}, {glm::length(axis), radius}}};
    Shape shape = lathe(profile, segments);
    const glm::dvec3 y = glm::normalize(axis);
    const glm::dvec3 x =
        glm::normalize(glm::cross(y, std::abs(y.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 0, 1)));
    shape.transform(
        glm::dmat4(glm::dvec4(x, 0), glm::dvec4(y, 0), glm::dvec4(glm::cross(x, y), 0), glm::dvec4(a, 1)));
    return shape;
}

Shape link(double ring_radius, double bar_radius, double straight, int ring_segments, int bar_segments) {
    Shape shape;
    for (int i = 0; i < ring_segments; ++i) {
        const double around =
            two_pi * (i + 0.5) / ring_segments;  // no point on the axis: the halves are equal
        const glm::dvec3 outwards(std::cos(around), std::sin(around), 0);
        const glm::dvec3 centre =
            ring_radius * outwards + glm::dvec3(std::copysign(0.5 * straight, outwards.x), 0, 0);
        for (int k = 0; k < bar_segments; ++k) {
            const double turn = two_pi * k / bar_segments;
            shape.positions.emplace_back(
                centre + bar_radius * (std::cos(turn) * outwards + std::sin(turn) * glm::dvec3(0, 0, 1)));
        }
    }
    join_rings(shape, 0, static_cast<uint32_t>(ring_segments), static_cast<uint32_t>(bar_segments), true);
    return shape;
}

Shape chain(const glm::dvec3& a, const glm::dvec3& b, double sag, double bar_radius) {
    const double ring_radius = 2.2 * bar_radius, straight = 3 * bar_radius;
    const double pitch = straight + 2 * ring_radius - 2 * bar_radius;  // inner length: bars touch
    const auto at = [&](double t) { return glm::mix(a, b, t) - glm::dvec3(0, 4 * sag * t * (1 - t), 0); };

    // Arc length by a fine polyline, then a whole number of links of equal spacing along it.
    constexpr int steps = 2000;
    std::vector<double> length(steps + 1, 0);
    for (size_t i = 1; i <= steps; ++i) {
        length[i] = length[i - 1] + glm::distance(at(double(i - 1) / steps), at(double(i) / steps));
    }
    const int links = std::max(1, static_cast<int>(length.back() / pitch));
    const Shape one = link(ring_radius, bar_radius, straight, 20, 8);
    Shape shape;
    for (int i = 0; i < links; ++i) {
        const double wanted = length.back() * (i + 0.5) / links;
        const auto after = std::ranges::lower_bound(length, wanted) - length.begin();
        const double t = double(after) / steps;
        const glm::dvec3 x = glm::normalize(at(std::min(t + 1e-3, 1.0)) - at(std::max(t - 1e-3, 0.0)));
        const glm::dvec3 side = glm::normalize(glm::cross(x, glm::dvec3(0, 1, 0)));
        const glm::dvec3 y = i % 2 ? side : glm::cross(side, x);
        Shape placed = one;
        placed.transform(glm::dmat4(glm::dvec4(x, 0), glm::dvec4(y, 0), glm::dvec4(glm::cross(x, y), 0),
                                    glm::dvec4(at(t), 1)));
        shape.append(placed);
    }
    return shape;
}

Part to_part(Shape shape, int material) {
    Part part;
    part.positions = std::move(shape.positions);
    part.uv = std::move(shape.uv);
    part.indices = std::move(shape.indices);
    part.material = material;
    return part;
}

}  // namespace penumbra
