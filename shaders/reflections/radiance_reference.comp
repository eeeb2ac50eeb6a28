// SPDX-License-Identifier: MIT
// The mean of incident radiance under a pixel's lobe by many independent rays, over repetitions of a frozen frame; and what
// one ray of radiance_rays has of it, from which its error follows without being measured.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/ray_origin.glsl"
#include "common/sun_sample.glsl"
#include "common/finite.glsl"
#include "common/hash.glsl"
#include "reflections/closest_hit.glsl"
#include "reflections/hit_surface.glsl"
#include "reflections/environment.glsl"
#include "reflections/incident.glsl"
#include "reflections/lobe.glsl"
#include "reflections/pixel_lobe.glsl"

void for_pixel(ivec2 p) {
    vec4 weighted = vec4(0.0), plain = vec4(0.0);
    const bool surface = imageLoad(view_depth, p).x > 0.0;
    if (surface) {
        const float roughness = pixel_roughness(p);
        const Lobe lobe = pixel_lobe(p, decode_receiver_normal(imageLoad(receiver_normal, p).xy), roughness);
        const RayStart start = ray_start(p, lobe.n);
        const uint pixel = noise_hash(uint(p.x) + noise_hash(uint(p.y) + noise_hash(params.seed + 0x51ED270Bu)));
        for (uint i = 0u; i < params.count; ++i) {
            const uint a = noise_hash(pixel ^ noise_hash(params.first + i)), b = noise_hash(a), c = noise_hash(b);
            bool turned;
            const vec3 direction = sample_lobe(lobe, roughness, noise_unit(uvec2(a, b)), turned);
            const vec3 light = incident(ray_origin(start, lobe.n, direction), direction, noise_unit(uvec2(c, noise_hash(c)))).radiance;
            const float weight = is_mirror(roughness) ? 1.0 : turned ? 0.0 : sample_weight(lobe, direction);
            weighted += weight * vec4(light, 1.0);
            plain += vec4(light, dot(light, light));
        }
        if (params.first != 0u) {
            weighted += imageLoad(weighted_prev, p);
            if (HAS_PLAIN_PREV) plain += imageLoad(plain_prev, p);
        }
    }
    imageStore(weighted_sum, p, weighted);
#if HAS_PLAIN_SUM
    imageStore(plain_sum, p, plain);
#endif
}

void main() { for_each_pixel(); }
