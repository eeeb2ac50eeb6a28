// SPDX-License-Identifier: MIT
#include "app/tile_beams.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>

#include "app/captured_values.h"
#include "host/metrics/decisions.h"
#include "host/truth/coverage.h"

namespace penumbra {
namespace {

using Tile = std::array<uint32_t, 2>;

constexpr size_t patch_limit = 8;  // the node's default

glm::dvec3 vector(const float (&v)[3]) {
    return {v[0], v[1], v[2]};
}

double distance_from_middle(const glm::dvec2& a, const glm::dvec2& b) {
    const glm::dvec2 d = b - a;
    const double square = glm::dot(d, d);
    const double t = square > 0 ? std::clamp(-glm::dot(a, d) / square, 0.0, 1.0) : 0;
    return glm::length(a + t * d);
}

// Of a convex outline: 0 where the middle lies in it.
double distance_from_middle(const std::vector<glm::dvec2>& outline) {
    double least = std::numeric_limits<double>::infinity();
    int left = 0, right = 0;
    for (size_t i = 0; i < outline.size(); ++i) {
        const glm::dvec2 &a = outline[i], &b = outline[(i + 1) % outline.size()];
        least = std::min(least, distance_from_middle(a, b));
        (a.x * b.y - a.y * b.x > 0 ? left : right)++;
    }
    return outline.size() > 2 && (left == 0 || right == 0) ? 0 : least;
}

// Points of the cone's frame as (x, y, the cone's radius there): what is straight stays straight when it is
// divided by the last. Cut off at the cone's beginning and at the reach (Sutherland and Hodgman).
std::vector<glm::dvec2> seen(std::vector<glm::dvec3> shape, double radius, bool is_segment) {
    const auto cut = [&](const auto& height) {
        std::vector<glm::dvec3> kept;
        const size_t count = shape.size();
        for (size_t i = 0; i < count; ++i) {
            const glm::dvec3 &a = shape[i], &b = shape[(i + 1) % count];
            const double ha = height(a), hb = height(b);
            if (ha >= 0) kept.push_back(a);
            if ((ha >= 0) != (hb >= 0) && !(is_segment && i + 1 == count))
                kept.push_back(a + (b - a) * (ha / (ha - hb)));
        }
        shape = std::move(kept);
    };
    cut([&](const glm::dvec3& p) { return p.z - std::max(radius, 1e-9); });
    for (const double sign : {-1.0, 1.0}) {
        cut([&](const glm::dvec3& p) { return tile_beam_reach * p.z + sign * p.x; });
        cut([&](const glm::dvec3& p) { return tile_beam_reach * p.z + sign * p.y; });
    }
    std::vector<glm::dvec2> flat;
    for (const glm::dvec3& p : shape) flat.push_back(glm::dvec2(p) / p.z);
    return flat;
}

}  // namespace

double TileBeam::nearest() const {
    double least = std::numeric_limits<double>::infinity();
    for (const BeamTriangle& t : triangles) least = std::min(least, distance_from_middle(t.outline));
    return least;
}

double TileBeam::nearest_border() const {
    double least = std::numeric_limits<double>::infinity();
    for (const BeamEdge& e : borders) least = std::min(least, distance_from_middle(e.from, e.to));
    return least;
}

size_t TileBeam::patch() const {
    return static_cast<size_t>(std::ranges::count_if(triangles, &BeamTriangle::in_patch));
}

// make_beam() of beams.comp: around all starts and the sun as each of them sees it.
struct TileBeams::Cone {
    glm::dvec3 apex{0};
    glm::dmat3 axes{1};  // columns: right, up, along
    double radius = 0, spread = 0;
    std::vector<glm::dvec3> starts;  // in its frame

    glm::dvec3 point(const float (&p)[3]) const { return (vector(p) - apex) * axes; }
    std::array<glm::dvec3, 3> points(const Triangle& t) const {
        return {point(t.v[0]), point(t.v[1]), point(t.v[2])};
    }
    glm::dvec3 with_radius(const glm::dvec3& p) const { return {p.x, p.y, spread * p.z + radius}; }

    // As beam_side(): 1 or -1 where all rays cross the plane the same way, ahead of all starts; 2 where no
    // ray can meet it, 0 else.
    int side(const Triangle& t) const {
        const auto [a, b, c] = points(t);
        const glm::dvec3 n = glm::cross(b - a, c - a);
        if (std::abs(n.z) <= spread * std::hypot(n.x, n.y)) return 0;
        double least = std::numeric_limits<double>::infinity(), most = -least;
        for (const glm::dvec3& start : starts) {
            const double along = glm::dot(n, start - a) * (n.z < 0 ? -1 : 1);
            least = std::min(least, along);
            most = std::max(most, along);
        }
        if (least > 0) return 2;
        return most < 0 ? (n.z < 0 ? -1 : 1) : 0;
    }
};

const std::vector<std::string>& TileBeams::captures() {
    static const std::vector<std::string> names{"view_depth",     "receiver_normal", "undecided_words",
                                                "preloaded_hits", "tile_list",       "trace_args"};
    return names;
}

const std::vector<std::string>& TileBeams::settings() {
    static const std::vector<std::string> list{"nodes.classify.out.undecided_words=undecided_words"};
    return list;
}

TileBeams::TileBeams(const Session& session, uint32_t frame)
    : asked_(captured_values<uint32_t>(session, "undecided_words")),
      hits_(captured_values<uint32_t>(session, "preloaded_hits")),
      open_(asked_.size()),
      size_{session.plan().extent.width, session.plan().extent.height},
      triangles_(session.host().scene().triangles(frame)) {
    tiles_ = {(size_[0] + tile_width - 1) / tile_width, (size_[1] + tile_height - 1) / tile_height};
    const uint32_t listed = captured_values<uint32_t>(session, "trace_args")[3];
    const auto list = captured_values<std::array<uint32_t, 4>>(session, "tile_list");
    for (uint32_t i = 0; i < listed; ++i) open_[word({list[i][0] & 0xffff, list[i][0] >> 16})] = list[i][1];

    const StandaloneFrame standalone = session.host().frame(frame, true);
    const auto depth = captured_values<float>(session, "view_depth");
    const auto normal = captured_values<std::array<float, 2>>(session, "receiver_normal");
    const std::vector<uint32_t> no_noise(size_t{128} * 128);  // it turns samples, not where rays start
    starts_.resize(depth.size());
    for (uint32_t i = 0; i < depth.size(); ++i)
        if (depth[i] > 0)
            starts_[i] = coverage_receiver(standalone, 0, no_noise,
                                           {{i % size_[0], i / size_[0]}, depth[i], normal[i]})
                             .start_of_beam;
    const auto& s = standalone.sun.to_sun.v;
    to_sun_ = {s[0], s[1], s[2]};
    tangent_ = std::tan(double(standalone.sun.angular_radius));
    if (has_alpha(session.host().scene())) alpha_ = make_scene_alpha(session.host().scene());

    std::map<std::array<float, 3>, uint32_t> number;
    for (const Triangle& t : triangles_) {
        const glm::dvec3 corners[3] = {vector(t.v[0]), vector(t.v[1]), vector(t.v[2])};
        const glm::dvec3 middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        double around = 0;
        for (const glm::dvec3& corner : corners) around = std::max(around, glm::distance(corner, middle));
        spheres_.emplace_back(middle, around);
        for (const auto& v : t.v)
            numbers_.push_back(
                number.emplace(std::to_array(v), static_cast<uint32_t>(number.size())).first->second);
    }
    for (uint32_t c = 0; c < numbers_.size(); ++c) {
        const uint64_t a = numbers_[c / 3 * 3 + (c + 1) % 3], b = numbers_[c / 3 * 3 + (c + 2) % 3];
        edges_.push_back({std::min(a, b) << 32 | std::max(a, b), c});
    }
    std::ranges::sort(edges_);
}

std::optional<TileVerdict> TileBeams::verdict(Tile tile) const {
    const uint32_t w = word(tile);
    if (asked_[w] == 0) return std::nullopt;
    if (open_[w] != 0) return TileVerdict::open;
    return (hits_[w] & asked_[w]) != 0 ? TileVerdict::dark : TileVerdict::lit;
}

TileBeams::Cone TileBeams::cone(Tile tile) const {
    Cone cone;
    cone.spread = tangent_;
    const glm::dmat3 frame = sun_frame(to_sun_);
    std::vector<glm::dvec3> starts;
    glm::dvec3 lo(std::numeric_limits<double>::infinity()), hi = -lo;
    for (uint32_t bit = 0; bit < tile_width * tile_height; ++bit) {
        if ((asked_[word(tile)] >> bit & 1) == 0) continue;
        const size_t x = tile[0] * tile_width + bit % tile_width,
                     y = tile[1] * tile_height + bit / tile_width;
        starts.push_back(starts_[y * size_[0] + x]);
        const glm::dvec3 p = starts.back() * frame;
        lo = glm::min(lo, p);
        hi = glm::max(hi, p);
    }
    cone.apex = frame * glm::dvec3(0.5 * (lo.x + hi.x), 0.5 * (lo.y + hi.y), lo.z);
    cone.radius = 0.5 * std::hypot(hi.x - lo.x, hi.y - lo.y);
    const glm::dvec3 world_up = std::abs(to_sun_.y) < 0.999 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, -1);
    const glm::dvec3 right = glm::normalize(glm::cross(to_sun_, world_up));
    cone.axes = {right, glm::cross(right, to_sun_), to_sun_};
    for (const glm::dvec3& start : starts) cone.starts.push_back((start - cone.apex) * cone.axes);
    return cone;
}

// Corners opposite to the same edge, of other triangles.
std::vector<uint32_t> TileBeams::others(uint32_t corner) const {
    const uint64_t a = numbers_[corner / 3 * 3 + (corner + 1) % 3],
                   b = numbers_[corner / 3 * 3 + (corner + 2) % 3];
    const uint64_t ends = std::min(a, b) << 32 | std::max(a, b);
    std::vector<uint32_t> list;
    for (auto at = std::ranges::lower_bound(edges_, Edge{ends, 0}); at != edges_.end() && at->ends == ends;
         ++at)
        if (at->corner / 3 != corner / 3) list.push_back(at->corner);
    return list;
}

// Whether the surface goes on across an edge as seen along the beam: both triangles are passed the same way,
// by their windings along it.
bool TileBeams::goes_on(uint32_t corner, uint32_t other, const Cone& cone) const {
    const auto height = [&](uint32_t c) {
        const auto [p, q, r] = cone.points(triangles_[c / 3]);
        return glm::cross(q - p, r - p).z;
    };
    const auto begin = [&](uint32_t c) { return numbers_[c / 3 * 3 + (c + 1) % 3]; };
    return (begin(corner) == begin(other)) != ((height(corner) > 0) == (height(other) > 0));
}

// covers() of closing_patch.glsl; empty where a border is left inside.
std::vector<uint32_t> TileBeams::patch_from(uint32_t first, const Cone& cone) const {
    std::vector<uint32_t> patch{first}, entered{3};
    for (size_t i = 0; i < patch.size(); ++i) {
        const uint32_t t = patch[i];
        if (std::abs(cone.side(triangles_[t])) != 1 || (alpha_ && alpha_->record_of[t] != 0)) return {};
        const auto corners = cone.points(triangles_[t]);
        for (uint32_t k = 0; k < 3; ++k) {
            const auto edge =
                seen({cone.with_radius(corners[(k + 1) % 3]), cone.with_radius(corners[(k + 2) % 3])},
                     cone.radius, true);
            if (k == entered[i] || edge.size() < 2 || distance_from_middle(edge[0], edge[1]) > 1) continue;
            const std::vector<uint32_t> next = others(t * 3 + k);
            const auto on =
                std::ranges::find_if(next, [&](uint32_t c) { return goes_on(t * 3 + k, c, cone); });
            if (on == next.end()) return {};
            if (std::ranges::find(patch, *on / 3) != patch.end()) continue;
            if (patch.size() == patch_limit) return {};
            patch.push_back(*on / 3);
            entered.push_back(*on % 3);
        }
    }
    return patch;
}

TileBeam TileBeams::beam(Tile tile) const {
    const Cone cone = this->cone(tile);
    TileBeam beam;
    beam.tile = tile;
    beam.verdict = *verdict(tile);
    beam.pixels = static_cast<uint32_t>(std::popcount(asked_[word(tile)]));
    std::vector<uint32_t> patch;
    for (uint32_t i = 0; i < triangles_.size(); ++i) {
        const glm::dvec3 middle = (glm::dvec3(spheres_[i]) - cone.apex) * cone.axes;
        const double around = spheres_[i].w,
                     reach = tile_beam_reach * (cone.spread * (middle.z + around) + cone.radius) + around;
        if (middle.z + around < 0 || std::abs(middle.x) > reach || std::abs(middle.y) > reach ||
            !usable(triangles_[i]))
            continue;
        std::vector<glm::dvec3> shape;
        for (const glm::dvec3& corner : cone.points(triangles_[i])) shape.push_back(cone.with_radius(corner));
        auto outline = seen(shape, cone.radius, false);
        if (outline.size() < 3 || cone.side(triangles_[i]) == 2) continue;
        if (!beam.closed && distance_from_middle(outline) == 0) {
            patch = patch_from(i, cone);
            beam.closed = !patch.empty();
        }
        for (uint32_t k = 0; k < 3; ++k) {
            const std::vector<uint32_t> next = others(i * 3 + k);
            if (std::ranges::any_of(next, [&](uint32_t c) { return goes_on(i * 3 + k, c, cone); })) continue;
            const auto edge = seen({shape[(k + 1) % 3], shape[(k + 2) % 3]}, cone.radius, true);
            if (edge.size() == 2) beam.borders.push_back({edge[0], edge[1]});
        }
        beam.triangles.push_back({i, std::move(outline), false});
    }
    for (BeamTriangle& t : beam.triangles) t.in_patch = std::ranges::find(patch, t.index) != patch.end();
    return beam;
}

}  // namespace penumbra
