// SPDX-License-Identifier: MIT
// The texel layout of bvh.h: encoding, refitting, and the reference traversal that tests and CPU tools use.
#include "host/bvh/bvh.h"

#include <bit>
#include <cassert>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "host/bvh/bvh_internal.h"
#include "host/bvh/twofold.h"

namespace penumbra {

namespace bvh_detail {

namespace {

// The slab test's rounding against a grid of 256 steps is below 1e-3 of a step (t = q * (step / d) + (origin
// - o) / d: each term is off by at most 3 ulp of 256 steps, the rest is relative to t and covered there).
// Boxes therefore keep this distance from the planes that stand for them.
constexpr double margin = 1.0 / 64;

struct Grid {
    float origin;
    int exponent;  // of the step, biased as in a float
};

Grid fit_grid(float lo, float hi) {
    const double extent = double(hi) - lo;
    int e = extent > 0 ? std::ilogb(extent / 255) : -100;
    for (e = std::max(e, -100);; ++e) {
        const double step = std::ldexp(1.0, e);
        float origin = float(lo - margin * step);
        if (origin > lo - margin * step)
            origin = std::nextafter(origin, -std::numeric_limits<float>::infinity());
        if ((double(hi) - origin) / step + margin <= 255) return {origin, e + 127};
    }
}

void encode(const WideNode& node, Texel out[3]) {
    Box all;
    uint32_t node_mask = 0, leaf_mask = 0;
    for (uint32_t k = 0; k < node.nodes + node.leaves; ++k) {
        if (node.box[k].empty()) continue;
        all.add(node.box[k]);
        (k < node.nodes ? node_mask : leaf_mask) |= 1u << k;
    }
    if (node_mask + leaf_mask == 0) all.add(std::array<float, 3>{}.data());

    uint32_t exponents = node_mask << 24 | leaf_mask << 28;
    uint32_t planes[3][2] = {};
    for (int a = 0; a < 3; ++a) {
        const Grid grid = fit_grid(all.lo[a], all.hi[a]);
        const double step = std::ldexp(1.0, grid.exponent - 127);
        out[0][a] = std::bit_cast<uint32_t>(grid.origin);
        exponents |= uint32_t(grid.exponent) << (8 * a);
        for (uint32_t k = 0; k < 4; ++k) {
            if (!((node_mask | leaf_mask) >> k & 1)) continue;
            const double lo = std::floor((double(node.box[k].lo[a]) - grid.origin) / step - margin);
            const double hi = std::ceil((double(node.box[k].hi[a]) - grid.origin) / step + margin);
            assert(hi <= 255);
            planes[a][0] |= uint32_t(std::max(lo, 0.0)) << (8 * k);
            planes[a][1] |= uint32_t(hi) << (8 * k);
        }
    }
    out[0][3] = exponents;
    out[1] = {node.first_node << 2 | node.axis, node.first_leaf - node.nodes, planes[0][0], planes[0][1]};
    out[2] = {planes[1][0], planes[1][1], planes[2][0], planes[2][1]};
}

}  // namespace

void put_node(Bvh& bvh, uint32_t i, const WideNode& node) {
    Box all;
    for (uint32_t k = 0; k < node.nodes + node.leaves; ++k) all.add(node.box[k]);
    bvh.bounds[i] = {all.lo[0], all.lo[1], all.lo[2], all.hi[0], all.hi[1], all.hi[2]};
    encode(node, &bvh.nodes[size_t(i) * 3]);
}

void encode_leaf(std::span<const Triangle> triangles, const Corners& corners, Texel out[3]) {
    for (uint32_t i = 0; i < 12; ++i)
        out[i / 4][i % 4] = std::bit_cast<uint32_t>(corner(triangles, corners[i / 3])[i % 3]);
}

}  // namespace bvh_detail

using namespace bvh_detail;

namespace {

bool same_position(const float a[3], const float b[3]) {
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

bool still_paired(std::span<const Triangle> triangles, const Corners& c) {
    const auto next = [](uint32_t i) { return i % 3 == 2 ? i - 2 : i + 1; };
    const float *a = corner(triangles, c[1]), *b = corner(triangles, c[2]);
    const float *d = corner(triangles, next(c[3])), *e = corner(triangles, next(next(c[3])));
    return (same_position(a, d) && same_position(b, e)) || (same_position(a, e) && same_position(b, d));
}

// A leaf that is not as it was; without corners where nothing is left of it.
struct Change {
    uint32_t leaf;
    std::optional<Corners> corners;
};

// Whether a leaf says what its triangles are now.
bool is_encoded(const Bvh& bvh, uint32_t leaf, std::span<const Triangle> triangles) {
    Texel now[3];
    encode_leaf(triangles, bvh.corners[leaf], now);
    return std::equal(now, now + 3, &bvh.leaves[size_t(leaf) * 3]);
}

Box bounds_of(const Bvh& bvh, uint32_t node) {
    const auto& b = bvh.bounds[node];
    return {{b[0], b[1], b[2]}, {b[3], b[4], b[5]}};
}

// Nodes above leaves that were written, which it returns, ascending.
std::vector<uint32_t> refit_nodes(Bvh& bvh, std::span<const uint32_t> leaves) {
    std::vector<uint8_t> stale_leaves(bvh.corners.size()), stale(bvh.child_counts.size());
    for (const uint32_t leaf : leaves) stale_leaves[leaf] = 1;
    const auto any = [](const std::vector<uint8_t>& of, uint32_t first, uint32_t count) {
        return std::any_of(of.begin() + first, of.begin() + first + count, [](uint8_t x) { return x != 0; });
    };
    std::vector<uint32_t> written;
    // Children come after their parent: backwards is bottom-up.
    for (uint32_t i = uint32_t(stale.size()); i-- > 0;) {
        const Texel* texels = &bvh.nodes[size_t(i) * 3];
        WideNode node;
        node.nodes = bvh.child_counts[i][0];
        node.leaves = bvh.child_counts[i][1];
        node.axis = texels[1][0] & 3;
        node.first_node = texels[1][0] >> 2;
        node.first_leaf = texels[1][1] + node.nodes;
        if (!any(stale, node.first_node, node.nodes) && !any(stale_leaves, node.first_leaf, node.leaves))
            continue;
        for (uint32_t k = 0; k < node.nodes; ++k) node.box[k] = bounds_of(bvh, node.first_node + k);
        for (uint32_t k = 0; k < node.leaves; ++k)
            node.box[node.nodes + k] = leaf_box(&bvh.leaves[size_t(node.first_leaf + k) * 3]);
        put_node(bvh, i, node);
        stale[i] = 1;
        written.push_back(i);
    }
    std::reverse(written.begin(), written.end());
    return written;
}

}  // namespace

bool refit(Bvh& bvh, std::span<const Triangle> triangles, Refitted* written) {
    if (triangles.size() != bvh.triangle_count)
        throw std::invalid_argument("refit: " + std::to_string(triangles.size()) +
                                    " triangles, the tree was built of " +
                                    std::to_string(bvh.triangle_count));
    for (uint32_t t : bvh.skipped)
        if (usable(triangles[t])) return false;

    // Nothing is written before all of it is known to fit.
    std::vector<Change> changes;
    for (uint32_t leaf = 0; leaf < bvh.corners.size(); ++leaf) {
        Corners c = bvh.corners[leaf];
        const bool single = c[3] == c[2];
        const bool paired = !single && still_paired(triangles, c);
        if ((single || paired) && is_encoded(bvh, leaf, triangles)) continue;
        // A pair with one unusable half keeps the other; with none it has no box and its texels are zero.
        const bool first = usable(triangles[c[0] / 3]);
        const bool second = !single && usable(triangles[c[3] / 3]);
        if (first && second) {
            if (!paired) return false;
        } else if (second) {
            const uint32_t t = c[3] / 3 * 3;
            c = {t, t + 1, t + 2, t + 2};
        } else {
            c[3] = c[2];
        }
        changes.push_back({leaf, first || second ? std::optional(c) : std::nullopt});
    }

    Refitted all;
    for (const Change& change : changes) {
        Texel* leaf = &bvh.leaves[size_t(change.leaf) * 3];
        if (change.corners)
            encode_leaf(triangles, *change.corners, leaf);
        else
            std::fill_n(leaf, 3, Texel{});
        all.leaves.push_back(change.leaf);
    }
    all.nodes = refit_nodes(bvh, all.leaves);
    if (written) *written = std::move(all);
    return true;
}

namespace {

// What does not change along the ray. See bvh.glsl, which this follows operation by operation.
struct RaySetup {
    float origin[3], direction[3], inverse[3];
    int kx, ky, kz;  // kz: the longest component
    float shear_x, shear_y, scale_z;
    float t_min, t_max;

    explicit RaySetup(const Ray& ray) : t_min(ray.t_min), t_max(ray.t_max) {
        float d[3];
        for (int a = 0; a < 3; ++a) {
            origin[a] = ray.origin[a];
            d[a] = ray.direction[a];
            if (!(std::abs(d[a]) >= 0x1p-80f)) d[a] = d[a] < 0 ? -0x1p-80f : 0x1p-80f;
            direction[a] = d[a];
            inverse[a] = 1.0f / d[a];
        }
        const float x = std::abs(d[0]), y = std::abs(d[1]), z = std::abs(d[2]);
        kz = x > y && x > z ? 0 : y > z ? 1 : 2;
        kx = kz == 0 ? 1 : 0;
        ky = kz == 2 ? 1 : 2;
        scale_z = inverse[kz];
        shear_x = d[kx] * scale_z;
        shear_y = d[ky] * scale_z;
    }
};

constexpr float hit_roundings = 8 * 0x1p-24f, vertex_roundings = 2 * 0x1p-24f;

struct Sheared {
    float x, y, z;
};

glm::vec3 vertex_of(const Texel* leaf, int vertex) {
    glm::vec3 p;
    for (int a = 0; a < 3; ++a) p[a] = std::bit_cast<float>(leaf[(vertex * 3 + a) / 4][(vertex * 3 + a) % 4]);
    return p;
}

Sheared shear(const RaySetup& ray, const Texel* leaf, int vertex) {
    glm::vec3 p = vertex_of(leaf, vertex);
    for (int a = 0; a < 3; ++a) p[a] -= ray.origin[a];
    return {p[ray.kx] - ray.shear_x * p[ray.kz], p[ray.ky] - ray.shear_y * p[ray.kz], p[ray.kz]};
}

float edge(const Sheared& a, const Sheared& b) {
    return a.x * b.y - a.y * b.x;
}

// How far rounding can move the hit of a triangle along the ray, times the triangle's sheared area; see
// bvh.glsl.
float hit_rounding(const RaySetup& ray, const Sheared& a, const Sheared& b, const Sheared& c) {
    const float ta = a.z * ray.scale_z, tb = b.z * ray.scale_z, tc = c.z * ray.scale_z;
    const float first = std::min(std::min(ta, tb), tc);
    if (first > 0) return 0;
    const float range = std::max(std::max(ta, tb), tc) - first;
    const float x = std::max(std::max(std::abs(a.x), std::abs(b.x)), std::abs(c.x));
    const float y = std::max(std::max(std::abs(a.y), std::abs(b.y)), std::abs(c.y));
    const float z = range / std::abs(ray.scale_z);
    const float edges = x * y + z * (std::abs(ray.shear_x) * y + std::abs(ray.shear_y) * x);
    return hit_roundings * range * edges;
}

// Whether the triangle's plane lies ahead of the ray's start by more than its corners' rounding; see
// bvh.glsl.
bool plane_ahead(const RaySetup& ray, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    const glm::vec3 origin(ray.origin[0], ray.origin[1], ray.origin[2]),
        direction(ray.direction[0], ray.direction[1], ray.direction[2]);
    const Twofold to_a = twofold_difference(a, origin);
    const Twofold n = cross_product(twofold_difference(b, a), twofold_difference(c, a));
    const float height = dot_product(n, to_a), slope = dot_product(n, {direction, glm::vec3(0)});
    const glm::vec3 reach = glm::max(glm::max(glm::abs(to_a.hi), glm::abs(b - origin)), glm::abs(c - origin));
    const float extent = std::max(std::max(reach.x, reach.y), reach.z);
    const glm::vec3 area = glm::abs(n.hi), size = glm::abs(direction);
    const float displaced = vertex_roundings * extent * ((area.x + area.y) + area.z);
    const float turned = vertex_roundings * extent * extent * ((size.x + size.y) + size.z);
    const float beyond = (slope < 0 ? -height : height) - ray.t_min * std::abs(slope);
    return std::abs(slope) > turned && beyond > displaced;
}

// u, v, w: the edge functions opposite to a, b, c, the leaf's vertices ka, kb, kc.
bool inside(const RaySetup& ray, float u, float v, float w, const Sheared& a, const Sheared& b,
            const Sheared& c, const Texel* leaf, int ka, int kb, int kc) {
    const bool miss = std::min(std::min(u, v), w) < 0 && std::max(std::max(u, v), w) > 0;
    const float det = u + v + w;
    const float t = (u * a.z + v * b.z + w * c.z) * ray.scale_z;
    const float signed_t = det < 0 ? -t : t, size = std::abs(det);
    const float rounding = hit_rounding(ray, a, b, c), near = ray.t_min * size;
    if (miss || !(size > 0 && signed_t > near - rounding && signed_t < ray.t_max * size)) return false;
    return signed_t > near + rounding ||
           plane_ahead(ray, vertex_of(leaf, ka), vertex_of(leaf, kb), vertex_of(leaf, kc));
}

bool hits_leaf(const RaySetup& ray, const Bvh& bvh, uint32_t index, const AlphaTest& alpha) {
    const Texel* leaf = &bvh.leaves[size_t(index) * 3];
    const Sheared a = shear(ray, leaf, 0), b = shear(ray, leaf, 1), c = shear(ray, leaf, 2),
                  d = shear(ray, leaf, 3);
    const float ab = edge(a, b), bc = edge(b, c), ca = edge(c, a), bd = edge(b, d), dc = edge(d, c);
    return (inside(ray, bc, ca, ab, a, b, c, leaf, 0, 1, 2) && (!alpha || alpha(index, 0, {bc, ca, ab}))) ||
           (inside(ray, bd, dc, -bc, c, b, d, leaf, 2, 1, 3) && (!alpha || alpha(index, 1, {bd, dc, -bc})));
}

constexpr int32_t slack = 34;  // SLACK of shaders/common/bvh_boxes.glsl

uint32_t hit_children(const RaySetup& ray, const Texel* node) {
    float near[4], far[4];
    for (int k = 0; k < 4; ++k) {
        near[k] = ray.t_min;
        far[k] = ray.t_max;
    }
    const uint32_t planes[3][2] = {
        {node[1][2], node[1][3]}, {node[2][0], node[2][1]}, {node[2][2], node[2][3]}};
    for (int a = 0; a < 3; ++a) {
        const bool negative = ray.inverse[a] < 0;
        const float step = std::bit_cast<float>((node[0][3] >> (8 * a) & 255) << 23) * ray.inverse[a];
        const float base = (std::bit_cast<float>(node[0][a]) - ray.origin[a]) * ray.inverse[a];
        for (int k = 0; k < 4; ++k) {
            near[k] = std::max(near[k], float(planes[a][negative] >> (8 * k) & 255) * step + base);
            far[k] = std::min(far[k], float(planes[a][!negative] >> (8 * k) & 255) * step + base);
        }
    }
    uint32_t hits = 0;
    for (uint32_t k = 0; k < 4; ++k)
        if (std::bit_cast<int32_t>(near[k]) <= std::bit_cast<int32_t>(far[k]) + slack) hits |= 1u << k;
    return hits;
}

}  // namespace

bool occluded(const Bvh& bvh, const Ray& ray, TraversalCounts* counts, const AlphaTest& alpha) {
    if (bvh.nodes.empty()) return false;
    const RaySetup setup(ray);
    std::array<uint32_t, max_bvh_depth * 3 + 1> stack;
    stack[0] = 0;
    for (uint32_t depth = 1; depth > 0;) {
        const Texel* node = &bvh.nodes[size_t(stack[--depth]) * 3];
        const uint32_t hits = hit_children(setup, node);
        const uint32_t node_mask = hits & node[0][3] >> 24 & 15, leaf_mask = hits & node[0][3] >> 28;
        if (counts) ++counts->nodes;
        for (uint32_t k = 0; k < 4; ++k) {
            if (node_mask >> k & 1) stack[depth++] = (node[1][0] >> 2) + k;
            if (!(leaf_mask >> k & 1)) continue;
            if (counts) ++counts->leaves;
            if (hits_leaf(setup, bvh, node[1][1] + k, alpha)) return true;
        }
    }
    return false;
}

}  // namespace penumbra
