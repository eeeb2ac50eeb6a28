// SPDX-License-Identifier: MIT
// Which triangles of the tree are alpha-tested, and whether such a triangle blocks where it is hit. Layout:
// host/scene/scene_alpha.h. In a scene without any, nothing is read: HAS_SCENE_ALPHA says so.
//
// Includer declares what common/scene_alpha.glsl needs, or defines NO_SCENE_ALPHA.
#ifndef NO_SCENE_ALPHA
#include "common/scene_alpha.glsl"

// The word of triangle `which` (0: v0, v1, v2; 1: v2, v1, v3) of a leaf: 0 = opaque.
uint bvh_alpha_word(uint leaf, uint which) {
    uint first = scene_alpha_texel(0).x;
    return scene_alpha_texel(int(first + (leaf >> 1)))[(leaf & 1u) * 2u + which];
}

// `areas`: the edge functions opposite to the triangle's vertices, in the order that `which` gives; of any scale and sign.
bool bvh_alpha_blocks(uint leaf, uint which, vec3 areas) {
    uint word = bvh_alpha_word(leaf, which);
    if (word == 0u) return true;
    uint corner0 = word & 3u, corner1 = word >> 2 & 3u;
    vec3 weights = vec3(areas[corner0], areas[corner1], areas[3u - corner0 - corner1]) / (areas.x + areas.y + areas.z);
    return alpha_blocks((word >> 4) - 1u, weights);
}
#endif

// Whether a triangle of a leaf may have holes: it can be touched, but what covers its outline is not covered by it.
bool bvh_alpha_tested(uint leaf, uint which) {
#ifndef NO_SCENE_ALPHA
    return HAS_SCENE_ALPHA && bvh_alpha_word(leaf, which) != 0u;
#else
    return false;
#endif
}
