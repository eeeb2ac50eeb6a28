// SPDX-License-Identifier: MIT
// Alpha-tested triangles of the scene: the records and masks that host/scene_alpha.h lays out.
//
// Includer declares: uniform usamplerBuffer scene_alpha_uv, scene_alpha_map.
#include "common/mask_texel.glsl"

// Whether the triangle of this record blocks at the point with these weights of its corners, which sum to 1.
bool alpha_blocks(uint record, vec3 weights) {
    int texel = int(1u + record * 2u);
    uvec4 r0 = texelFetch(scene_alpha_uv, texel), r1 = texelFetch(scene_alpha_uv, texel + 1);
    vec2 uv = weights.x * uintBitsToFloat(r0.xy) + weights.y * uintBitsToFloat(r0.zw) + weights.z * uintBitsToFloat(r1.xy);
    uvec2 size = uvec2(r1.w & 0xffffu, r1.w >> 16) + 1u;
    uvec2 at = uvec2(mask_texel(uv, size));
    uint bit = at.y * size.x + at.x;
    return (texelFetch(scene_alpha_map, int(r1.z + (bit >> 5))).x >> (bit & 31u) & 1u) != 0u;
}
