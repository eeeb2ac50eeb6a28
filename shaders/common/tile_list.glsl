// SPDX-License-Identifier: MIT
// The list of tiles that need rays, with the arguments of the dispatch that traces them: one workgroup per tile, in
// rows. trace_args = {groups_in_rows(count), 1, count}, zeroed when the pass starts. count only grows, so the
// maximum over everyone who appended is the final value: the triple is complete without a pass to finish it.
// The order of the list follows the scheduling and must never show in the image.

#include "common/group_rows.glsl"

const float WHOLE_RAY_M = 1e30;  // a record's t_max; finite: its product with a slab test's margin must not overflow

#ifdef APPENDS_TILES
// Called by every invocation that is alive; one atomic per subgroup.
void append_tile(bool wanted, uvec4 record) {
    const uvec4 ballot = subgroupBallot(wanted);
    const uint count = subgroupBallotBitCount(ballot);
    uint first = 0u;
    if (subgroupElect() && count != 0u) {
        first = atomicAdd(trace_args[3], count);
        const uvec2 groups = groups_in_rows(first + count);
        atomicMax(trace_args[0], groups.x);
        atomicMax(trace_args[1], groups.y);
        atomicMax(trace_args[2], 1u);
    }
    first = subgroupBroadcastFirst(first);
    if (wanted) tile_list[first + subgroupBallotExclusiveBitCount(ballot)] = record;
}
#endif

// A shader that reads one list and writes another names the one it reads before it includes this.
#if !defined(LISTED_TILES) && !defined(APPENDS_TILES)
#define LISTED_TILES tile_list
#define LISTED_ARGS trace_args
#endif

#ifdef LISTED_TILES
// Whether this workgroup has a tile, and its record: packed tile and rays, mask of pixels to trace, t_min, t_max.
bool listed_tile(out uvec4 record) {
    const uint index = entry_of_group();
    if (index >= LISTED_ARGS[3]) return false;
    record = LISTED_TILES[index];
    return true;
}
#endif

// An image of 65 536 pixels has 2^13 tiles across and 2^14 down: the bits above say how many rays the pixels get, less one.
uvec4 pack_tile(ivec2 tile, uint mask, float t_min, float t_max) {
    return uvec4(uint(tile.x) | uint(tile.y) << 16, mask, floatBitsToUint(t_min), floatBitsToUint(t_max));
}
uvec4 with_rays(uvec4 record, uint rays) {
    const uint more = rays - 1u;
    return uvec4(record.x | (more & 7u) << 13 | more >> 3 << 30, record.yzw);
}
ivec2 tile_of(uvec4 record) { return ivec2(record.x & 0x1fffu, record.x >> 16 & 0x3fffu); }
uint rays_of(uvec4 record) { return (record.x >> 13 & 7u | record.x >> 30 << 3) + 1u; }  // 1 to 32
