// SPDX-License-Identifier: MIT
// Rounding to nearest before a value is stored in a small float format. Devices may truncate instead (Mesa's lavapipe
// does), and a value that is fed back through an average of n frames then ends up n / 2 units in the last place too
// small per store: two stores of fp16 in a loop with weight 1 / 20 darken a penumbra by .01 (docs/accuracy.md). After
// this the store is exact, so every device keeps the same bits.
//
// Ties go to even. Denormal results stay as the device rounds them.

const uint HALF_BITS = 10u, FLOAT11_BITS = 6u, FLOAT10_BITS = 5u;  // of the mantissa: fp16, and b10f's two kinds

float round_to(float value, uint mantissa_bits) {
    const uint dropped = 23u - mantissa_bits, unit = 1u << dropped;
    const uint bits = floatBitsToUint(value);
    if ((bits & 0x7f800000u) == 0x7f800000u) return value;  // infinite, or not a number
    return uintBitsToFloat(bits + (unit >> 1) - 1u + (bits >> dropped & 1u) & ~(unit - 1u));
}

vec3 round_to(vec3 v, uint mantissa_bits) {
    return vec3(round_to(v.x, mantissa_bits), round_to(v.y, mantissa_bits), round_to(v.z, mantissa_bits));
}
vec2 round_to(vec2 v, uint mantissa_bits) { return vec2(round_to(v.x, mantissa_bits), round_to(v.y, mantissa_bits)); }
