// SPDX-License-Identifier: MIT
// How a workgroup deals out a tile. Its pixels are numbered as pixel_of_lane() has them; a subgroup takes a share of them, at
// which no other looks, so that nothing waits for a workgroup: on a software device, where waiting costs as much as several
// rays, a subgroup is one. What is wanted of the share goes to its lanes without gaps, so that a tile of few open pixels costs
// no more than they do.
//
// Includer has common/tiles.glsl.
struct TileShare {
    uint lanes, lane;
    uint first, end;  // numbers of pixels
    uint wanted;      // of these: a bit per number
};

// `pixels`: a tile's mask, as its words have it.
TileShare tile_share(uint pixels) {
    const uint count = 32u / gl_NumSubgroups, first = gl_SubgroupID * count;
    const uint own = count == 32u ? ~0u : (1u << count) - 1u << first;
    return TileShare(gl_WorkGroupSize.x * gl_WorkGroupSize.y / gl_NumSubgroups, gl_SubgroupInvocationID, first, first + count, lanes_of_pixels(pixels) & own);
}

// The pixel of the k-th one that is wanted.
uint wanted_number(TileShare share, uint k) { return bit_number(share.wanted, k); }
