// SPDX-License-Identifier: MIT
#include "tests/coverage_oracle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace penumbra::test {
namespace {

// Gauss and Legendre's rule of 8 points on -1 .. 1.
constexpr std::array<double, 4> places = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                          0.9602898564975363};
constexpr std::array<double, 4> weights = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                           0.1012285362903763};

struct Interval {
    double low, high;
};

// What of the column at x lies in the part.
std::optional<Interval> column_of(const ConvexPart& part, double x, double rim) {
    double low = -rim, high = rim;
    for (const glm::dvec3& l : part) {
        const double at_0 = l.x * x + l.z;
        if (l.y > 0)
            low = std::max(low, -at_0 / l.y);
        else if (l.y < 0)
            high = std::min(high, -at_0 / l.y);
        else if (at_0 < 0)
            return std::nullopt;
    }
    if (!(low < high)) return std::nullopt;
    return Interval{low, high};
}

// The tangent plane's place (x, y) t sees (1 + t^2 (x^2 + y^2))^(-3/2) of solid angle per area; the integral
// over y.
double column_integral(double x, double y, double t) {
    const double across = 1 + t * t * x * x;
    return y / (across * std::sqrt(across + t * t * y * y));
}

}  // namespace

SeenLight seen_light(const glm::dvec3& to_sun, double angular_radius) {
    const glm::dvec3 z = glm::normalize(to_sun),
                     x = glm::normalize(
                         glm::cross(z, std::abs(z.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
    return {glm::dmat3(x, glm::cross(z, x), z), angular_radius};
}

// D = sum of b_i V_i with b_i = D . (V_j x V_k) / det(V), all of them positive.
ConvexPart hidden_by(const SeenLight& light, const glm::dvec3& start, const glm::dvec3 (&corners)[3]) {
    const glm::dmat3 to_light = glm::transpose(light.axes);
    const double t = std::tan(light.angular_radius);
    glm::dvec3 v[3];
    for (int i = 0; i < 3; ++i) v[i] = to_light * (corners[i] - start);
    // The height over the plane from the triangle's own sides, which keeps its digits far away.
    const double det =
        glm::dot(corners[0] - start, glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
    if (det == 0) return {};
    ConvexPart part;
    for (int i = 0; i < 3; ++i) {
        const glm::dvec3 e = glm::cross(v[(i + 1) % 3], v[(i + 2) % 3]) * (det < 0 ? -1.0 : 1.0);
        glm::dvec3 l(e.x * t, e.y * t, e.z);
        const double length = glm::length(l);
        part.push_back(length > 0 ? l / length : l);
    }
    return part;
}

ConvexPart below_plane(const SeenLight& light, const glm::dvec3& normal) {
    const glm::dvec3 n = -(glm::transpose(light.axes) * normal);
    const double t = std::tan(light.angular_radius);
    return {{n.x * t, n.y * t, n.z}};
}

double hidden_share(std::span<const ConvexPart> parts, double angular_radius) {
    std::vector<const ConvexPart*> seen;
    std::vector<glm::dvec3> lines;
    for (const ConvexPart& part : parts) {
        if (part.empty()) continue;
        bool beside = false;
        for (const glm::dvec3& l : part) beside |= l.z <= -std::hypot(l.x, l.y);
        if (beside) continue;
        seen.push_back(&part);
        for (const glm::dvec3& l : part)
            if (std::abs(l.z) < std::hypot(l.x, l.y)) lines.push_back(l);
    }
    // Angles t of the places x = sin t, which makes the rim's ends smooth.
    std::vector<double> cuts = {-std::numbers::pi / 2, std::numbers::pi / 2};
    const auto cut = [&](double x) {
        if (x > -1 && x < 1) cuts.push_back(std::asin(x));
    };
    for (size_t i = 0; i < lines.size(); ++i) {
        const glm::dvec3& a = lines[i];
        const double square = a.x * a.x + a.y * a.y;
        const double along = std::abs(a.y) * std::sqrt(std::max(square - a.z * a.z, 0.0)) / square;
        cut(-a.x * a.z / square - along);
        cut(-a.x * a.z / square + along);
        if (a.y == 0) cut(-a.z / a.x);
        for (size_t k = 0; k < i; ++k) {
            const glm::dvec3 crossing = glm::cross(a, lines[k]);
            if (crossing.z == 0) continue;
            const glm::dvec2 p(crossing.x / crossing.z, crossing.y / crossing.z);
            if (glm::dot(p, p) < 1) cut(p.x);
        }
    }
    std::sort(cuts.begin(), cuts.end());

    const double t = std::tan(angular_radius);
    std::vector<Interval> column;
    const auto covered = [&](double angle) {
        const double x = std::sin(angle), rim = std::cos(angle);
        column.clear();
        for (const ConvexPart* part : seen)
            if (const auto interval = column_of(*part, x, rim)) column.push_back(*interval);
        std::sort(column.begin(), column.end(),
                  [](const Interval& a, const Interval& b) { return a.low < b.low; });
        double sum = 0, reached = -rim;
        for (const Interval& i : column) {
            const double low = std::max(i.low, reached);
            if (i.high > low) sum += column_integral(x, i.high, t) - column_integral(x, low, t);
            reached = std::max(reached, i.high);
        }
        return sum * rim;  // dx = cos t dt
    };
    double sum = 0;
    for (size_t i = 1; i < cuts.size(); ++i) {
        const double width = cuts[i] - cuts[i - 1];
        if (width < 1e-14) continue;
        const int pieces = 1 + int(width / 0.4);
        for (int piece = 0; piece < pieces; ++piece) {
            const double half = 0.5 * width / pieces, middle = cuts[i - 1] + (2 * piece + 1) * half;
            for (size_t k = 0; k < places.size(); ++k)
                sum += half * weights[k] *
                       (covered(middle - half * places[k]) + covered(middle + half * places[k]));
        }
    }
    const double s = std::sin(angular_radius / 2);
    const double whole =
        angular_radius > 0 ? 4 * std::numbers::pi * s * s / (t * t) : std::numbers::pi;  // 2 pi (1 - cos a)
    return std::clamp(sum / whole, 0.0, 1.0);
}

}  // namespace penumbra::test
