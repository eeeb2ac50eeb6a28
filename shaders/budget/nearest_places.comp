// SPDX-License-Identifier: MIT
// Where the previous frame showed what each pixel shows: of several lights, all have it in common.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/guide_normal.glsl"
#include "common/pixels.glsl"
#include "budget/nearest_place.glsl"

ViewRays before;

void for_pixel(ivec2 p) { store_nearest_places(p, uvec4(pack_place(p, nearest_place(p, before)))); }

void main() {
    before = previous_rays(mat3(1.0));
    for_each_pixel();
}
