// SPDX-License-Identifier: MIT
// Follows shaders/visibility/cover.comp and what it includes: ray_offset, blue_noise, sun_sample, light_mask,
// leaf_cover.
#include "host/truth/coverage.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <numbers>

#include "host/generated/noise.h"
#include "host/truth/octahedral.h"
#include "host/truth/tree_boxes.h"

namespace penumbra {
namespace {

using std::numbers::pi;

constexpr double unit_rounding = 0x1p-24;  // of the floats that the corners are kept in

glm::dvec3 vector(const float (&v)[3]) {
    return {v[0], v[1], v[2]};
}

double taxi(const glm::dvec3& v) {
    return std::abs(v.x) + std::abs(v.y) + std::abs(v.z);
}

// noise_unit(noise_fixed()) of blue_noise.glsl.
std::array<double, 2> noise(std::span<const uint32_t> tile, const std::array<uint32_t, 2>& pixel,
                            uint32_t frame, uint32_t seed) {
    const uint32_t x = pixel[0], y = pixel[1], shift = pcg(seed), first = pcg(seed ^ 0x9E3779B9u),
                   second = pcg(first);
    const uint32_t texel = tile[((y + (shift >> 7 & 127)) & 127) * 128 + ((x + (shift & 127)) & 127)];
    const auto wave = [](uint32_t turns) { return turns < 1u << 31 ? turns : 0u - turns; };
    const uint32_t u = (texel << 16) + 4 * wave(x * 15793805u) + 4 * wave(y * 15348762u) + x * 2717909u +
                       y * 4291279664u + frame * 2512169321u + first,
                   v = (texel & 0xFFFF0000u) + 4 * wave(x * 14621613u) + wave(y * 80021003u) +
                       x * 4294306274u + y * 4294571354u + frame * 1316278627u + second;
    return {(u >> 8) * 0x1p-24, (v >> 8) * 0x1p-24};
}

// A pixel's point as camera.glsl reconstructs it, relative to the camera, and how far off the surface rays
// start (ray_offset.glsl).
class Surface {
  public:
    Surface(const FrameDescription& frame, const CoveragePixel& pixel)
        : frame_(frame),
          clip_(glm::make_mat4(frame.camera.clip_from_view.data())),
          world_(glm::make_mat3(frame.camera.world_from_view.data())),
          pixel_(pixel),
          depth_(pixel.view_depth) {}

    glm::dvec3 relative() const { return at(depth_); }

    // Of a depth that is of the pixel's centre.
    double offset_m(const glm::dvec3& n, const glm::dvec3& in_scene) const {
        const glm::dvec3 largest = glm::max(glm::abs(relative()), glm::abs(in_scene));
        return 3 * 0x1p-23 * (largest.x + largest.y + largest.z + depth_) + 8 * depth_rounding() * facing(n);
    }
    glm::dvec3 off_surface(const glm::dvec3& n, const glm::dvec3& in_scene) const {
        return in_scene + n * offset_m(n, in_scene);
    }
    // Metres along the surface that its pixel may show beyond a triangle's end.
    double beyond_edge_m(const glm::dvec3& n) const {
        return grid_per_m() * (orthographic() ? 1 : depth_) / std::max(facing(n), 1.0 / 64);
    }
    // Metres along the unit vector `towards`, by which a ray leaves that behind.
    double ahead(const glm::dvec3& n, const glm::dvec3& towards) const {
        const double cosine = glm::dot(n, towards);
        return cosine > 0 ? beyond_edge_m(n) * std::min(0.25 / cosine, 1.0) : 0.0;
    }
    // From a place in the scene.
    glm::dvec3 to_viewer(const glm::dvec3& camera, const glm::dvec3& from) const {
        return orthographic() ? world_[2] : camera - from;
    }
    double grid_m(const glm::dvec3& way) const {
        return grid_per_m() * (orthographic() ? 1 : glm::length(way));
    }

    // most_inside_m() of looked_through.glsl, of a depth that is of the pixel's centre.
    double most_inside_m(const glm::dvec3& start, const glm::dvec3& way) const {
        return orthographic()
                   ? INFINITY
                   : 1.5 * grid_m(way) + 4.5 * 0x1p-23 * (taxi(start) + taxi(way) + glm::length(way));
    }

  private:
    double grid_per_m() const {
        return 2 / (frame_.size[1] * std::abs(clip_[1].y)) * std::ldexp(0.5, -int(frame_.sub_pixel_bits));
    }

    bool orthographic() const { return (frame_.flags & frame_orthographic) != 0; }

    double facing(const glm::dvec3& n) const {
        const glm::dvec3 viewer = orthographic() ? world_[2] : -glm::normalize(at(1));
        return std::abs(glm::dot(n, viewer));
    }

    glm::dvec3 at(double depth) const {
        const glm::dvec2 uv =
            (glm::dvec2(pixel_.at[0], pixel_.at[1]) + 0.5) / glm::dvec2(frame_.size[0], frame_.size[1]) -
            glm::dvec2(frame_.jitter[0], frame_.jitter[1]);
        const glm::dvec2 ndc = 2.0 * uv - 1.0, scale(clip_[0].x, clip_[1].y);
        const glm::dvec2 xy = orthographic() ? (ndc - glm::dvec2(clip_[3])) / scale
                                             : depth * (ndc + glm::dvec2(clip_[2])) / scale;
        return world_ * glm::dvec3(xy, -depth);
    }

    double depth_rounding() const {
        const double stored =
            orthographic() ? clip_[3].z - clip_[2].z * depth_ : clip_[3].z / depth_ - clip_[2].z;
        const double slope = orthographic() ? std::abs(clip_[2].z) : std::abs(clip_[3].z) / (depth_ * depth_);
        return unit_rounding * stored / slope;
    }

    const FrameDescription& frame_;
    glm::dmat4 clip_;
    glm::dmat3 world_;
    CoveragePixel pixel_;
    double depth_;
};

// Whether a triangle's plane is within its corners' rounding of the start, and then hides nothing
// (height_of() and height_for_sure() of leaf_cover.glsl). `a`, `b`, `c` relative to the start.
bool plane_in_doubt(double height, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    if (std::abs(height) > 16 * unit_rounding * taxi(b - a) * taxi(c - a) * taxi(a)) return false;
    const glm::dvec3 reach = glm::max(glm::max(glm::abs(a), glm::abs(b)), glm::abs(c));
    const double extent = std::max({reach.x, reach.y, reach.z});
    return !(std::abs(height) > 2 * unit_rounding * extent * taxi(glm::cross(b - a, c - a)));
}

// is_looked_through() of looked_through.glsl; corners relative to the start.
bool is_looked_through(const CoverageReceiver& r, const glm::dvec3& a, const glm::dvec3& b,
                       const glm::dvec3& c) {
    const glm::dvec3 n = glm::cross(b - a, c - a);
    const double above = glm::dot(n, a), depth = std::abs(above) / glm::length(n), side = above < 0 ? -1 : 1;
    if (!(depth <= r.beyond_edge_m) || !(side * glm::dot(n, r.to_viewer) > 0)) return false;
    const auto inside_m = [&](const glm::dvec3& from, const glm::dvec3& to) {
        const glm::dvec3 outwards = glm::cross(to - from, r.to_viewer);
        return side * glm::dot(from, outwards) / std::max(glm::length(outwards), 1e-30);
    };
    const double grids = std::max(1.5 * (1 - depth / (0.25 * r.beyond_edge_m)), 0.1);
    const double inside = std::min({inside_m(a, b), inside_m(b, c), inside_m(c, a)});
    return inside >= -grids * r.grid_m && inside <= r.most_inside_m;
}

}  // namespace

glm::dmat3 sun_frame(const glm::dvec3& s) {
    const double sign = s.z >= 0 ? 1 : -1, a = -1 / (sign + s.z), b = s.x * s.y * a;
    return {glm::dvec3(1 + sign * s.x * s.x * a, sign * b, -sign * s.x),
            glm::dvec3(b, sign + s.y * s.y * a, -s.y), s};
}

double start_offset_m(const StandaloneFrame& frame, const CoveragePixel& pixel) {
    const Surface surface(frame.description, pixel);
    return surface.offset_m(octahedral_normal(pixel.normal),
                            surface.relative() + vector(frame.scene.camera_from_origin.v));
}

CoverageReceiver coverage_receiver(const StandaloneFrame& frame, uint32_t seed,
                                   std::span<const uint32_t> blue_noise, const CoveragePixel& pixel) {
    const Surface surface(frame.description, pixel);
    CoverageReceiver r;
    r.normal = octahedral_normal(pixel.normal);
    const glm::dvec3 to_sun = vector(frame.sun.to_sun.v),
                     off_surface = surface.off_surface(
                         r.normal, surface.relative() + vector(frame.scene.camera_from_origin.v));
    r.start = glm::vec3(off_surface);  // floats, as the node's
    r.start_of_beam = glm::vec3(off_surface + surface.ahead(r.normal, to_sun) * to_sun);
    r.to_viewer = surface.to_viewer(vector(frame.scene.camera_from_origin.v), r.start);
    r.beyond_edge_m = surface.beyond_edge_m(r.normal);
    r.grid_m = surface.grid_m(r.to_viewer);
    r.most_inside_m = surface.most_inside_m(r.start, r.to_viewer);
    const auto [turn, dither] = noise(blue_noise, pixel.at, frame.description.index, seed);
    const glm::dmat3 axes = sun_frame(to_sun);
    const double c = std::cos(2 * pi * turn), s = std::sin(2 * pi * turn);
    r.axes = {c * axes[0] + s * axes[1], c * axes[1] - s * axes[0], axes[2]};
    r.dither = 0.002 + 0.996 * dither;  // line_dither() of light_mask.glsl
    r.angular_radius = frame.sun.angular_radius;
    return r;
}

SampledSun::SampledSun(uint32_t count)
    : samples_(light_samples(count)), half_planes_(half_plane_table(samples_)) {}

std::array<double, 2> SampledSun::place(uint32_t sample, double angular_radius) const {
    const auto [x, y] = samples_[sample];
    const double scale = 1 - 0.25 * angular_radius * angular_radius * (1 - x * x - y * y);
    return {x * scale, y * scale};
}

SampleMask SampledSun::positive_side(const glm::dvec3& line, double angular_radius, double dither) const {
    const bool flip = (line.y != 0 ? line.y : line.x) < 0;
    const glm::dvec3 e = flip ? -line : line;
    const double size = std::max(std::abs(e.x) + e.y, 1e-300), p = e.x / size;
    const double length = std::hypot(e.x, e.y) * std::tan(angular_radius);
    const double c = std::clamp(e.z / std::max(length, 1e-300), -1.0, 1.0);
    const double bulge = 0.25 * angular_radius * angular_radius;
    const double wanted = std::floor(count() * half_disc_area(c + bulge * c * (1 - c * c)) + dither);
    const auto k = static_cast<size_t>(std::clamp(wanted, 0.0, double(count())));
    const auto bin = std::min(static_cast<uint32_t>((0.9999 * p + 1) * 0.5 * HALF_PLANE_DIRECTIONS),
                              HALF_PLANE_DIRECTIONS - 1);
    const uint32_t* entry = &half_planes_[(size_t{bin} * (count() + 1) + k) * (count() / 32)];
    SampleMask mask;
    for (uint32_t i = 0; i < count(); ++i) mask[i] = ((entry[i / 32] >> i % 32 & 1) != 0) != flip;
    return mask;
}

uint32_t PixelCoverage::hiding() const {
    return static_cast<uint32_t>(
        std::ranges::count_if(triangles, [](const SeenTriangle& t) { return t.hidden.any(); }));
}

CoverageScene::CoverageScene(const Scene& scene, double frame)
    : triangles_(scene.triangles(frame)), bvh_(build_bvh(triangles_, scene.triangle_objects())) {
    if (has_alpha(scene)) alpha_ = make_scene_alpha(scene);
}

std::optional<CoverageScene::Sides> CoverageScene::see(const SampledSun& sun,
                                                       const CoverageReceiver& receiver,
                                                       uint32_t index) const {
    const Triangle& corners = triangles_[index];
    const glm::dvec3 a = vector(corners.v[0]) - receiver.start, b = vector(corners.v[1]) - receiver.start,
                     c = vector(corners.v[2]) - receiver.start;
    const double height = glm::dot(glm::cross(b - a, c - a), a);
    if (height == 0 || plane_in_doubt(height, a, b, c) || is_looked_through(receiver, a, b, c))
        return std::nullopt;
    const glm::dmat3 to_axes = glm::transpose(receiver.axes);
    const glm::dvec3 seen[3] = {to_axes * a, to_axes * b, to_axes * c};
    Sides sides;
    for (size_t i = 0; i < 3; ++i) {  // opposite to corner i; det(V) has the sign of the height
        const glm::dvec3 line = glm::cross(seen[(i + 1) % 3], seen[(i + 2) % 3]);
        // The side of the line that the table knows, then turned: an edge's two triangles share its every
        // sample once.
        const SampleMask side = sun.positive_side(line, receiver.angular_radius, receiver.dither);
        sides.lines[i] = height < 0 ? -line : line;
        sides.masks[i] = height < 0 ? ~side : side;
        for (uint32_t k = sun.count(); k < sides.masks[i].size(); ++k) sides.masks[i].reset(k);
    }
    return sides;
}

// Whether the pair that a leaf holds is seen as a convex quadrilateral. `opposite`: the corner of the first
// triangle that the second does not have, and `other` the second's, relative to the receiver.
bool CoverageScene::is_convex(const Sides& first, size_t opposite, const glm::dvec3& other) {
    bool within = true;
    for (size_t i = 0; i < 3; ++i) {
        const double at = glm::dot(first.lines[i], other);
        within = within && (i == opposite ? at < 0 : at >= 0);
    }
    return within;
}

SeenTriangle CoverageScene::hidden_by(const SampledSun& sun, const CoverageReceiver& receiver, uint32_t index,
                                      const Sides& sides, const SampleMask& within) const {
    SeenTriangle triangle;
    triangle.index = index;
    triangle.lines = sides.lines;
    SampleMask mask = sides.masks[0] & sides.masks[1] & sides.masks[2] & within;
    triangle.alpha = alpha_ && alpha_->record_of[index] != 0;
    if (triangle.alpha) {
        const double radius = std::tan(receiver.angular_radius);
        for (uint32_t i = 0; i < sun.count(); ++i) {
            if (!mask[i]) continue;
            const auto [x, y] = sun.place(i, receiver.angular_radius);
            const glm::dvec3 direction(x * radius, y * radius, 1);
            std::array<double, 3> weights{};
            for (size_t k = 0; k < 3; ++k) weights[k] = glm::dot(triangle.lines[k], direction);
            const double sum = weights[0] + weights[1] + weights[2];
            for (double& weight : weights) weight /= sum;
            if (!alpha_->blocks(alpha_->record_of[index] - 1, weights)) mask.reset(i);
        }
    }
    triangle.hidden = mask;
    return triangle;
}

// Each triangle of a convex pair lies within the other's outer edges, too (leaf_cover.glsl).
void CoverageScene::add_leaf(const SampledSun& sun, const CoverageReceiver& receiver, double reach,
                             const std::array<uint32_t, 4>& corners, PixelCoverage& out) const {
    const uint32_t triangles[] = {corners[0] / 3, corners[3] / 3};
    const size_t apart[] = {corners[0] % 3, corners[3] % 3};  // the corner that the other does not have
    const bool is_pair = corners[3] != corners[2];
    std::optional<Sides> sides[2] = {see(sun, receiver, triangles[0]), std::nullopt};
    if (is_pair) sides[1] = see(sun, receiver, triangles[1]);
    SampleMask within[2];
    within[0].set();
    within[1].set();
    const auto hides = [](const Sides& s) {
        return s.masks[0].any() && s.masks[1].any() && s.masks[2].any();
    };
    if (sides[0] && sides[1] && hides(*sides[0]) && hides(*sides[1])) {
        const glm::dvec3 other =
            glm::transpose(receiver.axes) * (vector(triangles_[triangles[1]].v[apart[1]]) - receiver.start);
        if (is_convex(*sides[0], apart[0], other))
            for (size_t t = 0; t < 2; ++t)
                for (size_t i = 0; i < 3; ++i)
                    if (i != apart[t]) within[1 - t] &= sides[t]->masks[i];
    }
    for (size_t t = 0; t < 2; ++t) {
        if (!sides[t]) continue;
        SeenTriangle triangle = hidden_by(sun, receiver, triangles[t], *sides[t], within[t]);
        out.hidden |= triangle.hidden;
        if (reach > 1 || triangle.hidden.any()) out.triangles.push_back(std::move(triangle));
    }
}

PixelCoverage CoverageScene::cover(const SampledSun& sun, const CoverageReceiver& receiver,
                                   double reach) const {
    PixelCoverage out;
    out.samples = sun.count();
    out.surface_line = glm::transpose(receiver.axes) * receiver.normal;
    out.by_surface = ~sun.positive_side(out.surface_line, receiver.angular_radius, receiver.dither);
    for (uint32_t i = sun.count(); i < out.by_surface.size(); ++i) out.by_surface.reset(i);
    out.hidden = out.by_surface;
    const double tangent = reach * std::tan(receiver.angular_radius),
                 cosine = 1 / std::sqrt(1 + tangent * tangent);
    const TreeCone cone{receiver.start, receiver.axes[2], cosine, tangent * cosine};
    for (std::vector<uint32_t> stack{0}; !stack.empty();) {
        const Texel* node = &bvh_.nodes[size_t{stack.back()} * 3];
        stack.pop_back();
        for (uint32_t k = 0; k < 4; ++k) {
            const bool is_node = node[0][3] >> (24 + k) & 1, is_leaf = node[0][3] >> (28 + k) & 1;
            if (!(is_node || is_leaf) || !cone.may_touch(child_box(node, k))) continue;
            if (is_node) {
                stack.push_back((node[1][0] >> 2) + k);
                continue;
            }
            add_leaf(sun, receiver, reach, bvh_.corners[node[1][1] + k], out);
        }
    }
    return out;
}

}  // namespace penumbra
