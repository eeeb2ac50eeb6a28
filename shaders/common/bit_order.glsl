// SPDX-License-Identifier: MIT
// Extremes of numbers by their bits, whose order as integers is that of what is not negative: a software device asks of a
// minimum of floats besides whether either is a number, which takes three instructions instead of one.
#ifndef BIT_ORDER_GLSL
#define BIT_ORDER_GLSL

// The larger one; of two negative numbers either of them. Neither is NaN.
vec4 bit_max(vec4 a, vec4 b) { return intBitsToFloat(max(floatBitsToInt(a), floatBitsToInt(b))); }

// The smaller one, or a negative one (-0 is one) if there is any. Neither is NaN.
vec4 bit_min(vec4 a, vec4 b) { return intBitsToFloat(min(floatBitsToInt(a), floatBitsToInt(b))); }
#endif
