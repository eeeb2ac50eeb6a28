// SPDX-License-Identifier: MIT
// What a pixel shows, in two words: the view depth as a float of 16 bits of mantissa, without its sign, with 8 bits of perceptual roughness,
// as hosts have it; and the normal of pack_direction(). 0: nothing.
//
// Includer has common/receiver_normal.glsl and common/rounded.glsl.

// `normal`: of pack_direction(). z > 0; roughness of 0 to 1.
uvec2 encode_surface(float z, uint normal, float roughness) {
    return uvec2(floatBitsToUint(z) + 64u >> 7 << 8 | rounded(255.0 * roughness), normal);
}

float surface_depth(uvec2 texel) { return uintBitsToFloat(texel.x >> 8 << 7); }  // off by 2^-17 of it at most; 0: nothing
float surface_roughness(uvec2 texel) { return float(int(texel.x & 255u)) / 255.0; }
vec3 surface_normal(uvec2 texel) { return unpack_direction(texel.y); }
vec3 surface_normal_unscaled(uvec2 texel) { return octahedral_point(unpackSnorm2x16(texel.y)); }
