// SPDX-License-Identifier: MIT
// Published form: from how many rays and tiles are listed, the arguments of the dispatches over them: one workgroup of 32 rays,
// one per tile; in rows. The last group's rays are padded.
#include "node.glsl"
#include "common/group_rows.glsl"

const uint DEAD_RAY = 0xffffffffu;

void main() {
    const uint rays = counts[0], tiles = counts[1], groups = (rays + 31u) / 32u;
    for (uint i = rays; i < groups * 32u; ++i) padded_rays[i] = DEAD_RAY;
    const uvec2 of_rays = groups_in_rows(groups), of_tiles = groups_in_rows(tiles);
    denoise_args[0] = of_rays.x;
    denoise_args[1] = of_rays.y;
    denoise_args[2] = 1u;
    denoise_args[3] = of_tiles.x;
    denoise_args[4] = of_tiles.y;
    denoise_args[5] = 1u;
    denoise_args[6] = groups;
    denoise_args[7] = tiles;
}
