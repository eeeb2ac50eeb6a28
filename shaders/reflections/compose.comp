// SPDX-License-Identifier: MIT
// The lit picture of one metallic-roughness surface per pixel: sun, lamps, glossy and diffuse surroundings, what it sheds. An engine with
// materials of its own multiplies the signals by what these reflect instead.
#include "node.glsl"
#include "common/bilinear.glsl"
#include "common/camera.glsl"
#include "common/finite.glsl"
#include "common/guide_normal.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/sun_sample.glsl"

const uint LOBE_SPECULAR = 0u, LOBE_DIFFUSE = 1u, LOBE = LOBE_SPECULAR;
#include "reflections/environment.glsl"
#include "reflections/lobe.glsl"
#include "reflections/environment_brdf.glsl"

// A disc of radius a is seen by half vectors of an ellipse, a / 2 along the plane of view and sun and a / (2 v.h) across it: so much
// wider is the lobe. A mirror's sun then has the disc's own radiance in its middle, pi E / (pi a^2) of an irradiance of pi E.
float widened(float roughness, float v_h) {
    const float alpha = roughness * roughness, radius = sun.angular_radius;
    return sqrt(sqrt(alpha * alpha + radius * radius / (4.0 * max(v_h, 1e-2))));
}

vec3 light_of_sun(vec3 n, vec3 v, vec3 base_color, vec2 metal_roughness, vec3 diffuse_share, float white) {
    const float n_l = max(dot(n, sun.to_sun), 0.0);
    if (!(n_l > 0.0)) return vec3(0.0);
    const float v_h = dot(v, unit_or_zero(v + sun.to_sun));
    const Lobe lobe = make_lobe(n, v, widened(metal_roughness.y, v_h));
    const vec3 glossy = 3.141592653589793 * density_and_response(lobe, sun.to_sun).y * fresnel(base_color, metal_roughness.x, v_h, white);
    return params.sun_color * (diffuse_share * n_l + glossy);
}

void store_shares(ivec2 p, Reflectance share) {
#if HAS_SPECULAR_SHARE
    store_specular_share(p, vec4(share.specular, 1.0));
#endif
#if HAS_DIFFUSE_SHARE
    store_diffuse_share(p, vec4(share.diffuse, 1.0));
#endif
}

vec3 beyond(ivec2 p) {
    store_shares(p, Reflectance(vec3(0.0), vec3(0.0)));
    return environment_radiance(-to_viewer(p));
}

vec3 surface(ivec2 p) {
    const vec3 n = decode_receiver_normal(imageLoad(receiver_normal, p).xy), v = to_viewer(p);
    const vec3 base_color = texelFetch(albedo, p, 0).rgb;
    const vec2 metal_roughness = texelFetch(material, p, 0).xy;
    const vec2 brdf = white_and_grazing(dot(n, v), metal_roughness.y);
    const Reflectance share = reflectance(base_color, metal_roughness.x, brdf);
    store_shares(p, share);
    vec3 light = texelFetch(emissive, p, 0).rgb + share.specular * texelFetch(specular, p, 0).rgb + share.diffuse * texelFetch(diffuse, p, 0).rgb;
    if (HAS_SUN) light += texelFetch(visibility, p, 0).x * light_of_sun(n, v, base_color, metal_roughness, share.diffuse, brdf.x);
    if (HAS_ILLUMINANCE) light += share.diffuse * (params.exposure * 0.31830989 * texelFetch(illuminance, p, 0).rgb);
    return light;
}

void for_pixel(ivec2 p) {
    const vec3 light = storable(imageLoad(view_depth, p).x > 0.0 ? surface(p) : beyond(p));
    store_lit(p, vec4(light, 1.0));
}

void main() { for_each_pixel(); }
