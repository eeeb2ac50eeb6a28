// SPDX-License-Identifier: MIT
// One ray per pixel, or in some pixels by turns, into its lobe, shaded where it hits: radiance, distance and direction, all that
// later passes know of it.
// Numbers: the R2 sequence (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences") at x + 5 y + 3083 frame:
// windows of pixels and of frames are both filled evenly. Several rays are numbered as those of as many frames.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/rounded.glsl"
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
#include "reflections/emitters.glsl"
#include "reflections/ray_texel.glsl"
#include "reflections/ray_word.glsl"
#include "reflections/ray_numbers.glsl"
#include "reflections/ray_turns.glsl"

void store(ivec2 p, vec4 ray, uint direction) {
    store_radiance(p, ray);
#if HAS_RAY_DIRECTION
    store_ray_direction(p, uvec4(direction));
#endif
}

// `marks`: as mark() takes them.
Incident ray_of(ivec2 p, Lobe lobe, float roughness, uint time, out vec3 direction, out float weight, out bvec3 marks) {
    const uint index = is_narrow(roughness) ? ray_index(p, time) : index_in_turn(p, time);
    vec2 u = lobe_numbers(index);
    bool turned = false, aims = false;
    Emitter emitter = Emitter(vec3(0.0), 0.0);
    vec3 x = vec3(0.0);
    if (HAS_AIMED) {
        emitter = emitter_of(rounded(255.0 * imageLoad(aimed, p).x));
        x = position(p, imageLoad(view_depth, p).x);
        if (emitter.radius > 0.0) {
            aims = u.x < 0.5;
            u.x = fract(2.0 * u.x);
        }
    }
    // Where rays are aimed none is drawn anew, since the density of what is drawn in the end is not known.
    direction = aims ? aimed_direction(emitter, x, u) : HAS_AIMED && !is_mirror(roughness) ? draw_direction(lobe, u) : sample_lobe(lobe, roughness, u, turned);
    const bool below = !(dot(lobe.n, direction) > 0.0);
    marks = bvec3(aims || lies_in_cone(emitter, x, direction), aims, below);
    weight = is_mirror(roughness) ? 1.0 : turned ? 0.0 : sample_weight(lobe, direction);
    if (below) return Incident(vec3(0.0), MISS_M, vec3(0.0), false);
    return incident(ray_origin(p, lobe.n, direction), direction, sun_numbers(p, time));
}

void for_pixel(ivec2 p) {
    if (!(imageLoad(view_depth, p).x > 0.0)) {
        store(p, vec4(0.0), 0u);
        return;
    }
    const float roughness = pixel_roughness(p);
    if (!in_turn(p) && !is_narrow(roughness)) {
        store(p, vec4(0.0), 0u);
        return;
    }
    const Lobe lobe = pixel_lobe(p, unpack_direction(imageLoad(octahedral_normal, p).x), roughness);
    const uint first = frame.frame_index * RAYS_PER_PIXEL;
    vec3 direction;
    float weight;
    bvec3 marks;
    Incident light = ray_of(p, lobe, roughness, first, direction, weight, marks);
    if (RAYS_PER_PIXEL > 1u) {  // one has no weight
        vec4 sum = weight * vec4(light.radiance, 1.0);
        for (uint i = 1u; i < RAYS_PER_PIXEL; ++i) {
            light = ray_of(p, lobe, roughness, first + i, direction, weight, marks);
            sum += weight * vec4(light.radiance, 1.0);
        }
        if (sum.w > 0.0) light.radiance = sum.rgb / sum.w;
    }
    const vec4 ray = mark(encode_ray(light.radiance, light.distance_m, light.moves), marks);
    store(p, ray, encode_ray_word(RayWord(direction, missed(ray) ? -direction : light.normal), roughness));
}

void main() { for_each_pixel_in_turn(); }
