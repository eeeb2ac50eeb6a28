// SPDX-License-Identifier: MIT
// Alpha-tested triangles of the scene: the records and masks that host/scene/scene_alpha.h lays out.
//
// Includer declares: uniform usamplerBuffer scene_alpha_uv, scene_alpha_map; uniform uimageBuffer scene_loaded_alpha_uv,
// scene_loaded_alpha_map; buffers of the same words, scene_alpha_uv_words, scene_alpha_map_words; const bool HAS_ each of them.
#include "common/mask_texel.glsl"

const bool HAS_SCENE_ALPHA = HAS_SCENE_ALPHA_UV || HAS_SCENE_LOADED_ALPHA_UV || HAS_SCENE_ALPHA_UV_WORDS;

uvec4 scene_alpha_texel(int texel) {
    if (HAS_SCENE_LOADED_ALPHA_UV) return imageLoad(scene_loaded_alpha_uv, texel);
    if (HAS_SCENE_ALPHA_UV_WORDS) return scene_alpha_uv_words[texel];
    return texelFetch(scene_alpha_uv, texel);
}

uint scene_alpha_mask(int word) {
    if (HAS_SCENE_LOADED_ALPHA_MAP) return imageLoad(scene_loaded_alpha_map, word).x;
    if (HAS_SCENE_ALPHA_MAP_WORDS) return scene_alpha_map_words[word];
    return texelFetch(scene_alpha_map, word).x;
}

struct AlphaRecord {
    vec2 uv0, uv1, uv2;  // of the triangle's corners, as the scene orders them
    uvec2 size;          // of the mask, in texels
    uint first;          // word of the mask
};

AlphaRecord alpha_record(uint record) {
    int texel = int(1u + record * 2u);
    uvec4 r0 = scene_alpha_texel(texel), r1 = scene_alpha_texel(texel + 1);
    return AlphaRecord(uintBitsToFloat(r0.xy), uintBitsToFloat(r0.zw), uintBitsToFloat(r1.xy),
                       uvec2(r1.w & 0xffffu, r1.w >> 16) + 1u, r1.z);
}

// Whether there is something at a texture coordinate.
bool alpha_there(AlphaRecord r, vec2 uv) {
    uvec2 at = uvec2(mask_texel(uv, r.size));
    uint bit = at.y * r.size.x + at.x;
    return (scene_alpha_mask(int(r.first + (bit >> 5))) >> (bit & 31u) & 1u) != 0u;
}

// Whether the triangle of this record blocks at the point with these weights of its corners, which sum to 1.
bool alpha_blocks(uint record, vec3 weights) {
    AlphaRecord r = alpha_record(record);
    return alpha_there(r, weights.x * r.uv0 + weights.y * r.uv1 + weights.z * r.uv2);
}
