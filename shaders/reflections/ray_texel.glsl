// SPDX-License-Identifier: MIT
// A pixel's ray as images keep it. rgba16f: radiance, and the distance in metres, negative where the ray hit something that
// moves; 65504 (the largest half) is a miss, or a hit as far, 0
// says that the pixel has no ray in this frame. r32ui: the direction, octahedral (pack_direction() of
// common/receiver_normal.glsl).

const float NO_HIT_M = 65504.0;

vec4 encode_ray(vec3 radiance, float distance_m, bool moves) {
    const float kept = clamp(distance_m, 1e-4, NO_HIT_M);
    return vec4(radiance, moves ? -kept : kept);
}

bool has_ray(vec4 ray) { return ray.w != 0.0; }
bool missed(vec4 ray) { return !(abs(ray.w) < NO_HIT_M); }
