// SPDX-License-Identifier: MIT
// A scene's alpha-tested triangles, as shaders read them where the fact alpha holds
// (shaders/common/scene_alpha.glsl, bvh_alpha.glsl). An alpha mask is one bit per texel of the full-size
// image: what is there and what is not is decided here, once. An opaque triangle costs two words per pair in
// the tree and nothing elsewhere.
//
// scene.alpha_map (r32ui): the masks' bits, row after row without padding; each mask starts at a word of its
// own, bit i of a mask is bit i % 32 of its word i / 32. scene.alpha_uv (rgba32ui):
//   texel 0               x: first texel of the leaf words
//   texels 1 + 2 r, 2 + 2 r   record r: u0, v0, u1, v1 / u2, v2 (float bits, of the triangle's corners as the
//   scene orders
//                         them), first word of the mask, width - 1 | height - 1 << 16. Records ascend with
//                         the scene's triangles, so that a run of them in an acceleration structure needs its
//                         first alone.
//   from texel x on       per leaf of the tree two words (two leaves to a texel), one for each of its
//   triangles (v0, v1, v2)
//                         and (v2, v1, v3): 0 = opaque (or no triangle), else record + 1 << 4 | i1 << 2 | i0,
//                         where vertex i0 (i1) of the three, counted in the order above, is the scene's
//                         corner 0 (1).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/bvh/bvh.h"
#include "host/scene/scene.h"

namespace penumbra {

// Whether any triangle that the scene shows is alpha-tested: the fact alpha.
bool has_alpha(const Scene& scene);

struct SceneAlpha {
    std::vector<uint32_t> record_of;  // per triangle of Scene::triangles(): its record + 1; 0: opaque
    std::vector<Texel> records;       // two per alpha-tested triangle
    std::vector<uint32_t> map;        // scene.alpha_map

    // Whether a record's triangle blocks at the point with these weights of its corners (their sum is 1). As
    // the shaders' alpha_blocks(), in double precision.
    bool blocks(uint32_t record, const std::array<double, 3>& weights) const;
};

// Throws std::runtime_error where a mask or the number of triangles exceeds the layout (65536 texels per
// axis, 2^28 triangles).
SceneAlpha make_scene_alpha(const Scene& scene);

// The words of every leaf, from each triangle's record + 1 or 0. `triangles` are those that the tree was
// built from.
std::vector<std::array<uint32_t, 2>> record_leaf_words(std::span<const uint32_t> record_of, const Bvh& bvh,
                                                       std::span<const Triangle> triangles);
inline std::vector<std::array<uint32_t, 2>> alpha_leaf_words(const SceneAlpha& alpha, const Bvh& bvh,
                                                             std::span<const Triangle> triangles) {
    return record_leaf_words(alpha.record_of, bvh, triangles);
}

// Where a record's mask lies, whose axes have at most largest_record_map texels.
struct RecordMap {
    uint32_t first_word = 0, width = 1, height = 1;
};
inline constexpr uint32_t largest_record_map = 65536;
// The two texels of the triangle of a part whose indices begin at `first_index`.
void append_record(std::vector<Texel>& records, const Part& part, size_t first_index, const RecordMap& map);
// Which texel of its mask, row by row, the point of a record's triangle with these weights falls on.
uint64_t record_texel(const Texel& first, const Texel& second, const std::array<double, 3>& weights);

// scene.alpha_uv; no words: for ray queries alone.
std::vector<Texel> alpha_uv_texels(const SceneAlpha& alpha,
                                   std::span<const std::array<uint32_t, 2>> leaf_words = {});

// The test that occluded() on the CPU asks for hits in the tree; refers to its arguments.
AlphaTest alpha_test(const SceneAlpha& alpha, std::span<const std::array<uint32_t, 2>> leaf_words);

}  // namespace penumbra
