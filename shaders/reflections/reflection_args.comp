// SPDX-License-Identifier: MIT
// Published form: from how many rays and tiles are listed, the arguments of the dispatches over them: one workgroup of 32 rays,
// one per tile; in rows, since many devices limit a dispatch to 65 535 groups per axis. The last group's rays are padded.
#include "node.glsl"

const uint DEAD_RAY = 0xffffffffu;
const uint PER_ROW = 32768u;

void main() {
    const uint rays = counts[0], tiles = counts[1], groups = (rays + 31u) / 32u;
    for (uint i = rays; i < groups * 32u; ++i) padded_rays[i] = DEAD_RAY;
    denoise_args[0] = min(groups, PER_ROW);
    denoise_args[1] = (groups + PER_ROW - 1u) / PER_ROW;
    denoise_args[2] = 1u;
    denoise_args[3] = min(tiles, PER_ROW);
    denoise_args[4] = (tiles + PER_ROW - 1u) / PER_ROW;
    denoise_args[5] = 1u;
    denoise_args[6] = groups;
    denoise_args[7] = tiles;
}
