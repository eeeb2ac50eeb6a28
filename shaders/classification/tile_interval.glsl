// SPDX-License-Identifier: MIT
// The part of its rays that a tile's undecided pixels need: the least and the greatest distance over the workgroup, one
// tile. Distances are not negative, so they are ordered as their bits are and the order of the atomics never shows.
// All invocations of the workgroup call each of these, in this order.

shared uint tile_nearest, tile_farthest, tile_undecided;

void open_tile() {
    if (gl_LocalInvocationIndex == 0u) {
        tile_nearest = 0x7f7fffffu;  // the largest float
        tile_farthest = 0u;
        tile_undecided = 0u;
    }
    barrier();
}

void close_tile(bool undecided, uint bit, float nearest_m, float farthest_m) {
    const uint bits = subgroupOr(undecided ? bit : 0u);
    if (subgroupElect()) atomicOr(tile_undecided, bits);
    if (undecided) {
        atomicMin(tile_nearest, floatBitsToUint(max(nearest_m, 0.0)));
        atomicMax(tile_farthest, floatBitsToUint(max(farthest_m, 0.0)));
    }
    barrier();
}

// The tile's record after close_tile(). The interval is taken only where it shortens the ray and is one: written so that
// a NaN leaves the whole ray.
uvec4 closed_record(uvec4 record, bool use_interval) {
    const float from = uintBitsToFloat(tile_nearest), to = uintBitsToFloat(tile_farthest);
    record.y = tile_undecided;
    if (use_interval && from < to) {
        record.z = floatBitsToUint(max(from, uintBitsToFloat(record.z)));
        record.w = floatBitsToUint(min(to, uintBitsToFloat(record.w)));
    }
    return record;
}
