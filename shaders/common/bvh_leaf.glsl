// SPDX-License-Identifier: MIT
// The corners of a leaf of the tree, as host/bvh/bvh.h lays them out.
//
// Includer declares: what common/scene_words.glsl needs.
#include "common/scene_words.glsl"

struct BvhLeaf {
    vec3 a, b, c, d;  // triangles a, b, c and c, b, d
};

BvhLeaf bvh_leaf_of(vec4 q0, vec4 q1, vec4 q2) { return BvhLeaf(q0.xyz, vec3(q0.w, q1.xy), vec3(q1.zw, q2.x), q2.yzw); }

BvhLeaf bvh_leaf(uint leaf) {
    const int texel = int(leaf * 3u);
    return bvh_leaf_of(uintBitsToFloat(scene_leaf_texel(texel)), uintBitsToFloat(scene_leaf_texel(texel + 1)),
                       uintBitsToFloat(scene_leaf_texel(texel + 2)));
}
