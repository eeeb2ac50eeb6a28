// SPDX-License-Identifier: MIT
// The simplest shading that shows a shadow: a Lambert surface under one sun, one light that is near, or several, with a constant
// ambient term, in linear HDR, before a plain gradient of sky. An engine uses its own lighting here.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/finite.glsl"
#include "common/guide_normal.glsl"
#include "common/pixels.glsl"
#include "common/sun_sample.glsl"
#include "common/light.glsl"
#include "common/illuminance.glsl"

const vec3 HORIZON = vec3(0.80, 0.87, 0.95), ZENITH = vec3(0.22, 0.42, 0.75);  // times the ambient light

vec3 sky(ivec2 p) { return params.ambient * mix(HORIZON, ZENITH, sqrt(max(view_rise(p), 0.0))) * 4.0; }

vec3 of_lux(vec3 lux) { return params.exposure * 0.31830989 * lux; }

vec3 direct_light(ivec2 p, vec3 n) {
    if (!HAS_LIGHT) return HAS_SUN ? params.sun_color * max(dot(n, sun.to_sun), 0.0) : vec3(0.0);
    return of_lux(unshadowed_lux(n, light.centre - position(p, imageLoad(view_depth, p).x)));
}

vec3 surface(ivec2 p, vec4 guide) {
    const vec3 n = unit_or_zero(decode_normal(guide));
    vec3 direct = vec3(0.0);
    if (HAS_TRANSMITTANCE) direct = direct_light(p, n) * texelFetch(transmittance, p, 0).xyz;
    else if (HAS_VISIBILITY) direct = direct_light(p, n) * texelFetch(visibility, p, 0).x;
    if (HAS_ILLUMINANCE) direct += of_lux(texelFetch(illuminance, p, 0).xyz);
    return texelFetch(albedo, p, 0).xyz * (direct + params.ambient);
}

void for_pixel(ivec2 p) {
    const vec4 guide = imageLoad(guide_normal, p);
    vec3 shown;
    if (guide.w > 0.0)
        shown = surface(p, guide);
    else
        shown = sky(p);
    store_lit(p, vec4(storable(shown), 1.0));
}

void main() { for_each_pixel(); }
