// SPDX-License-Identifier: MIT
// A pixel's ray as images keep it. rgba16f: radiance, and the distance in metres, negative where the ray hit something that
// moves; 65504 (the largest half) is a miss, or a hit as far. r32ui: the direction, octahedral (pack_direction() of
// common/receiver_normal.glsl).

const float NO_HIT_M = 65504.0;

vec4 encode_ray(vec3 radiance, float distance_m, bool moves) {
    const float kept = clamp(distance_m, 1e-4, NO_HIT_M);
    return vec4(radiance, moves ? -kept : kept);
}

bool missed(vec4 ray) { return !(abs(ray.w) < NO_HIT_M); }
