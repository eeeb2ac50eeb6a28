// SPDX-License-Identifier: MIT
// The points of a light that is near to which first rays went. They follow from the pixel and the frame, so that who needs them long
// after the rays were cast has them made again instead of kept. One invocation per tile.
#include "node.glsl"
#include "common/tiles.glsl"
#include "visibility/sun_point.glsl"
#include "common/light.glsl"

void main() {
    const ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, tile_grid()))) return;
    for (uint rays = ray_words[tile_index(tile)]; rays != 0u; rays &= rays - 1u) {
        const int bit = findLSB(rays);
        const ivec2 p = tile * TILE + ivec2(bit & 7, bit >> 3);
        const vec2 point = light_point(noise_unit(noise_fixed(p, frame.frame_index, params.seed)));
        ray_points[uint(p.y) * frame.size.x + uint(p.x)] = pack_point(point);
    }
}
