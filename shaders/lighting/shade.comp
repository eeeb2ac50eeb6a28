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

vec3 sky(ivec2 p) {
    const float up = clamp(-to_viewer(p).y, 0.0, 1.0);
    return params.ambient * mix(HORIZON, ZENITH, sqrt(up)) * 4.0;
}

vec3 surface(ivec2 p) {
    const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
    const float open = texelFetch(visibility, p, 0).x;
    vec3 direct = params.sun_color * max(dot(n, sun.to_sun), 0.0) * open;
    if (HAS_LIGHT) direct = params.exposure * 0.31830989 * illuminance(n, light.centre - position(p, imageLoad(view_depth, p).x)) * open;
    return texelFetch(albedo, p, 0).xyz * (direct + params.ambient);
}

void for_pixel(ivec2 p) {
    const bool receiver = imageLoad(view_depth, p).x > 0.0;
    imageStore(lit, p, vec4(storable(receiver ? surface(p) : sky(p)), 1.0));
}

void main() { for_each_pixel(); }
