// SPDX-License-Identifier: MIT
// Of several rays per pixel: how many reach the sun, and the share of them where they disagree. A subgroup counts for its own
// pixels alone.
//
// Includer has tile_share.glsl and declares: RAYS; image fraction.
shared uint reach_sun[32];  // rays of the pixel with this number

void clear_shares(TileShare share) {
    for (uint number = share.first + share.lane; number < share.end; number += share.lanes) reach_sun[number] = 0u;
    subgroup_barrier();
}

void count_as_lit(uint number) { atomicAdd(reach_sun[number], 1u); }

void store_shares(TileShare share, ivec2 tile) {
    subgroup_barrier();
    for (uint number = share.first + share.lane; number < share.end; number += share.lanes) {
        const uint reached = reach_sun[number];
        const bool disagree = (share.wanted >> number & 1u) != 0u && reached != 0u && reached != RAYS;
        if (disagree) store_fraction(tile * TILE + pixel_of_lane(int(number)), vec4(float(reached) / float(RAYS)));
    }
}
