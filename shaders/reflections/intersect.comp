// SPDX-License-Identifier: MIT
// Published form: the listed reflection rays, radiance and length, and their copies to the pixels of a quad that have none.
#include "node.glsl"
const uint LOBE_SPECULAR = 0u, LOBE_DIFFUSE = 1u, LOBE = LOBE_SPECULAR;
const bool HAS_MATERIAL = true;
#include "common/camera.glsl"
#include "common/receiver_normal.glsl"
#include "common/ray_origin.glsl"
#include "common/sun_sample.glsl"
#include "common/finite.glsl"
#include "common/group_rows.glsl"
#include "common/hash.glsl"
#include "reflections/closest_hit.glsl"
#include "reflections/hit_surface.glsl"
#include "reflections/environment.glsl"
#include "reflections/incident.glsl"
#include "reflections/lobe.glsl"
#include "reflections/pixel_lobe.glsl"
#include "reflections/ray_numbers.glsl"

void main() {
    const uint group = entry_of_group();
    if (group >= denoise_args[6]) return;
    const uint word = padded_rays[group * 32u + gl_LocalInvocationIndex];
    if (word == 0xffffffffu) return;
    const ivec2 p = ivec2(word & 0x7fffu, word >> 15 & 0x3fffu);
    const float roughness = pixel_roughness(p);
    const Lobe lobe = pixel_lobe(p, decode_receiver_normal(imageLoad(receiver_normal, p).xy), roughness);
    bool turned;
    const vec3 direction = sample_lobe(lobe, roughness, lobe_numbers(ray_index(p, frame.frame_index)), turned);
    const Incident light = incident(ray_origin(p, lobe.n, direction), direction, sun_numbers(p, frame.frame_index));
    const vec4 texel = vec4(light.radiance, light.distance_m);
    store_radiance(p, texel);
    const ivec2 beside = ivec2(p.x ^ 1, p.y), below = ivec2(p.x, p.y ^ 1);
    if ((word >> 29 & 1u) != 0u) store_radiance(beside, texel);
    if ((word >> 30 & 1u) != 0u) store_radiance(below, texel);
    if ((word >> 31 & 1u) != 0u) store_radiance(ivec2(beside.x, below.y), texel);
}
