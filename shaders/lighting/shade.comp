// SPDX-License-Identifier: MIT
// The simplest shading that shows a shadow: a Lambert surface under one sun, or one light that is near, with a constant
// ambient term, in linear HDR, before a plain gradient of sky. An engine uses its own lighting here.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/finite.glsl"
#include "common/guide_normal.glsl"
#include "common/pixels.glsl"
#include "common/sun_sample.glsl"
#include "common/light.glsl"
#include "lighting/illuminance.glsl"

const vec3 HORIZON = vec3(0.80, 0.87, 0.95), ZENITH = vec3(0.22, 0.42, 0.75);  // times the ambient light

vec3 sky(ivec2 p) { return params.ambient * mix(HORIZON, ZENITH, sqrt(max(view_rise(p), 0.0))) * 4.0; }

vec3 direct_light(ivec2 p, vec3 n) {
    if (!HAS_LIGHT) return params.sun_color * max(dot(n, sun.to_sun), 0.0);
    return params.exposure * 0.31830989 * illuminance(n, light.centre - position(p, imageLoad(view_depth, p).x));
}

void for_pixel(ivec2 p) {
    const vec4 guide = imageLoad(guide_normal, p);
    const vec3 n = unit_or_zero(decode_normal(guide));
    const vec3 direct = direct_light(p, n) * texelFetch(visibility, p, 0).x;
    const vec3 surface = texelFetch(albedo, p, 0).xyz * (direct + params.ambient);
    const bool receiver = guide.w > 0.0;
    imageStore(lit, p, vec4(storable(receiver ? surface : sky(p)), 1.0));
}

void main() { for_each_pixel(); }
