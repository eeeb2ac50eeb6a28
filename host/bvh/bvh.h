// SPDX-License-Identifier: MIT
// A 4-wide bounding volume hierarchy for shadow rays: triangles in, two arrays of 16-byte texels out, which
// shaders/common/bvh.glsl reads through uniform texel buffers (rgba32ui). The library penumbra_bvh depends on
// std alone.
//
// A leaf is one *pair*: two triangles that share an edge, or one alone. Node boxes are quantised to 8 bits on
// a grid of the node's own (Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through
// Compressed Wide BVHs", here 4 wide), always outwards. The ray-triangle test is the shear test of Woop,
// Benthin, Wald 2013, "Watertight Ray/Triangle Intersection".
//
// Node, 3 texels. Children 0..i-1 are nodes, the rest leaves; every box is lo..hi on the grid origin + q *
// 2^(e-127).
//
//   texel 0: origin.x, origin.y, origin.z (float bits), bits: e.x | e.y << 8 | e.z << 16 | node mask << 24
//            | leaf mask << 28
//   texel 1: first child node << 2 | axis, first leaf - i (mod 2^32), lo.x, hi.x
//   texel 2: lo.y, hi.y, lo.z, hi.z
//
// Byte k of lo and hi is child k's, which is node (first child node + k) or leaf (first leaf - i + k). Child
// nodes ascend along `axis`.
//
// Leaf, 3 texels: v0, v1, v2, v3 (12 floats in order); triangles (v0, v1, v2) and (v2, v1, v3). Alone: v3 =
// v2.
//
// Node 0 is the root. An empty scene has a root without children and one leaf of zeros, so no buffer is ever
// empty.
//
// Size: 3 texels per node and per leaf, about 0.5 leaves and 0.2 nodes per triangle in a connected mesh.
// Vulkan guarantees maxTexelBufferElements >= 65536 only (about 40 000 triangles); lavapipe and desktop
// drivers have 2^27 or more (about 80 million). The host compares nodes.size() and leaves.size() with the
// device's limit.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "penumbra/export.h"

namespace penumbra PENUMBRA_API {

struct Triangle {
    float v[3][3];
};

using Texel = std::array<uint32_t, 4>;

struct Bvh {
    std::vector<Texel> nodes, leaves;

    // What refit() and per-leaf data (alpha coordinates) need: for every leaf, where v0..v3 come from, as
    // triangle * 3 + corner. A leaf that holds one triangle repeats the third entry.
    std::vector<std::array<uint32_t, 4>> corners;
    std::vector<std::array<uint8_t, 2>> child_counts;  // per node: child nodes, leaves
    std::vector<std::array<float, 6>> bounds;          // per node: least x, y, z of what it holds, greatest
    std::vector<uint32_t> skipped;  // triangles left out because usable() is false, ascending
    uint32_t triangle_count = 0;    // of the input
};

// Coordinates beyond this are not traced: the products of the triangle test would leave the range of a float.
inline constexpr float max_coordinate = 1e12f;

// Levels of nodes, the root included, that build_bvh() never exceeds. A walk has at most one group of
// siblings pending for each level between the root and the last; shaders/common/bvh_path.glsl has room
// for 16.
inline constexpr uint32_t max_bvh_depth = 16;

// Finite, within max_coordinate, and not degenerate to a line or a point.
bool usable(const Triangle& triangle);

// Builds by binned SAH (full sweep for few primitives), moves subtrees, collapses to 4-wide nodes by dynamic
// programming on the SAH cost. Deterministic. `objects`, if not empty, gives one number per triangle:
// triangles of different objects are never paired, which keeps refit() possible when they move apart; throws
// std::invalid_argument where there are more or fewer. At most 2^30 triangles. `progress` is told now and
// then which share of the work is done, about: it rises from 0 to 1.
Bvh build_bvh(std::span<const Triangle> triangles, std::span<const uint32_t> objects = {},
              const std::function<void(double)>& progress = {});

// What refit() has written: numbers of nodes and leaves, of 3 texels each, ascending.
struct Refitted {
    std::vector<uint32_t> nodes, leaves;
};

// Moves the leaves to new vertex positions and fits all boxes; the tree's shape stays, so its quality decays
// with the distance moved. Throws std::invalid_argument unless `triangles` are as many as at the build.
// False, with `bvh` unchanged, where the old shape cannot hold the new triangles: a paired edge came apart,
// or a triangle that was skipped is usable now. A triangle that became unusable is left out until it is
// usable again. Nodes and leaves that hold nothing that moved are not written; `written`, if given, becomes
// those that are.
bool refit(Bvh& bvh, std::span<const Triangle> triangles, Refitted* written = nullptr);

// One texel per leaf: what lies across its outer edges, for shaders/classification/closing_patch.glsl. The
// words belong to the edges (v0, v1), (v2, v0), (v1, v3), (v3, v2); of a leaf that holds one triangle, the
// third is (v1, v2) and the fourth is none. A word is leaf << 4 | both windings run the same way along the
// edge << 3 | second triangle of its leaf << 2 | its corner opposite to the edge, counted in (v0, v1, v2) or
// (v2, v1, v3); or no_neighbour. If a names b, b names a. Fewer than 2^28 leaves. After a refit parts that
// moved may have come together or apart: made anew, or refitted.
inline constexpr uint32_t no_neighbour = ~0u;
std::vector<Texel> leaf_neighbours(const Bvh& bvh);

// The same where only what came apart matters, at the cost of what moved: of the edges that `built` joins
// (leaf_neighbours() of this tree before it was refitted), those join that coincide now. Parts that have come
// together since are not joined, which costs proofs and spoils none. `leaves` are those that a refit() has
// written since `neighbours` was right. Throws std::invalid_argument, and has written nothing, where a list
// is of another tree: both have a texel for each leaf. Returns whether any word is another one now.
bool refit_neighbours(const Bvh& bvh, std::span<const uint32_t> leaves, std::span<const Texel> built,
                      std::span<Texel> neighbours);

struct Ray {
    float origin[3];
    float direction[3];  // finite, of any length but zero
    float t_min, t_max;  // in lengths of direction; hits count for t_min < t < t_max; t_min >= 0, t_max may
                         // be infinite
};

struct TraversalCounts {
    uint64_t nodes = 0, leaves = 0;
};

// Says whether triangle `which` (0: v0, v1, v2; 1: v2, v1, v3) of a leaf blocks where a ray hits it. `areas`:
// the edge functions opposite to its vertices in that order, of any scale and sign: over their sum, the hit's
// weights.
using AlphaTest = std::function<bool(uint32_t leaf, uint32_t which, const std::array<float, 3>& areas)>;

// Whether anything blocks the ray; both sides of a triangle do, where `alpha`, if given, says so. A tree that
// was never built blocks nothing. Same arithmetic as bvh.glsl (IEEE single, no contraction), so the answers
// are equal bit for bit where the device divides correctly rounded.
bool occluded(const Bvh& bvh, const Ray& ray, TraversalCounts* counts = nullptr, const AlphaTest& alpha = {});

}  // namespace PENUMBRA_API
