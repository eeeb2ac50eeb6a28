// SPDX-License-Identifier: MIT
// What a light that is near shines through its mask, added to what the lights before it do.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/finite.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/sun_sample.glsl"
#include "common/light.glsl"
#include "common/illuminance.glsl"

void for_pixel(ivec2 p) {
    const float z = imageLoad(view_depth, p).x;
    const vec3 seen = !(z > 0.0) ? vec3(0.0) : HAS_TRANSMITTANCE ? texelFetch(transmittance, p, 0).xyz : vec3(texelFetch(visibility, p, 0).x);
    vec3 lux = HAS_BEFORE ? texelFetch(before, p, 0).xyz : vec3(0.0);
    if (seen != vec3(0.0)) lux += seen * unshadowed_lux(decode_receiver_normal(texelFetch(receiver_normal, p, 0).xy), light.centre - position(p, z));
    store_illuminance(p, vec4(storable(lux), 0.0));
}

void main() { for_each_pixel(); }
