// SPDX-License-Identifier: MIT
// PCG as a hash: Jarzynski and Olano 2020, "Hash Functions for GPU Rendering".
uint noise_hash(uint v) {
    uint state = v * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return word >> 22 ^ word;
}

// 32-bit fixed point to [0, 1), 24 bits.
vec2 noise_unit(uvec2 fixed_point) { return vec2(fixed_point >> 8) * (1.0 / 16777216.0); }
