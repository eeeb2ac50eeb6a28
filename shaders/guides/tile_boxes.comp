// SPDX-License-Identifier: MIT
// The box around what each tile shows, so that each of several lights can tell at a glance which tiles it does not reach.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/tiles.glsl"

void main() {
    const ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, tile_grid()))) return;
    const uint pixels = inside_mask(tile);
    vec3 lower = vec3(3e38), upper = vec3(-3e38);
    for (int i = 0; i < 32; ++i) {
        const ivec2 p = tile * TILE + ivec2(i & 7, i >> 3);
        const float z = (pixels >> i & 1u) != 0u ? imageLoad(view_depth, p).x : 0.0;
        if (z > 0.0) {
            const vec3 at = position(p, z);
            lower = min(lower, at);
            upper = max(upper, at);
        }
    }
    tile_boxes[2u * tile_index(tile)] = vec4(lower, 0.0);
    tile_boxes[2u * tile_index(tile) + 1u] = vec4(upper, 0.0);
}
