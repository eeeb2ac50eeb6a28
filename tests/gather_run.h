// SPDX-License-Identifier: MIT
// The node gather alone, on rays that a test casts itself: receivers of any tilt under a sun whose disc is
// partly covered by straight edges, so that every pixel's visibility is known in closed form. The rays, their
// hits and the sun's points are handed to the node as a tracer would.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <glm/gtc/packing.hpp>
#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <set>

#include "shaders/common/blocks.h"
#include "tests/gpu_test.h"
#include "tests/view_run.h"

namespace penumbra::test {

constexpr Extent extent{96, 64};
constexpr double small_sun_deg = 0.1;
constexpr double middle_m = 10;  // view depth of the image's centre

constexpr const char* gather_alone = R"({
  "penumbra": 1, "name": "gather_alone",
  "inputs": { "depth": {}, "normal": {}, "motion": {}, "sun": {}, "hits": {}, "receiver_words": {},
              "sunward_words": {}, "blockers": {}, "ray_points": {} },
  "outputs": ["state"],
  "nodes": {
    "guides": { "type": "guides" },
    "prepare": { "type": "prepare", "params": { "blocks": true } },
    "gather": { "type": "gather", "params": { "radius": RADIUS },
                "in": { "history": "state@-1", "idle_cells_prev": "idle_cells@-1",
                        "view_depth_prev": "view_depth@-1", "guide_normal_prev": "guide_normal@-1" } },
    "drift": { "type": "drift" }
  }
})";

// Columns: the axes across the light, and the sun (Duff et al. 2017, as sun_sample.glsl names it).
inline glm::dmat3 light_axes(const glm::dvec3& s) {
    const double sign = s.z >= 0 ? 1 : -1, a = -1 / (sign + s.z), b = s.x * s.y * a;
    return {glm::dvec3(1 + sign * s.x * s.x * a, sign * b, -sign * s.x),
            glm::dvec3(b, sign + s.y * s.y * a, -s.y), s};
}

// Share of a disc of radius 1 beyond a straight edge at `d` from its centre, positive: the centre is lit.
inline double disc_share(double d) {
    if (d >= 1) return 1;
    if (d <= -1) return 0;
    return 0.5 + (std::asin(d) + d * std::sqrt(1 - d * d)) / std::numbers::pi;
}

// An edge that hangs `distance_m` above the image's centre, seen from the sun at an angle.
struct HungEdge {
    double distance_m, angle_deg, offset_m = 0;
};

struct Setting {
    double tilt_deg = 0;
    std::vector<HungEdge> edges;
    uint32_t seed = 1;
    bool mirrored = false;                                 // hands over sun points with x negated
    int radius = 4;                                        // of the taps
    std::function<double(int x, int y)> step_m = nullptr;  // moves the receiver along its normal
    std::function<bool(int x, int y)> averted = nullptr;   // pixels that look away from the sun
    std::function<bool(int x, int y)> above = nullptr;     // pixels whose surface lies above the edges
    double sun_radius_deg = small_sun_deg;
    double sun_elevation_deg = 45;  // over the receiver
    double sun_azimuth_deg = 0;     // from the image's x axis
    uint32_t frame = 0;             // others know the one before
};

struct Receiver {
    glm::dvec3 normal, sun;
};

inline Receiver receiver_of(const Setting& setting) {
    const double tilt = glm::radians(setting.tilt_deg), elevation = glm::radians(setting.sun_elevation_deg),
                 azimuth = glm::radians(setting.sun_azimuth_deg);
    const glm::dvec3 n(0, std::sin(tilt), std::cos(tilt));
    const glm::dvec3 along = std::cos(azimuth) * glm::dvec3(1, 0, 0) +
                             std::sin(azimuth) * glm::dvec3(0, std::cos(tilt), -std::sin(tilt));
    return {n, std::sin(elevation) * n + std::cos(elevation) * along};
}

inline double pixel_m(const Camera& camera) {
    return middle_m * 2 / (extent.height * std::abs(camera.clip_from_view[5]));
}

inline Camera narrow_camera() {
    Camera camera = camera_at({0, 0, 0}, 0, extent);
    camera.clip_from_view[0] *= 40;
    camera.clip_from_view[5] *= 40;
    return camera;
}

// The distance at which the penumbra is `width_px` wide on a receiver seen face on and lit along its normal.
inline double distance_for(double width_px, double sun_radius_deg = small_sun_deg) {
    return 0.5 * width_px * pixel_m(narrow_camera()) / std::tan(glm::radians(sun_radius_deg));
}

// Whether the ray from `at` (light space, from the image's centre) to a point of the disc passes an edge.
inline bool is_lit(const HungEdge& edge, const glm::dvec3& at, double tangent, const glm::dvec2& point) {
    const double angle = glm::radians(edge.angle_deg);
    const glm::dvec2 across = glm::dvec2(at) + (edge.distance_m - at.z) * tangent * point;
    return glm::dot(across, glm::dvec2(std::cos(angle), std::sin(angle))) < edge.offset_m;
}

// By a grid of points: where edges and the receiver's own horizon cut the disc together.
inline double share_of_disc(const std::function<bool(const glm::dvec2&)>& lit) {
    constexpr int side = 40;
    int inside = 0, free = 0;
    for (int i = 0; i < side * side; ++i) {
        const glm::dvec2 q = (2.0 * (glm::dvec2(i % side, i / side) + 0.5)) / double(side) - 1.0;
        if (glm::dot(q, q) > 1) continue;
        ++inside;
        free += lit(q);
    }
    return double(free) / inside;
}

struct Result {
    std::vector<double> now, past, truth;
    std::vector<bool> bit, counted;
};

// `cpu`: with the workgroups of a software device, else of a GPU.
inline ViewRun run_with(int radius, bool cpu = true) {
    std::string text = gather_alone;
    text.replace(text.find("RADIUS"), 6, std::to_string(radius));
    ViewRunOptions options;
    options.cpu = cpu;
    options.captures = {"gathered", "idle_cells", "cells", "block_blockers"};
    options.formats = {{"depth", Format::r32f}, {"normal", Format::rgba16f}};
    return ViewRun(shadow_pipeline(text), extent, options);
}

inline Result gather(ViewRun& run, const Setting& setting) {
    const Camera camera = narrow_camera();
    const Receiver receiver = receiver_of(setting);
    const glm::dvec3 n = receiver.normal, sun = receiver.sun;
    const double sun_radius = glm::radians(setting.sun_radius_deg), tangent = std::tan(sun_radius);
    const glm::dmat3 axes = light_axes(sun);
    const glm::dvec3 centre = glm::transpose(axes) * glm::dvec3(0, 0, -middle_m);

    std::mt19937 random(setting.seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::vector<uint32_t> points, given;
    while (points.size() < size_t{extent.width} * extent.height) {
        const glm::vec2 p(uniform(random), uniform(random));
        if (glm::dot(p, p) > 1) continue;
        points.push_back(glm::packSnorm2x16(p));
        given.push_back(glm::packSnorm2x16(setting.mirrored ? glm::vec2(-p.x, p.y) : p));
    }

    const size_t pixels = size_t{extent.width} * extent.height;
    const uint32_t across = extent.width / 8;
    Result result{
        {}, {}, std::vector<double>(pixels), std::vector<bool>(pixels), std::vector<bool>(pixels, true)};
    std::vector<float> depth(pixels);
    std::vector<uint32_t> hits(size_t{across} * (extent.height / 4), ~0u), receivers(hits.size(), ~0u),
        sunward(hits.size()), blockers(3 * hits.size());
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x) {
            const size_t i = size_t{y} * extent.width + x, word = size_t{y / 4} * across + x / 8;
            const glm::dvec2 ndc =
                2.0 * (glm::dvec2(x, y) + 0.5) / glm::dvec2(extent.width, extent.height) - 1.0;
            const glm::dvec3 way(ndc.x / camera.clip_from_view[0], ndc.y / camera.clip_from_view[5], -1);
            const double step = setting.step_m ? setting.step_m(int(x), int(y)) : 0;
            const double z = (n.z * -middle_m + step) / glm::dot(n, way);
            depth[i] = static_cast<float>(camera.near_m / z);
            const glm::dvec3 at = glm::transpose(axes) * (z * way) - centre;
            const glm::dvec2 point = glm::unpackSnorm2x16(points[i]);
            bool hit = false;
            double hit_m = 0;
            const auto meets_own_plane = [&](const glm::dvec2& q) {
                return glm::dot(n, axes * glm::dvec3(tangent * q, 1)) <= 0;
            };
            result.truth[i] = 1;
            for (const HungEdge& edge : setting.edges) {
                if (setting.above && setting.above(int(x), int(y))) break;
                const double angle = glm::radians(edge.angle_deg), height = edge.distance_m - at.z;
                const glm::dvec2 normal(std::cos(angle), std::sin(angle));
                const double rho = height * tangent,
                             inside = edge.offset_m - glm::dot(glm::dvec2(at), normal);
                // Edges never cover each other's part of the disc in these tests.
                result.truth[i] += disc_share(inside / rho) - 1;
                if (is_lit(edge, at, tangent, point)) continue;
                hit = true;
                hit_m = std::max(hit_m, height);
            }
            if (setting.sun_elevation_deg < setting.sun_radius_deg)
                result.truth[i] = share_of_disc([&](const glm::dvec2& q) {
                    return !meets_own_plane(q) &&
                           std::ranges::all_of(setting.edges, [&](const HungEdge& edge) {
                               return is_lit(edge, at, tangent, q);
                           });
                });
            hit = hit || meets_own_plane(point);
            const uint32_t bit = 1u << (y % 4 * 8 + x % 8);
            if (setting.averted && setting.averted(int(x), int(y))) {
                result.counted[i] = false;
                continue;  // dark, whatever the ray says
            }
            sunward[word] |= bit;
            result.bit[i] = !hit;
            if (!hit) hits[word] &= ~bit;
            if (hit_m > 0) {  // the receiver itself is no blocker
                const auto steps = static_cast<uint32_t>((std::log2(hit_m) + 32) * 64 + 0.5);
                blockers[3 * word] += 1;
                blockers[3 * word + 1] += steps;
                blockers[3 * word + 2] += steps * steps;
            }
        }
    run.set("depth", depth);
    run.set("normal", std::vector<uint64_t>(pixels, glm::packHalf4x16(glm::vec4(glm::vec3(n), 0))));
    run.set("motion", std::vector<uint64_t>(pixels, 0));
    const blocks::Sun block{{{float(sun.x), float(sun.y), float(sun.z)}}, float(sun_radius)};
    run.set("sun", std::as_bytes(std::span(&block, 1)));
    run.set("hits", hits);
    run.set("receiver_words", receivers);
    run.set("sunward_words", sunward);
    run.set("blockers", blockers);
    run.set("ray_points", given);
    run.frame(frame_between(camera, camera, extent, setting.frame, setting.frame == 0));
    const auto gathered = captured<std::array<uint32_t, 2>>(run.view(), "gathered");
    const auto idle_cells = captured<uint32_t>(run.view(), "idle_cells");
    const uint32_t cells_across = (extent.width + 3) / 4;
    for (uint32_t i = 0; i < pixels; ++i) {
        constexpr uint32_t not_idle = 0x00030001;  // others are their bits (common/shadow_state.glsl)
        const uint32_t x = i % extent.width, y = i / extent.width,
                       idle = idle_cells[y / 4 * cells_across + x / 4] ^ not_idle;
        const bool works = idle == not_idle;
        const double bit = idle >> (4 * (y % 4) + x % 4) & 1;
        result.now.push_back(works ? (gathered[i][0] & 0x7ff) / 2046.0 : bit);
        result.past.push_back(works ? (gathered[i][0] >> 11 & 0x7ff) / 2046.0 : bit);
    }
    return result;
}

inline bool in_penumbra(double v) {
    return v >= 1.0 / 256 && v <= 255.0 / 256;
}

struct Share {
    double signal = 0, error = 0;
    double n_eff() const { return signal / error; }
};

inline void add(Share& share, const Result& r, const std::function<bool(int, int)>& counted = {}) {
    for (size_t i = 0; i < r.now.size(); ++i) {
        if (!r.counted[i] || (counted && !counted(int(i % extent.width), int(i / extent.width)))) continue;
        if (in_penumbra(r.truth[i])) share.signal += r.truth[i] * (1 - r.truth[i]);
        share.error += (r.now[i] - r.truth[i]) * (r.now[i] - r.truth[i]);
    }
}

}  // namespace penumbra::test
