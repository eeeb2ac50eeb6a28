// SPDX-License-Identifier: MIT
// Slices, spheres and texel grids.
#include "host/cascades/cascade_fit.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>

namespace penumbra {

namespace {

// Split distances between a logarithmic and an even spacing (Zhang et al. 2006, "Parallel-Split Shadow
// Maps").
constexpr double split_logarithmic = 0.8;
// The first slice starts here at the latest, as a share of the last one's end: a near plane of a few
// millimetres must not spend a map on the air before the lens.
constexpr double least_near = 1.0 / 200;
// A search about a receiver reaches at least this far, so that a small sun does not leave the borders bare.
const double least_search = std::tan(glm::radians(0.5));
constexpr double texels_of_snapping = 2;  // the corner moves by less than one; one more for rounding

struct Slice {
    double begin = 0, end = 0;
};

bool finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

struct Box2 {
    glm::dvec3 low{INFINITY}, high{-INFINITY};
};

Box2 in_light(const LightFrame& light, const glm::dvec3& low, const glm::dvec3& high) {
    Box2 box;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p =
            light.of({corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z});
        box.low = glm::min(box.low, p);
        box.high = glm::max(box.high, p);
    }
    return box;
}

// Rounded up to a half power of two: the slices keep their size while the camera moves about.
double stable_length(double metres) {
    return std::exp2(std::ceil(2 * std::log2(metres)) / 2);
}

// How far the scene reaches from the camera, whichever way that looks: turning it must not move a split.
// 0: the whole scene lies behind.
double farthest(const CascadeRequest& request) {
    const glm::dvec3 forward = -glm::make_vec3(request.camera.world_from_view.data() + 6);
    const glm::dvec3 position = glm::make_vec3(request.camera.position.data());
    double distance = 0;
    bool ahead = false;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p{corner & 1 ? request.high.x : request.low.x,
                           corner & 2 ? request.high.y : request.low.y,
                           corner & 4 ? request.high.z : request.low.z};
        distance = std::max(distance, glm::distance(p, position));
        ahead = ahead || glm::dot(forward, p - position) > request.camera.near_m;
    }
    return ahead ? distance : 0;
}

// The smallest sphere about a slice whose centre lies on the view axis. `spread`: squared tangent of the
// angle between the axis and the frustum's edges. The centre is as far from the near corners as from the far
// ones, or in the far plane where the slice is wider than deep.
struct Sphere {
    double distance = 0, radius = 0;
};
Sphere sphere_about(const Slice& slice, double spread) {
    const double distance = std::min((slice.end + slice.begin) * (1 + spread) / 2, slice.end);
    return {distance, std::hypot(slice.end - distance, slice.end * std::sqrt(spread))};
}

CascadeArea snapped(const glm::dvec2& centre, double half, uint32_t size) {
    CascadeArea area;
    area.texel_m = 2 * half / (size - texels_of_snapping);
    const glm::dvec2 corner = centre - half;
    area.corner = (glm::floor(corner / area.texel_m) - 0.5 * (texels_of_snapping - 1)) * area.texel_m;
    return area;
}

bool usable(const CascadeArea& area) {
    return area.texel_m > 0 && std::isfinite(area.texel_m) && std::isfinite(area.corner.x) &&
           std::isfinite(area.corner.y);
}

}  // namespace

LightFrame light_frame(const glm::dvec3& to_sun) {
    const glm::dvec3 n = to_sun;
    const double sign = std::copysign(1.0, n.z);
    const double a = -1 / (sign + n.z), b = n.x * n.y * a;
    return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, -n};
}

CascadeFit fit_cascades(const CascadeRequest& request) {
    CascadeFit fit;
    fit.size = request.size;
    const bool scene = finite(request.low) && finite(request.high) &&
                       glm::all(glm::lessThanEqual(request.low, request.high));
    const bool sun = finite(request.to_sun) && std::abs(glm::length(request.to_sun) - 1) < 1e-3 &&
                     request.angular_radius >= 0 && request.angular_radius < glm::radians(90.0);
    const glm::dvec3 camera = glm::make_vec3(request.camera.position.data());
    if (!scene || !sun || !finite(camera) || request.size < 8) return fit;

    fit.light = light_frame(request.to_sun);
    const Box2 box = in_light(fit.light, request.low, request.high);
    // A scene without any depth or width gets some: a part of its extent, and of its distance from the origin
    // that the coordinates' own digits resolve.
    const double extent = std::max({box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z});
    const double least =
        std::max({1e-3 * extent, 1e-9 * glm::length(glm::max(glm::abs(box.low), glm::abs(box.high))), 1e-6});
    const double depth = std::max(box.high.z - box.low.z, least);
    fit.near_m = box.low.z - 1e-3 * depth;  // fp32 positions of the topmost caster stay below depth 0
    fit.depth_m = 1.002 * depth;
    const double search = fit.depth_m * std::max(std::tan(request.angular_radius), least_search);
    if (!std::isfinite(search)) return fit;

    const glm::dvec2 low(box.low), high(box.high);
    const double half = std::max({0.5 * (high.x - low.x), 0.5 * (high.y - low.y), least}) + search;
    const CascadeArea whole = snapped(0.5 * (low + high), half, request.size);
    fit.areas[0] = whole;
    fit.count = usable(whole) ? 1 : 0;
    const double far = farthest(request);
    if (request.orthographic || !(far > request.camera.near_m)) return fit;

    const double end = stable_length(far), begin = std::max(request.camera.near_m, least_near * end);
    const auto* clip = request.camera.clip_from_view.data();
    const double spread = 1 / (clip[0] * clip[0]) + 1 / (clip[5] * clip[5]);
    const glm::dvec3 forward = -glm::make_vec3(request.camera.world_from_view.data() + 6);
    CascadeFit sliced = fit;
    sliced.count = 0;
    Slice slice{begin, begin};
    for (uint32_t i = 0; i < max_cascades; ++i) {
        const double share = double(i + 1) / max_cascades;
        slice = {
            i == 0 ? request.camera.near_m : slice.end,
            glm::mix(begin + (end - begin) * share, begin * std::pow(end / begin, share), split_logarithmic)};
        const Sphere sphere = sphere_about(slice, spread);
        const glm::dvec3 centre = fit.light.of(camera + forward * sphere.distance);
        const CascadeArea area = snapped(glm::dvec2(centre), sphere.radius + search, request.size);
        // From here on the whole scene's map is as fine, and it holds everything.
        if (!usable(area) || area.texel_m >= whole.texel_m) break;
        sliced.areas[sliced.count++] = area;
    }
    if (sliced.count == 0) return fit;
    if (sliced.count < max_cascades) sliced.areas[sliced.count++] = whole;
    return sliced;
}

glm::dmat4x3 texels_from_metres(const CascadeFit& fit, uint32_t cascade, const glm::dvec3& origin) {
    const CascadeArea& area = fit.areas[cascade];
    const glm::dvec3 at = fit.light.of(origin);
    const glm::dvec3 shift((at.x - area.corner.x) / area.texel_m, (at.y - area.corner.y) / area.texel_m,
                           at.z - fit.near_m);
    const glm::dmat3 rows(fit.light.u / area.texel_m, fit.light.v / area.texel_m, fit.light.away);
    const glm::dmat3 linear = glm::transpose(rows);
    return {linear[0], linear[1], linear[2], shift};
}

blocks::Cascades cascade_block(const CascadeFit& fit, const glm::dvec3& camera) {
    blocks::Cascades block{};
    block.count = fit.count;
    for (uint32_t i = 0; i < fit.count; ++i) {
        const glm::dmat4x3 map = texels_from_metres(fit, i, camera);
        const double scale[] = {1.0 / fit.size, 1.0 / fit.size, 1 / fit.depth_m};
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 4; ++column)
                block.c[i].map.columns[row][column] = static_cast<float>(map[column][row] * scale[row]);
        block.c[i].texel_m = static_cast<float>(fit.areas[i].texel_m);
        block.c[i].depth_m = static_cast<float>(fit.depth_m);
    }
    return block;
}

}  // namespace penumbra
