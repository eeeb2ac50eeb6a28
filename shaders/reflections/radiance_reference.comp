// SPDX-License-Identifier: MIT
// The mean of incident radiance under a pixel's lobe by many independent rays, over repetitions of a frozen frame; and what
// one ray of radiance_rays has of it, from which its error follows without being measured. Under a sky with bright spots each ray
// into the lobe has another one beside it, drawn from the sky's lots; both are weighted by the balance heuristic (Veach and Guibas
// 1995).
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
#include "reflections/environment_lots.glsl"
#include "reflections/incident.glsl"
#include "reflections/lobe.glsl"
#include "reflections/pixel_lobe.glsl"

// Of a direction that either of two rays was drawn in.
float shared_weight(Lobe lobe, vec3 direction) {
    const vec2 own = density_and_response(lobe, direction);
    return own.y > 0.0 ? own.y / (own.x + lot_density(direction)) : 0.0;
}

void for_pixel(ivec2 p) {
    vec4 weighted = vec4(0.0), plain = vec4(0.0);
    const bool surface = imageLoad(view_depth, p).x > 0.0;
    if (surface) {
        const float roughness = pixel_roughness(p);
        const Lobe lobe = pixel_lobe(p, decode_receiver_normal(imageLoad(receiver_normal, p).xy), roughness);
        const bool by_lots = HAS_ENVIRONMENT_LOTS && !is_mirror(roughness);
        const RayStart start = ray_start(p, lobe.n);
        const uint pixel = noise_hash(uint(p.x) + noise_hash(uint(p.y) + noise_hash(params.seed + 0x51ED270Bu)));
        for (uint i = 0u; i < params.count; ++i) {
            const uint a = noise_hash(pixel ^ noise_hash(params.first + i)), b = noise_hash(a), c = noise_hash(b);
            bool turned;
            const vec2 u = noise_unit(uvec2(a, b));
            const vec3 direction = sample_lobe(lobe, roughness, u, turned);
            const vec3 light = incident(ray_origin(start, lobe.n, direction), direction, noise_unit(uvec2(c, noise_hash(c)))).radiance;
            float weight = is_mirror(roughness) ? 1.0 : turned ? 0.0 : sample_weight(lobe, direction);
            if (by_lots) {
                // What was drawn anew is denser than the lobe says.
                weight = dot(lobe.n, draw_direction(lobe, u)) > 1e-5 ? shared_weight(lobe, direction) : 0.0;
                const uint d = noise_hash(a ^ 0x9E3779B9u), e = noise_hash(b ^ 0x9E3779B9u);  // other sequences
                const vec3 by_lot = draw_lot(d);
                const float its_weight = dot(lobe.n, by_lot) > 1e-5 ? shared_weight(lobe, by_lot) : 0.0;
                if (its_weight > 0.0)
                    weighted += its_weight * vec4(incident(ray_origin(start, lobe.n, by_lot), by_lot, noise_unit(uvec2(e, noise_hash(e)))).radiance, 1.0);
            }
            weighted += weight * vec4(light, 1.0);
            plain += vec4(light, dot(light, light));
        }
        if (params.first != 0u) {
            weighted += imageLoad(weighted_prev, p);
            if (HAS_PLAIN_PREV) plain += imageLoad(plain_prev, p);
        }
    }
    store_weighted_sum(p, weighted);
#if HAS_PLAIN_SUM
    store_plain_sum(p, plain);
#endif
}

void main() { for_each_pixel(); }
