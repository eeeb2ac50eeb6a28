// SPDX-License-Identifier: MIT
// Which pixels need a ray. An invocation owns one 8x4 tile, so a tile's words need no other lane and the subgroup may
// have any size; tiles with undecided pixels go to the list that trace is dispatched over.
// Sky is nobody's receiver, surfaces that face away from the sun are shadowed, the rest is traced.
#define APPENDS_TILES
#include "node.glsl"
#include "common/guide_normal.glsl"
#include "common/tile_list.glsl"
#include "common/tiles.glsl"

// Largest n.s that is shadowed for certain. The published test takes the sun for a point. A sun of angular radius a
// lights the surface until its upper rim sets, n.s = -sin a; the stored normal's error is left to the ray.
float shadowed_below() {
    return TERMINATOR == TERMINATOR_CENTRE ? 0.0 : -sin(sun.angular_radius) - GUIDE_NORMAL_ERROR;
}

void main() {
    const ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    const bool in_grid = all(lessThan(tile, tile_grid()));
    const uint pixels = in_grid ? inside_mask(tile) : 0u;
    const float limit = shadowed_below();

    uint receivers = 0u, shadowed = 0u;
    for (int i = 0; i < 32; ++i) {
        const ivec2 p = tile * TILE + ivec2(i & 7, i >> 3);
        if ((pixels >> i & 1u) != 0u && imageLoad(view_depth, p).x > 0.0) {
            receivers |= 1u << i;
            const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
            if (dot(n, sun.to_sun) <= limit) shadowed |= 1u << i;
        }
    }
    const uint undecided = receivers & ~shadowed;
    if (in_grid) {
        receiver_words[tile_index(tile)] = receivers;
        preloaded_hits[tile_index(tile)] = shadowed;
#if HAS_UNDECIDED_WORDS
        undecided_words[tile_index(tile)] = undecided;
#endif
    }
    append_tile(undecided != 0u, pack_tile(tile, undecided, 0.0, WHOLE_RAY_M));

    count_receivers(uint(bitCount(receivers)));
    count_lit(0u);
    count_shadowed(uint(bitCount(shadowed)));
    count_unknown(uint(bitCount(undecided)));
    count_tiles_listed(undecided != 0u ? 1u : 0u);
}
