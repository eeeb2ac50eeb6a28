// SPDX-License-Identifier: MIT
// The published classifier, for comparison: one workgroup per listed tile, one lane per pixel.
#define APPENDS_TILES
#define LISTED_TILES candidates
#define LISTED_ARGS candidate_args
#include "node.glsl"
#include "common/camera.glsl"
#include "common/cascade_place.glsl"
#include "classification/tile_interval.glsl"
#include "common/tile_list.glsl"
#include "common/tiles.glsl"
#include "common/poisson_disc.glsl"
#include "classification/cascade_poisson.glsl"

shared uint tile_shadowed;

void main() {
    uvec4 record;
    if (!listed_tile(record)) return;  // the whole workgroup
    const int lane = int(gl_LocalInvocationIndex);
    if (lane == 0) tile_shadowed = 0u;
    open_tile();
    const ivec2 in_tile = pixel_of_lane(lane);
    const ivec2 tile = tile_of(record), p = tile * TILE + in_tile;
    const uint bit = pixel_bit(in_tile);
    const bool wanted = (record.y & bit) != 0u;

    Found found = Found(LIT, 0.0, 0.0);
    if (wanted) {
        found = search_published(p, imageLoad(view_depth, p).x);
        if (!REJECT_LIT && found.answer == LIT) found = Found(UNDECIDED, 0.0, WHOLE_RAY_M);
    }
    const uint shadowed = subgroupOr(found.answer == SHADOWED ? bit : 0u);
    if (subgroupElect()) atomicOr(tile_shadowed, shadowed);
    close_tile(found.answer == UNDECIDED, bit, found.nearest_m, found.farthest_m);

    const bool first = lane == 0;
    const uvec4 left = closed_record(record, USE_INTERVAL);
    append_tile(first && left.y != 0u, left);
#if HAS_UNDECIDED_WORDS
    if (first) undecided_words[tile_index(tile_of(record))] = left.y;
#endif
    if (first && tile_shadowed != 0u) preloaded_hits[tile_index(tile)] |= tile_shadowed;
    count_lit(first ? uint(bitCount(record.y & ~left.y & ~tile_shadowed)) : 0u);
    count_shadowed(first ? uint(bitCount(tile_shadowed)) : 0u);
    count_unknown(first ? uint(bitCount(left.y)) : 0u);
    count_tiles_listed(first && left.y != 0u ? 1u : 0u);
}
