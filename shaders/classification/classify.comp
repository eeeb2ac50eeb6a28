// SPDX-License-Identifier: MIT
// Which pixels need a ray. An invocation owns one 8x4 tile, so a tile's words need no other lane and the subgroup may
// have any size; tiles with undecided pixels go to the list that trace is dispatched over.
// Sky is nobody's receiver, surfaces that face away from the sun are shadowed, the rest is traced. Of a light that is near also
// those are no receivers that it cannot reach: out of range, behind it, outside of its cone.
#define APPENDS_TILES
#include "node.glsl"
#include "common/camera.glsl"
#include "common/guide_normal.glsl"
#include "common/sun_sample.glsl"
#include "common/light.glsl"
#include "common/tile_list.glsl"
#include "common/tiles.glsl"

// Largest n.s that is shadowed for certain. The published test takes the sun for a point. A sun of angular radius a
// lights the surface until its upper rim sets, n.s = -sin a; the stored normal's error is left to the ray.
float shadowed_below() {
    return TERMINATOR == TERMINATOR_CENTRE ? 0.0 : -sin(sun.angular_radius) - GUIDE_NORMAL_ERROR;
}

const uint NO_RECEIVER = 0u, SHADOWED = 1u, UNDECIDED = 2u;

uint by_sun(vec3 n, float limit) { return dot(n, sun.to_sun) <= limit ? SHADOWED : UNDECIDED; }

uint by_near_light(ivec2 p, float z, vec3 n) {
    const vec3 to_centre = light.centre - position(p, z);
    if (!light_reaches(-to_centre)) return NO_RECEIVER;
    return light_is_below(n, to_centre, GUIDE_NORMAL_ERROR) ? SHADOWED : UNDECIDED;
}

// Whether the light reaches nothing that the tile shows.
bool is_out_of_reach(ivec2 tile) {
    if (!HAS_LIGHT || !HAS_TILE_BOXES) return false;
    const uint box = 2u * tile_index(tile);
    return !light_may_reach(tile_boxes[box].xyz - light.centre, tile_boxes[box + 1u].xyz - light.centre);
}

void main() {
    const ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    const bool in_grid = all(lessThan(tile, tile_grid()));
    const uint pixels = in_grid && !is_out_of_reach(tile) ? inside_mask(tile) : 0u;
    const float limit = shadowed_below();

    uint receivers = 0u, shadowed = 0u;
    for (int i = 0; i < (pixels != 0u ? 32 : 0); ++i) {
        const ivec2 p = tile * TILE + ivec2(i & 7, i >> 3);
        const float z = (pixels >> i & 1u) != 0u ? imageLoad(view_depth, p).x : 0.0;
        if (z > 0.0) {
            const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
            const uint verdict = HAS_LIGHT ? by_near_light(p, z, n) : by_sun(n, limit);
            if (verdict != NO_RECEIVER) receivers |= 1u << i;
            if (verdict == SHADOWED) shadowed |= 1u << i;
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
