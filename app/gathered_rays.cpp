// SPDX-License-Identifier: MIT
#include "app/gathered_rays.h"

#include <algorithm>
#include <cmath>

#include "app/captured_values.h"
#include "host/metrics/decisions.h"

namespace penumbra {
namespace {

// As far off the asking pixel's plane, over its distance across it, a neighbour is another surface's.
constexpr double slope = 0.1;

// unpack_point() of sun_sample.glsl.
std::array<double, 2> point_of(uint32_t word) {
    return {static_cast<int16_t>(word & 0xffff) / 32767.0, static_cast<int16_t>(word >> 16) / 32767.0};
}

}  // namespace

size_t Gathered::counted() const {
    return static_cast<size_t>(std::ranges::count_if(rays, &GatheredRay::counts));
}

double Gathered::visibility() const {
    size_t lit = 0;
    for (const GatheredRay& ray : rays) lit += ray.counts() && ray.lit;
    return counted() ? double(lit) / double(counted()) : 1;
}

double Gathered::unsheared() const {
    size_t lit = 0, all = 0;
    for (const GatheredRay& ray : rays) {
        lit += ray.on_surface && ray.lit;
        all += ray.on_surface;
    }
    return all ? double(lit) / double(all) : 1;
}

const std::vector<std::string>& RayGatherer::captures() {
    static const std::vector<std::string> names{"view_depth", "receiver_normal", "hits", "ray_points",
                                                "blockers"};
    return names;
}

RayGatherer::RayGatherer(const Session& session, uint32_t frame)
    : size_{session.plan().extent.width, session.plan().extent.height},
      depth_(captured_values<float>(session, "view_depth")),
      place_(depth_.size()),
      normal_(depth_.size()),
      hits_(captured_values<uint32_t>(session, "hits")),
      points_(captured_values<uint32_t>(session, "ray_points")),
      blockers_(captured_values<uint32_t>(session, "blockers")) {
    const StandaloneFrame at = session.host().frame(frame, true);
    const std::vector<uint32_t> no_noise(16384);
    const auto normals = captured_values<std::array<float, 2>>(session, "receiver_normal");
    axes_ = sun_frame({at.sun.to_sun.v[0], at.sun.to_sun.v[1], at.sun.to_sun.v[2]});
    tangent_ = std::tan(at.sun.angular_radius);
    for (uint32_t y = 0; y < size_[1]; ++y)
        for (uint32_t x = 0; x < size_[0]; ++x) {
            const size_t p = index({x, y});
            if (!(depth_[p] > 0)) continue;
            const CoverageReceiver r = coverage_receiver(at, 0, no_noise, {{x, y}, depth_[p], normals[p]});
            place_[p] = r.start;
            normal_[p] = r.normal;
        }
}

// The mean of logarithms over the 3x3 tiles around; 0 where no ray has met anything (blockers.glsl).
double RayGatherer::blockers_m(std::array<uint32_t, 2> pixel) const {
    const auto columns = static_cast<int>((size_[0] + tile_width - 1) / tile_width),
               rows = static_cast<int>((size_[1] + tile_height - 1) / tile_height);
    const int tx = static_cast<int>(pixel[0] / tile_width), ty = static_cast<int>(pixel[1] / tile_height);
    double n = 0, sum = 0;
    for (int y = std::max(ty - 1, 0); y <= std::min(ty + 1, rows - 1); ++y)
        for (int x = std::max(tx - 1, 0); x <= std::min(tx + 1, columns - 1); ++x) {
            const size_t tile = 3 * (size_t(y) * static_cast<size_t>(columns) + size_t(x));
            n += blockers_[tile];
            sum += blockers_[tile + 1];
        }
    return n > 0 ? std::exp2(sum / n / 64 - 32) : 0;
}

std::optional<Gathered> RayGatherer::gather(std::array<uint32_t, 2> pixel) const {
    if (!shows_surface(pixel)) return std::nullopt;
    Gathered out;
    out.distance_m = blockers_m(pixel);
    if (out.distance_m == 0) return std::nullopt;
    const size_t p = index(pixel);
    const uint32_t columns = (size_[0] + tile_width - 1) / tile_width;
    for (int dy = -reach; dy <= reach; ++dy)
        for (int dx = -reach; dx <= reach; ++dx) {
            const int64_t x = int64_t{pixel[0]} + dx, y = int64_t{pixel[1]} + dy;
            GatheredRay ray{{dx, dy}};
            if (x >= 0 && y >= 0 && x < size_[0] && y < size_[1]) {
                const std::array<uint32_t, 2> q{static_cast<uint32_t>(x), static_cast<uint32_t>(y)};
                const size_t i = index(q);
                const glm::dvec3 to = place_[i] - place_[p];
                ray.on_surface = depth_[i] > 0 &&
                                 std::abs(glm::dot(to, normal_[p])) <= slope * glm::length(to) &&
                                 glm::dot(normal_[i], normal_[p]) > 0.9;
                const uint32_t word = hits_[size_t{q[1] / tile_height} * columns + q[0] / tile_width];
                ray.lit = (word >> (q[1] % tile_height * tile_width + q[0] % tile_width) & 1) == 0;
                ray.own = point_of(points_[i]);
                // At the blockers' height the neighbour's ray is as far across the light from the asking
                // pixel as they are apart, and as far again as its point of the sun leads it.
                const double left = out.distance_m - glm::dot(to, axes_[2]);
                for (int axis = 0; axis < 2; ++axis)
                    ray.seen[static_cast<size_t>(axis)] =
                        (glm::dot(to, axes_[axis]) + left * tangent_ * ray.own[static_cast<size_t>(axis)]) /
                        (out.distance_m * tangent_);
            }
            out.rays.push_back(ray);
        }
    return out;
}

}  // namespace penumbra
