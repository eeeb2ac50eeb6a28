// SPDX-License-Identifier: MIT
// RELAX, first pass: what rays brought is blurred over eight pixels of a disc, the wider the farther away they hit something. One
// ray per pixel and lobe always has a distance: the published pass that makes up for missing ones is not needed.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/disc_taps.glsl"
#include "common/hash.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/rounded.glsl"
#include "common/same_surface.glsl"
#include "relax/relax.glsl"

const float SPECULAR_RADIUS_PX = 50.0, DIFFUSE_RADIUS_PX = 30.0;
const float HIT_DIFFERENCE = 3.0;  // how much a difference of distances counts, of the greater one

// Of the disc: nothing for a mirror.
float blur_radius(Shown here, float distance_m) {
    const float far = sqrt(min(distance_m / frustum_m(here.z), 1.0));
    if (LOBE == LOBE_DIFFUSE) return DIFFUSE_RADIUS_PX * far;
    const float glossy = (1.0 - exp2(-200.0 * here.roughness * here.roughness)) * sqrt(here.roughness);
    return min(SPECULAR_RADIUS_PX * far * glossy, footprint_px(here, distance_m));
}

void for_pixel(ivec2 p) {
    const Shown here = shown(p);
    const vec4 own = texelFetch(radiance, p, 0);
    if (!(here.z > 0.0)) {
        store_blurred(p, vec4(0.0));
        return;
    }
    const float own_m = abs(own.w), radius = blur_radius(here, own_m);
    vec3 sum = own.rgb;
    float weights = 1.0, nearest_m = own_m;
    const mat2 turn = disc_turn(0.0);
    const float drawn = noise_unit(uvec2(noise_hash(uint(p.x) ^ noise_hash(uint(p.y) ^ noise_hash(frame.frame_index))))).x;
    for (int i = 0; i < 8 && radius >= 1.0; ++i) {
        const ivec2 q = p + ivec2(round(radius * (turn * DISC_TAPS[i])));
        if (q == p) continue;
        const Shown there = shown(q);
        const float alike = there.z > 0.0 ? disc_weight(i) * likeness(here, there) : 0.0;
        if (!(alike > 0.0)) continue;
        const vec4 ray = texelFetch(radiance, q, 0);
        const float its_m = abs(ray.w), weight = alike * lasting_weight(HIT_DIFFERENCE * (own_m - its_m) / max(max(own_m, its_m), 1e-4));
        sum += weight * ray.rgb;
        weights += weight;
        if (LOBE == LOBE_SPECULAR && alike > drawn) nearest_m = min(nearest_m, its_m);
    }
    store_blurred(p, vec4(sum / weights, nearest_m));
}

void main() { for_each_pixel(); }
