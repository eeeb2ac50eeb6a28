// SPDX-License-Identifier: MIT
// The numbers that a pixel's ray is drawn with; `index`: the frame's, where it has one ray.
//
// Includer has common/hash.glsl and declares: param seed.

const uvec2 R2_STEP = uvec2(3242174889u, 2447445414u);  // 2^32 / p, 2^32 / p^2 with p^3 = p + 1

// `time`: the frame's index, where a pixel has one ray in a frame.
uint ray_index(ivec2 p, uint time) { return uint(p.x) + 5u * uint(p.y) + 3083u * time; }

vec2 lobe_numbers(uint index) {
    const uint first = noise_hash(params.seed ^ 0x9E3779B9u), second = noise_hash(first);
    return noise_unit(index * R2_STEP + uvec2(first, second));
}

// Independent of those, for the light at what the ray hits.
vec2 sun_numbers(ivec2 p, uint index_in_time) {
    const uint first = noise_hash(uint(p.x) ^ noise_hash(uint(p.y) ^ noise_hash(index_in_time ^ noise_hash(params.seed))));
    return noise_unit(uvec2(first, noise_hash(first)));
}
