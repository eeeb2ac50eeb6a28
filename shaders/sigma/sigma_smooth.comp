// SPDX-License-Identifier: MIT
// SIGMA, second pass: a tile of wide penumbrae spreads over its neighbours, one of narrow ones hardly at all.
#include "node.glsl"
#include "sigma/sigma.glsl"

void main() {
    const ivec2 tile = ivec2(gl_GlobalInvocationID.xy), last = tile_grid() - 1;
    if (any(greaterThan(tile, last))) return;
    const vec3 centre = imageLoad(tiles, tile).xyz;
    const float steepness = 1.01 / (centre.y + 0.01);
    float sum = 0.0, weights = 0.0;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            const float weight = exp2(-steepness * float(x * x + y * y));
            sum += weight * imageLoad(tiles, clamp(tile + ivec2(x, y), ivec2(0), last)).x;
            weights += weight;
        }
    store_smooth_tiles(tile, vec4(centre.z, sum / weights, 0.0, 0.0));
}
