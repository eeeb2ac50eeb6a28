// SPDX-License-Identifier: MIT
#include "host/truth/sun_visibility.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace penumbra {
namespace {

using std::numbers::pi;

// 1 - cos, without cancellation.
double versine(double angle) {
    const double half_sine = std::sin(0.5 * angle);
    return 2 * half_sine * half_sine;
}

// Angle of a spherical triangle opposite to side `a`, by half angles: small triangles keep their digits.
double triangle_angle(double a, double b, double c) {
    const double s = 0.5 * (a + b + c);
    const double up = std::max(std::sin(s - b) * std::sin(s - c), 0.0),
                 down = std::max(std::sin(s) * std::sin(s - a), 0.0);
    return 2 * std::atan2(std::sqrt(up), std::sqrt(down));
}

// Area that two caps of radii a and b share whose centres lie d apart: two sectors less two triangles. Each
// sector is angle * versine; the triangles' excess is what their angles exceed pi by.
double shared_area(double a, double b, double d) {
    if (d >= a + b) return 0;
    if (d <= std::abs(a - b)) return 2 * pi * versine(std::min(a, b));
    const double at_a = triangle_angle(b, a, d), at_b = triangle_angle(a, b, d),
                 at_rim = triangle_angle(d, a, b);
    return 2 * (at_a * versine(a) + at_b * versine(b) - (at_a + at_b + at_rim - pi));
}

}  // namespace

double half_plane_visibility(double distance, double radius) {
    if (distance >= radius) return 1;
    if (distance <= -radius) return 0;
    const double sine = std::clamp(std::sin(distance) / std::sin(radius), -1.0, 1.0);
    const double tangent = std::clamp(std::tan(distance) / std::tan(radius), -1.0, 1.0);
    const double cap = pi * versine(radius);
    return std::clamp(0.5 + (std::asin(sine) - std::cos(radius) * std::asin(tangent)) / cap, 0.0, 1.0);
}

double sphere_visibility(double distance, double sphere, double radius) {
    const double sun = 2 * pi * versine(radius);
    return std::clamp(1 - shared_area(sphere, radius, distance) / sun, 0.0, 1.0);
}

namespace {

// The sun's frame: the polygon's part of the cap is summed edge by edge, each seen from the cap's centre.
struct SunCap {
    glm::dvec3 centre, x, y;
    double radius;

    double azimuth(const glm::dvec3& d) const { return std::atan2(glm::dot(d, y), glm::dot(d, x)); }

    // Signed area between the centre and an arc within the cap: van Oosterom and Strackee 1983.
    double triangle(const glm::dvec3& p, const glm::dvec3& q) const {
        return 2 * std::atan2(glm::dot(centre, glm::cross(p, q)),
                              1 + glm::dot(centre, p) + glm::dot(p, q) + glm::dot(q, centre));
    }
    // Of the cap's sector below an arc outside of it.
    double sector(const glm::dvec3& p, const glm::dvec3& q) const {
        return versine(radius) * std::remainder(azimuth(q) - azimuth(p), 2 * pi);
    }
    // p, q: unit. The arc is p cos t + side sin t; it meets the rim where its height over the centre's
    // equator, amplitude * cos(t - middle), is cos(radius).
    double below_arc(const glm::dvec3& p, const glm::dvec3& q) const {
        const glm::dvec3 normal = glm::cross(p, q);
        const double length = glm::length(normal);
        if (!(length > 0)) return 0;
        const glm::dvec3 side = glm::cross(normal / length, p);
        const double end = std::atan2(length, glm::dot(p, q));
        const double u = glm::dot(centre, p), v = glm::dot(centre, side);
        const double amplitude = std::hypot(u, v), middle = std::atan2(v, u);
        if (amplitude <= std::cos(radius)) return sector(p, q);
        // cos(half) = cos(radius) / amplitude. The amplitude is the cosine of the arc's distance from the
        // centre, whose sine, centre.normal, keeps the digits that the cosines of small angles lose.
        const double distance = glm::dot(centre, normal / length);
        const double sine =
            std::sqrt(std::max(std::sin(radius) * std::sin(radius) - distance * distance, 0.0));
        const double half = std::atan2(sine, std::cos(radius));
        const double in = std::clamp(middle - half, 0.0, end), out = std::clamp(middle + half, 0.0, end);
        const auto at = [&](double t) { return p * std::cos(t) + side * std::sin(t); };
        if (!(out > in)) return sector(p, q);
        double area = triangle(at(in), at(out));
        if (in > 0) area += sector(p, at(in));
        if (out < end) area += sector(at(out), q);
        return area;
    }
};

}  // namespace

double polygon_visibility(const glm::dvec3& to_sun, double radius, std::span<const glm::dvec3> corners) {
    const glm::dvec3 helper = std::abs(to_sun.z) < 0.7 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
    const glm::dvec3 x = glm::normalize(glm::cross(helper, to_sun));
    const SunCap cap{to_sun, x, glm::cross(to_sun, x), radius};
    double area = 0;
    for (size_t i = 0; i < corners.size(); ++i)
        area += cap.below_arc(glm::normalize(corners[i]), glm::normalize(corners[(i + 1) % corners.size()]));
    return std::clamp(1 - std::abs(area) / (2 * pi * versine(radius)), 0.0, 1.0);
}

}  // namespace penumbra
