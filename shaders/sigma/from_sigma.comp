// SPDX-License-Identifier: MIT
// Penumbra radii, as SIGMA's hosts make them of one ray per pixel, back to what the rays found: whether they hit, and how far away.
// One invocation per 8x4 word.
#include "node.glsl"
#include "common/rounded.glsl"
#include "common/blockers.glsl"
#include "common/sun_sample.glsl"
#include "common/light.glsl"
#include "common/tiles.glsl"
#include "sigma/values.glsl"

// The distance of the sun's blocker, or the way to a lamp's over the way on from there: the host took half of the light's size times either.
float blocker_of(float radius_m) {
    float per_radius = 2.0 / tan(sun.angular_radius);
    if (HAS_LIGHT) per_radius = 2.0 / (params.light_size > 0.0 ? params.light_size : light_radius_m());
    return per_radius * radius_m;
}

void main() {
    const ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, tile_grid()))) return;
    const uint pixels = inside_mask(tile);
    BlockerSums sums = BlockerSums(0u, 0u, 0u);
    uint occluded = 0u;
    for (int i = 0; i < 32; ++i) {
        if ((pixels >> i & 1u) == 0u) continue;
        const ivec2 p = tile * TILE + ivec2(i & 7, i >> 3);
        const float radius_m = texelFetch(penumbra, p, 0).x;
        // Tests that a NaN fails: no sample is no light.
        if (is_lit(radius_m) || (HAS_TRANSLUCENCY && !is_opaque(texelFetch(translucency, p, 0).yzw))) continue;
        occluded |= 1u << i;
        if (radius_m > 0.0) add_blocker(sums, blocker_of(radius_m));
    }
    hits[tile_index(tile)] = occluded;
    blockers[3u * tile_index(tile)] = sums.n;
    blockers[3u * tile_index(tile) + 1u] = sums.sum;
    blockers[3u * tile_index(tile) + 2u] = sums.squares;
}
