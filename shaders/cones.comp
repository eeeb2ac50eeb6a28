// SPDX-License-Identifier: MIT
// All shadow rays of a pixel at once: a cone query per undecided pixel instead of its first ray, one workgroup per listed
// tile, one lane per pixel, dealt out in blocks of 4x2 as in trace. What the query proves needs no ray; the rest goes on
// in a shorter list. The apex is the very point at which trace starts its rays, so the proof speaks of those rays.
#define APPENDS_TILES
#define LISTED_TILES candidates
#define LISTED_ARGS candidate_args
#include "node.glsl"
#include "common/camera.glsl"
#include "common/receiver_normal.glsl"
#include "common/ray_origin.glsl"
#include "common/sun_sample.glsl"
#include "common/tile_list.glsl"
#include "common/tiles.glsl"
#include "common/cone_query.glsl"

shared uint tile_lit, tile_shadowed;

void main() {
    uvec4 record;
    if (!listed_tile(record)) return;  // the whole workgroup
    const int lane = int(gl_LocalInvocationIndex);
    if (lane == 0) tile_lit = tile_shadowed = 0u;
    barrier();
    const ivec2 in_tile = pixel_of_lane(lane);
    const ivec2 tile = tile_of(record);
    const uint bit = pixel_bit(in_tile);
    const bool wanted = (record.y & bit) != 0u;

    uint answer = CONE_MIXED;
    if (wanted) {
        const ivec2 p = tile * TILE + in_tile;
        answer = query_cone(Cone(shadow_ray_origin(p), sun_frame(sun.to_sun), tan(sun.angular_radius), 0.0));
        if (answer == CONE_CLEAR && !surface_lets_rays_out(p)) answer = CONE_MIXED;
    }
    const uint lit = subgroupOr(answer == CONE_CLEAR ? bit : 0u);
    const uint shadowed = subgroupOr(answer == CONE_COVERED ? bit : 0u);
    if (subgroupElect()) {
        atomicOr(tile_lit, lit);
        atomicOr(tile_shadowed, shadowed);
    }
    barrier();
    const bool first = lane == 0;
    const uint undecided = record.y & ~(tile_lit | tile_shadowed);
    append_tile(first && undecided != 0u, uvec4(record.x, undecided, record.zw));
    if (first) {
        if (tile_shadowed != 0u) preloaded_hits[tile_index(tile)] |= tile_shadowed;
#if HAS_UNDECIDED_WORDS
        undecided_words[tile_index(tile)] = undecided;
#endif
    }
    count_lit(first ? uint(bitCount(tile_lit)) : 0u);
    count_shadowed(first ? uint(bitCount(tile_shadowed)) : 0u);
    count_unknown(first ? uint(bitCount(undecided)) : 0u);
    count_tiles_listed(first && undecided != 0u ? 1u : 0u);
}
