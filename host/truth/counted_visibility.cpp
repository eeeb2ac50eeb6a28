// SPDX-License-Identifier: MIT
// The triangles that may hide a part of the sun are found once per point; every direction near one of them is
// then asked of it, by the signs of three determinants. A direction on an edge that two triangles share has
// the same determinant in both up to its sign, so that no direction slips between them.
#include "host/truth/counted_visibility.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "host/generated/noise.h"
#include "host/truth/concentric_disc.h"
#include "host/truth/tree_boxes.h"

namespace penumbra {
namespace {

using Corners = std::array<glm::dvec3, 3>;

Corners corners_from(const Triangle& triangle, const glm::dvec3& origin) {
    Corners out;
    for (size_t i = 0; i < 3; ++i)
        out[i] = glm::dvec3(triangle.v[i][0], triangle.v[i][1], triangle.v[i][2]) - origin;
    return out;
}

double taxi(const glm::dvec3& v) {
    return std::abs(v.x) + std::abs(v.y) + std::abs(v.z);
}

// The point of a triangle nearest to the origin: Ericson 2005, "Real-Time Collision Detection", 5.1.5, by the
// regions of corners and edges.
glm::dvec3 nearest_to_origin(const Corners& v) {
    const auto& [a, b, c] = v;
    const glm::dvec3 ab = b - a, ac = c - a;
    const double d1 = -glm::dot(ab, a), d2 = -glm::dot(ac, a);
    if (d1 <= 0 && d2 <= 0) return a;
    const double d3 = -glm::dot(ab, b), d4 = -glm::dot(ac, b);
    if (d3 >= 0 && d4 <= d3) return b;
    const double d5 = -glm::dot(ab, c), d6 = -glm::dot(ac, c);
    if (d6 >= 0 && d5 <= d6) return c;
    const double at_c = d1 * d4 - d3 * d2, at_b = d5 * d2 - d1 * d6, at_a = d3 * d6 - d5 * d4;
    if (at_c <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
    if (at_b <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
    if (at_a <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / (d4 - d3 + d5 - d6) * (c - b);
    const double sum = at_a + at_b + at_c;
    return a + at_b / sum * ab + at_c / sum * ac;
}

// Directions in strata that lie together, and how far they are from their axis; those that are still free.
struct Bundle {
    std::span<glm::dvec3> free;
    glm::dvec3 axis{0};
    double reach = 0;

    explicit Bundle(std::span<glm::dvec3> directions) : free(directions) {
        for (const glm::dvec3& d : free) axis += d;
        axis /= static_cast<double>(free.size());
        double reach2 = 0;
        for (const glm::dvec3& d : free) reach2 = std::max(reach2, glm::dot(d - axis, d - axis));
        reach = std::sqrt(reach2) + 0x1p-48;  // what products round by, with room
    }
    // As many as were erased.
    size_t erase_if(const auto& hidden) {
        const auto left = std::remove_if(free.begin(), free.end(), hidden);
        const auto gone = static_cast<size_t>(free.end() - left);
        free = free.first(free.size() - gone);
        return gone;
    }
};

// Determinants of a direction with two corners each, of the sign of the triangle's height over the origin:
// all are positive where the direction meets the triangle ahead.
struct Lines {
    std::array<glm::dvec3, 3> line;
    std::array<double, 3> length;

    Lines(const Corners& v, double height) {
        for (size_t i = 0; i < 3; ++i) {
            line[i] = glm::cross(v[(i + 1) % 3], v[(i + 2) % 3]);
            if (height < 0) line[i] = -line[i];
            length[i] = glm::length(line[i]);
        }
    }
    // Whether one weight is negative for every direction that is within `reach` of the axis.
    bool beside(const glm::dvec3& axis, double reach) const {
        for (size_t i = 0; i < 3; ++i)
            if (glm::dot(line[i], axis) < -reach * length[i]) return true;
        return false;
    }
    bool beside(const Bundle& bundle) const { return beside(bundle.axis, bundle.reach); }
    glm::dvec3 weights(const glm::dvec3& d) const {
        return {glm::dot(line[0], d), glm::dot(line[1], d), glm::dot(line[2], d)};
    }
};

// The triangle is met ahead.
bool is_inside(const glm::dvec3& weights) {
    return weights.x >= 0 && weights.y >= 0 && weights.z >= 0;
}
std::array<double, 3> of_corners(const glm::dvec3& weights) {
    const double sum = weights.x + weights.y + weights.z;
    return {weights.x / sum, weights.y / sum, weights.z / sum};
}

double height_over_origin(const Corners& v) {
    return glm::dot(glm::cross(v[1] - v[0], v[2] - v[0]), v[0]);
}

// Within what corners' rounding to single precision makes of a plane through the origin: surfaces that were
// meant to lie in one plane do not hide each other, whatever turned them. Each of a corner's coordinates is
// off by 2^-24 of itself, and so is the surface that the origin lies on.
bool in_plane_of_origin(const Corners& v, double height, const glm::dvec3& origin) {
    double farthest = 0;
    for (const glm::dvec3& corner : v)
        for (int k = 0; k < 3; ++k) farthest = std::max(farthest, std::abs(corner[k] + origin[k]));
    return std::abs(height) <= 0x1p-23 * farthest * taxi(glm::cross(v[1] - v[0], v[2] - v[0]));
}

glm::dmat3 frame_around(const glm::dvec3& axis) {
    const glm::dvec3 helper = std::abs(axis.z) < 0.7 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
    const glm::dvec3 x = glm::normalize(glm::cross(helper, axis));
    return {x, glm::cross(axis, x), axis};
}

struct Directions {
    std::vector<glm::dvec3> all;
    std::vector<Bundle> bundles;  // of `all`
};

// By the cap's equal-area map: 1 - cos(t) = 2 r^2 sin^2(a / 2) for the disc's radius r, with nothing that
// cancels for a small sun. About as many bundles as directions in each.
Directions directions(const SunStrata& sun) {
    const glm::dmat3 axes = frame_around(sun.to_sun);
    const double h = std::sin(0.5 * sun.angular_radius);
    const auto direction = [&](uint32_t x, uint32_t y) {
        const uint32_t first = pcg(sun.seed + pcg(y * sun.side + x)), second = pcg(first);
        const glm::dvec2 disc =
            concentric_disc((x + first * 0x1p-32) / sun.side, (y + second * 0x1p-32) / sun.side);
        const double v = 2 * h * h * glm::dot(disc, disc);
        return axes * glm::dvec3(disc * (h * std::sqrt(2 * (2 - v))), 1 - v);
    };
    Directions out;
    out.all.reserve(size_t{sun.side} * sun.side);
    const auto width = static_cast<uint32_t>(std::ceil(std::sqrt(sun.side)));
    for (uint32_t y0 = 0; y0 < sun.side; y0 += width)
        for (uint32_t x0 = 0; x0 < sun.side; x0 += width) {
            const size_t first = out.all.size();
            for (uint32_t y = y0; y < std::min(y0 + width, sun.side); ++y)
                for (uint32_t x = x0; x < std::min(x0 + width, sun.side); ++x)
                    out.all.push_back(direction(x, y));
            out.bundles.emplace_back(std::span(out.all).subspan(first));
        }
    return out;
}

// Nothing where the triangle lies beside the whole sun, or in a plane with the point: no direction has to be
// asked.
std::optional<Lines> lines_before(const Triangle& triangle, const glm::dvec3& at, const SunStrata& sun,
                                  double sine) {
    const Corners v = corners_from(triangle, at);
    const double height = height_over_origin(v);
    if (in_plane_of_origin(v, height, at)) return std::nullopt;
    const Lines lines(v, height);
    if (lines.beside(sun.to_sun, sine)) return std::nullopt;
    return lines;
}

}  // namespace

CountedVisibility::CountedVisibility(const Scene& scene, double frame) {
    opaque_.triangles = scene.triangles(frame);
    opaque_.bvh = build_bvh(opaque_.triangles, scene.triangle_objects());
    const Model& model = scene.model();
    const std::vector<glm::dmat4> world = scene.transforms(frame);
    for (const Instance& instance : scene.instances()) {
        const bool mirrored = glm::determinant(glm::dmat3(world[static_cast<size_t>(instance.node)])) < 0;
        const auto one_side = static_cast<int8_t>(mirrored ? -1 : 1);
        for (const Part& part : model.meshes[static_cast<size_t>(instance.mesh)].parts)
            front_.insert(front_.end(), part.indices.size() / 3, part.single_sided ? one_side : int8_t{0});
    }
    if (has_alpha(scene)) alpha_ = make_scene_alpha(scene);
    if (!scene.has_translucent()) return;
    translucent_.triangles = scene.translucent_triangles(frame);
    translucent_.bvh = build_bvh(translucent_.triangles);
    translucents_ = make_scene_translucents(scene);
    uint32_t index = 0;
    for (const Instance& instance : scene.instances())
        for (const Part& part : model.meshes[static_cast<size_t>(instance.mesh)].parts) {
            const bool translucent = scene.translucent(part);
            const bool drawn = translucent && scene.has_opaque_texels(part);
            for (size_t i = 0; i < part.indices.size(); i += 3, ++index)
                if (translucent) drawn_.push_back(drawn ? std::optional(index) : std::nullopt);
        }
}

template <class Touches, class Visit>
void CountedVisibility::Tree::walk(const Touches& touches, Visit&& visit) const {
    std::array<uint32_t, 4 * max_bvh_depth> stack{0};
    for (size_t pending = 1; pending > 0;) {
        const Texel* node = &bvh.nodes[size_t{stack[--pending]} * 3];
        for (uint32_t k = 0; k < 4; ++k) {
            const bool is_node = node[0][3] >> (24 + k) & 1, is_leaf = node[0][3] >> (28 + k) & 1;
            if (!(is_node || is_leaf) || !touches(child_box(node, k))) continue;
            if (is_node) {
                stack[pending++] = (node[1][0] >> 2) + k;
                continue;
            }
            const std::array<uint32_t, 4>& c = bvh.corners[node[1][1] + k];
            visit(c[0] / 3);
            if (c[3] != c[2]) visit(c[3] / 3);
        }
    }
}

std::optional<SurfacePoint> CountedVisibility::shown(const ViewRay& ray, double view_depth,
                                                     const glm::dvec3& normal) const {
    const glm::dvec3 point = ray.origin + view_depth * ray.direction;
    const double pixel = ray.pixel_m + view_depth * ray.pixel_m_per_m;
    const double facing = std::abs(glm::dot(normal, glm::normalize(ray.direction)));
    const double reach_px = ray.grid_px * std::max(8.0, 2 / std::max(facing, 1.0 / 64));
    // Depths are floats: what they round by is far less than a pixel, except at grazing views.
    const glm::dvec3 margin(reach_px * pixel + 0x1p-20 * (taxi(point) + view_depth));
    const auto near_point = [&](const TreeBox& box) {
        return glm::all(glm::lessThanEqual(box.lo - margin, point)) &&
               glm::all(glm::greaterThanEqual(box.hi + margin, point));
    };
    double least = INFINITY;
    std::optional<SurfacePoint> out;
    const auto look = [&](const Triangle& triangle, uint32_t index) {
        const Corners v = corners_from(triangle, point);
        const glm::dvec3 winding = glm::cross(v[1] - v[0], v[2] - v[0]);
        if (!(glm::dot(winding, winding) > 0) || !is_drawn(index, winding, ray.direction)) return;
        const glm::dvec3 n = glm::normalize(winding), nearest = nearest_to_origin(v);
        if (glm::length(nearest) > margin.x) return;
        // What shows the viewer its other side is not what the rasteriser saw, which at a silhouette may be
        // what lies behind it.
        const double slope = glm::dot(n, ray.direction);
        const glm::dvec3 shown = slope > 0 ? -n : n;
        if (!(glm::dot(shown, normal) > 0)) return;
        // At an edge between two triangles both are as near; the normal says which one it was.
        const double unlike = glm::length(nearest) / margin.x + 1e3 * (1 - glm::dot(shown, normal));
        if (unlike >= least) return;
        least = unlike;
        const glm::dvec3 met = glm::dot(n, v[0]) / slope * ray.direction;  // from `point` along the ray
        const Corners from_met = corners_from(triangle, point + met);
        const bool inside = std::isfinite(met.x) && glm::length(met) <= 64 * margin.x &&
                            glm::length(nearest_to_origin(from_met)) <= 0x1p-40 * taxi(point);
        out = {point + (inside ? met : nearest), shown, index};
    };
    opaque_.walk(near_point, [&](uint32_t index) { look(opaque_.triangles[index], index); });
    if (translucents_)
        translucent_.walk(near_point, [&](uint32_t index) {
            if (drawn_[index]) look(translucent_.triangles[index], *drawn_[index]);
        });
    if (!out) return out;
    const glm::dvec3 to_viewer = -ray.direction;
    opaque_.walk(near_point, [&](uint32_t index) {
        const Corners v = corners_from(opaque_.triangles[index], out->at);
        const double height = height_over_origin(v);
        const glm::dvec3 winding = glm::cross(v[1] - v[0], v[2] - v[0]);
        if (index == out->triangle || in_plane_of_origin(v, height, out->at)) return;
        if (!is_drawn(index, winding, ray.direction))
            return;  // seen through by right, wherever its outline lies
        if (!(std::abs(height) <= margin.x * glm::length(winding))) return;
        const glm::dvec3 w = Lines(v, height).weights(to_viewer);
        const uint32_t record = alpha_ ? alpha_->record_of[index] : 0;
        if (is_inside(w) && (record == 0 || alpha_->blocks(record - 1, of_corners(w))))
            out->seen_through.push_back(index);
    });
    return out;
}

std::vector<uint32_t> CountedVisibility::Tree::before(const SurfacePoint& point, const SunStrata& sun) const {
    const TreeCone cone{point.at, sun.to_sun, std::cos(sun.angular_radius), std::sin(sun.angular_radius)};
    std::vector<uint32_t> out;
    walk([&](const TreeBox& box) { return cone.may_touch(box); },
         [&](uint32_t index) { out.push_back(index); });
    return out;
}

CountedVisibility::Seen CountedVisibility::seen(const SurfacePoint& point, const SunStrata& sun) const {
    const double sine = std::sin(sun.angular_radius), leaves_by = glm::dot(point.normal, sun.to_sun);
    if (leaves_by <= -sine) return {0, glm::dvec3(0)};
    std::vector<uint32_t> opaque = opaque_.before(point, sun);
    std::erase_if(opaque, [&](uint32_t index) {
        return index == point.triangle ||
               std::ranges::find(point.seen_through, index) != point.seen_through.end();
    });
    const std::vector<uint32_t> coloured =
        translucents_ ? translucent_.before(point, sun) : std::vector<uint32_t>{};
    if (opaque.empty() && coloured.empty() && leaves_by > sine) return {1, glm::dvec3(1)};

    Directions sky = directions(sun);
    size_t free = sky.all.size();
    for (Bundle& bundle : sky.bundles)
        free -= bundle.erase_if([&](const glm::dvec3& d) { return glm::dot(point.normal, d) <= 0; });
    for (const uint32_t index : opaque) {
        if (free == 0) break;
        const auto lines = lines_before(opaque_.triangles[index], point.at, sun, sine);
        if (!lines) continue;
        const uint32_t record = alpha_ ? alpha_->record_of[index] : 0;
        const auto hidden = [&](const glm::dvec3& d) {
            const glm::dvec3 w = lines->weights(d);
            return is_inside(w) && (record == 0 || alpha_->blocks(record - 1, of_corners(w)));
        };
        for (Bundle& bundle : sky.bundles)
            if (!lines->beside(bundle)) free -= bundle.erase_if(hidden);
    }
    const auto count = static_cast<double>(sky.all.size());
    const double visibility = static_cast<double>(free) / count;
    if (coloured.empty()) return {visibility, glm::dvec3(visibility)};
    std::vector<glm::dvec3> light(sky.all.size(), glm::dvec3(1));
    const auto light_of = [&](const Bundle& bundle) {
        return std::span(light).subspan(static_cast<size_t>(bundle.free.data() - sky.all.data()),
                                        bundle.free.size());
    };
    for (const uint32_t index : coloured) {
        const auto lines = lines_before(translucent_.triangles[index], point.at, sun, sine);
        if (!lines) continue;
        for (const Bundle& bundle : sky.bundles) {
            if (lines->beside(bundle)) continue;
            for (size_t i = 0; i < bundle.free.size(); ++i)
                if (const glm::dvec3 w = lines->weights(bundle.free[i]); is_inside(w))
                    light_of(bundle)[i] *= translucents_->transmittance(index, of_corners(w));
        }
    }
    glm::dvec3 sum(0);
    for (const Bundle& bundle : sky.bundles)
        for (const glm::dvec3& arriving : light_of(bundle)) sum += arriving;
    return {visibility, sum / count};
}

}  // namespace penumbra
