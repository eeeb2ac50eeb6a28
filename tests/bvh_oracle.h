// SPDX-License-Identifier: MIT
// The truth about a shadow ray in double precision, with a third answer for rays that meet an edge, or an end
// of the interval, closer than single-precision vertices can tell.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "host/bvh/bvh.h"

namespace penumbra::test {

enum class Truth { clear, blocked, either };

// The ray against one triangle. Distances to edges are measured across the ray; `tolerance` is relative to
// the largest distance from the ray's origin to a vertex, plus the origin's own magnitude (whose subtraction
// rounds).
inline Truth against(const Triangle& triangle, const Ray& ray, double tolerance) {
    double d[3], length = 0;
    for (int a = 0; a < 3; ++a) {
        d[a] = ray.direction[a];
        length += d[a] * d[a];
    }
    length = std::sqrt(length);
    for (double& x : d) x /= length;
    // Any frame across the ray will do.
    const int least = std::abs(d[0]) < std::abs(d[1]) ? (std::abs(d[0]) < std::abs(d[2]) ? 0 : 2)
                                                      : (std::abs(d[1]) < std::abs(d[2]) ? 1 : 2);
    const int i = (least + 1) % 3, j = (least + 2) % 3;
    const double r = std::hypot(d[i], d[j]);
    double u[3] = {}, v[3];
    u[i] = d[j] / r;
    u[j] = -d[i] / r;
    v[0] = d[1] * u[2] - d[2] * u[1];
    v[1] = d[2] * u[0] - d[0] * u[2];
    v[2] = d[0] * u[1] - d[1] * u[0];

    double x[3], y[3], z[3], scale = 0;
    for (int k = 0; k < 3; ++k) {
        double p[3];
        for (int a = 0; a < 3; ++a) {
            p[a] = double(triangle.v[k][a]) - ray.origin[a];
            scale = std::max(scale, std::abs(p[a]));
        }
        x[k] = p[0] * u[0] + p[1] * u[1] + p[2] * u[2];
        y[k] = p[0] * v[0] + p[1] * v[1] + p[2] * v[2];
        z[k] = p[0] * d[0] + p[1] * d[1] + p[2] * d[2];
    }
    const double near = tolerance * scale;
    const double area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
    const double sign = area < 0 ? -1 : 1;
    double inside = 1e300, edge[3];
    for (int k = 0; k < 3; ++k) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        edge[k] = sign * (x[a] * y[b] - x[b] * y[a]);
        inside = std::min(inside, edge[k] / std::max(std::hypot(x[b] - x[a], y[b] - y[a]), 1e-300));
    }
    // Outside of the triangle's shadow by more than rounding: also judged by its bounds, for triangles seen
    // edge-on, whose edge lines say nothing about where they end.
    const auto [x0, x1] = std::minmax({x[0], x[1], x[2]});
    const auto [y0, y1] = std::minmax({y[0], y[1], y[2]});
    if (inside < -near || x0 > near || x1 < -near || y0 > near || y1 < -near) return Truth::clear;
    const auto [z0, z1] = std::minmax({z[0], z[1], z[2]});
    if (z1 < ray.t_min * length - near || z0 > double(ray.t_max) * length + near) return Truth::clear;
    if (!(inside > near)) return Truth::either;
    const double t = (edge[0] * z[0] + edge[1] * z[1] + edge[2] * z[2]) / (edge[0] + edge[1] + edge[2]);
    // Rounding across the ray moves the hit along it, more so at grazing angles.
    const double slope = (z1 - z0) / std::max({inside, near});
    const double along = near * (1 + slope);
    // A triangle on both sides of the origin counts once its plane is ahead by its corners' rounding, and its
    // area, as the ray sees it, is beyond that too (bvh.glsl, bvh_plane_ahead(), with a little more than its
    // 2).
    const double rounding = 2.1 * 0x1p-24 * scale;
    double areas = 0;
    for (int k = 0; k < 3; ++k) {
        const auto side = [&](int corner, int axis) {
            return double(triangle.v[corner][axis % 3]) - triangle.v[0][axis % 3];
        };
        areas += std::abs(side(1, k + 1) * side(2, k + 2) - side(1, k + 2) * side(2, k + 1));
    }
    if (z0 < 0 && std::abs(area) < std::sqrt(3.0) * rounding * scale) return Truth::either;
    const double ahead = z0 < 0 ? rounding * areas / std::abs(area) : 0;
    if (t < ray.t_min * length - along || t > double(ray.t_max) * length + along) return Truth::clear;
    if (t < ray.t_min * length + std::max(along, ahead) || t > double(ray.t_max) * length - along)
        return Truth::either;
    return Truth::blocked;
}

inline Truth truth(std::span<const Triangle> triangles, const Ray& ray, double tolerance = 1e-6) {
    Truth answer = Truth::clear;
    for (const Triangle& t : triangles) {
        const Truth one = against(t, ray, tolerance);
        if (one == Truth::blocked) return one;
        if (one == Truth::either) answer = one;
    }
    return answer;
}

}  // namespace penumbra::test
