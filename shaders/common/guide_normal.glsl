// SPDX-License-Identifier: MIT
// Normals as guides keep them: rgb10a2, n * 0.5 + 0.5 with alpha 1. Alpha 0 says "no receiver" and decodes to the zero
// vector, as does a load outside the image where the device returns zeros: such a tap gets no weight without a test.

const float GUIDE_NORMAL_ERROR = 1.0 / 512.0;  // >= sqrt(3) / 1023, the largest distance that 10 bits displace

vec4 encode_normal(vec3 n) { return vec4(0.5 * n + 0.5, 1.0); }

// Unit up to the 10 bits: renormalise where powers of it are taken.
vec3 decode_normal(vec4 texel) { return (2.0 * texel.xyz - 1.0) * texel.w; }

// Normalised; zero stays zero.
vec3 unit_or_zero(vec3 n) { return n * inversesqrt(max(dot(n, n), 1e-12)); }

// saturate(a.b)^32 of the normalised vectors, from their lengths' squares: no square root per tap.
float normal_weight(vec3 a, float a2, vec3 b) {
    const float cosine = max(dot(a, b), 0.0);
    float w = min(cosine * cosine / max(a2 * dot(b, b), 1e-12), 1.0);
    w *= w;
    w *= w;
    w *= w;
    return w * w;
}
