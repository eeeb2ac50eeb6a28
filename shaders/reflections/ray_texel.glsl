// SPDX-License-Identifier: MIT
// A pixel's ray as images keep it. rgba16f: radiance, and the distance in metres, negative where the ray hit something that
// moves; 65504 (the largest half) is a miss, or a hit as far, 0
// says that the pixel has no ray in this frame. r32ui: the direction, and what it hit (ray_word.glsl).

const float NO_HIT_M = 65504.0;

vec4 encode_ray(vec3 radiance, float distance_m, bool moves) {
    const float kept = clamp(distance_m, 1e-4, NO_HIT_M);
    return vec4(radiance, moves ? -kept : kept);
}

// Of a ray that might have been aimed: whether it goes into its pixel's cone, whether it was drawn from it, and whether it goes into the
// surface and found nothing. These are signs of the colours, for which black has to be a number that no device takes for 0: the least
// normal half.
const float MARKED_BLACK = 6.103515625e-5;

vec4 mark(vec4 ray, bvec3 marks) { return vec4(mix(ray.rgb, -max(ray.rgb, MARKED_BLACK), marks), ray.a); }
bool went_into_cone(vec4 ray) { return ray.r < 0.0; }
bool was_aimed(vec4 ray) { return ray.g < 0.0; }
bool went_below(vec4 ray) { return ray.b < 0.0; }
vec3 radiance_of(vec4 ray) { return mix(abs(ray.rgb), vec3(0.0), equal(ray.rgb, vec3(-MARKED_BLACK))); }

// What a host traced and is no number would be all that a pixel remembers, and its neighbours.
bool has_ray(vec4 ray) { return ray.w != 0.0 && dot(abs(ray), vec4(1.0)) < 3e5; }
bool missed(vec4 ray) { return !(abs(ray.w) < NO_HIT_M); }
