// SPDX-License-Identifier: MIT
// The corners of a leaf of the tree, as host/bvh/bvh.h lays them out.
//
// Includer declares: what common/scene_words.glsl needs.
#include "common/scene_words.glsl"

struct BvhLeaf {
    vec3 a, b, c, d;  // triangles a, b, c and c, b, d
};

BvhLeaf bvh_leaf(uint leaf) {
    int texel = int(leaf * 3u);
    vec4 q0 = uintBitsToFloat(scene_leaf_texel(texel));
    vec4 q1 = uintBitsToFloat(scene_leaf_texel(texel + 1));
    vec4 q2 = uintBitsToFloat(scene_leaf_texel(texel + 2));
    return BvhLeaf(q0.xyz, vec3(q0.w, q1.xy), vec3(q1.zw, q2.x), q2.yzw);
}
