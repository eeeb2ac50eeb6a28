// SPDX-License-Identifier: MIT
// Directions are those of visible normals (Dupuy and Benyoub 2023, "Sampling Visible
// GGX Normals with Spherical Caps"), at the middles of an even grid of numbers: their weight, response over
// density, is a ratio of Smith's terms and never large.
#include "nodes/tables/environment_brdf.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace penumbra {
namespace {

constexpr int grid = 96;  // along either number; of the azimuth one half, since the other mirrors it
constexpr double least_alpha = 1e-4;  // LEAST_ALPHA of lobe.glsl

double smith_lambda(double cosine, double alpha) {
    const double c2 = std::max(cosine * cosine, 1e-12);
    return 0.5 * std::sqrt(1 + alpha * alpha * std::max(1 - c2, 0.0) / c2) - 0.5;
}

}  // namespace

EnvironmentBrdf environment_brdf(double n_v, double roughness) {
    const double alpha = std::max(roughness * roughness, least_alpha), vz = std::max(n_v, 1e-4),
                 vx = std::sqrt(1 - vz * vz), length = std::hypot(alpha * vx, vz), sx = alpha * vx / length,
                 sz = vz / length, visible = 1 + smith_lambda(vz, alpha);
    EnvironmentBrdf sum;
    for (int i = 0; i < grid; ++i)
        for (int j = 0; j < grid; ++j) {
            const double azimuth = std::numbers::pi * (i + 0.5) / grid,
                         z = (1 - (j + 0.5) / grid) * (1 + sz) - sz, r = std::sqrt(std::max(1 - z * z, 0.0));
            const double hx = alpha * (r * std::cos(azimuth) + sx), hy = alpha * r * std::sin(azimuth),
                         hz = std::max(z + sz, 0.0), h = std::sqrt(hx * hx + hy * hy + hz * hz),
                         v_h = (vx * hx + vz * hz) / h, lz = 2 * v_h * hz / h - vz;
            if (!(lz > 0)) continue;
            const double weight = visible / (visible + smith_lambda(lz, alpha)) / (grid * grid);
            sum.white += weight;
            sum.grazing += weight * std::pow(std::max(1 - v_h, 0.0), 5);
        }
    return sum;
}

std::vector<float> environment_brdf_table() {
    std::vector<float> out;
    for (uint32_t y = 0; y < environment_brdf_size[1]; ++y)
        for (uint32_t x = 0; x < environment_brdf_size[0]; ++x) {
            const EnvironmentBrdf b = environment_brdf(double(x) / (environment_brdf_size[0] - 1),
                                                       double(y) / (environment_brdf_size[1] - 1));
            out.push_back(static_cast<float>(b.white));
            out.push_back(static_cast<float>(b.grazing));
        }
    return out;
}

EnvironmentBrdf look_up(const std::vector<float>& table, double n_v, double roughness) {
    const double x = std::clamp(n_v, 0.0, 1.0) * (environment_brdf_size[0] - 1),
                 y = std::clamp(roughness, 0.0, 1.0) * (environment_brdf_size[1] - 1);
    const auto column = static_cast<uint32_t>(x), row = static_cast<uint32_t>(y);
    EnvironmentBrdf out;
    for (uint32_t v = 0; v < 2; ++v)
        for (uint32_t u = 0; u < 2; ++u) {
            const double weight = (u ? x - column : 1 - (x - column)) * (v ? y - row : 1 - (y - row));
            const size_t at =
                2 * (size_t{std::min(row + v, environment_brdf_size[1] - 1)} * environment_brdf_size[0] +
                     std::min(column + u, environment_brdf_size[0] - 1));
            out.white += weight * static_cast<double>(table[at]);
            out.grazing += weight * static_cast<double>(table[at + 1]);
        }
    return out;
}

}  // namespace penumbra
