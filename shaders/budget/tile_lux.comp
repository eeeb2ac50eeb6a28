// SPDX-License-Identifier: MIT
// What a light that is near would shine on each tile if nothing stood between: of several lights, how much the shadow of each matters
// there. Two pixels stand for a tile, since no estimate follows from it, only where rays go.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/receiver_normal.glsl"
#include "common/sun_sample.glsl"
#include "common/light.glsl"
#include "common/illuminance.glsl"
#include "common/tiles.glsl"

float lux_at(ivec2 p) {
    const vec3 n = decode_receiver_normal(texelFetch(receiver_normal, p, 0).xy);
    return dot(unshadowed_lux(n, light.centre - position(p, imageLoad(view_depth, p).x)), vec3(0.2126, 0.7152, 0.0722));
}

void main() {
    const ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, tile_grid()))) return;
    const uint index = tile_index(tile), pixels = undecided_words[index];
    float lux = 0.0;
    if (pixels != 0u) {
        const int first = findLSB(pixels), last = findMSB(pixels);
        lux = 0.5 * (lux_at(tile * TILE + ivec2(first & 7, first >> 3)) + lux_at(tile * TILE + ivec2(last & 7, last >> 3)));
    }
    tile_lux[index] = lux;
    lux_so_far[index] = lux + (HAS_BEFORE ? before[index] : 0.0);
}
