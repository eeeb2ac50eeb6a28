// SPDX-License-Identifier: MIT
// One pass of an edge-avoiding a-trous filter over (visibility, variance): 3x3 taps at distance STEP, stopped by
// differences of visibility (in units of the local deviation), of view depth and of normal. Published form of the
// FidelityFX Shadow Denoiser 1.x; after Dammertz et al., Edge-avoiding a-trous wavelet transform (2010), and Schied et
// al., SVGF (2017). Taps outside the image count as nothing, also in the variance that sets the deviation.
#include "node.glsl"
#include "common/guide_normal.glsl"
#include "common/pixels.glsl"
#include "common/tiles.glsl"

const float LOG2_E = 1.442695;
const float DEPTH_SIGMA_M = 1.0;  // an absolute length, as published
const float SIDE = 2.0 / 3.0;     // kernel: 2/3, 1, 2/3 per axis

float variance_at(ivec2 p) { return inside_frame(p) ? imageLoad(signal, p).y : 0.0; }

// Deviation from the variance under a 3x3 binomial kernel; 1e-9 keeps it from vanishing at convergence.
float local_deviation(ivec2 p) {
    float variance = 0.0;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            const float weight = (x == 0 ? 0.5 : 0.25) * (y == 0 ? 0.5 : 0.25);
            variance += weight * variance_at(p + ivec2(x, y));
        }
    return sqrt(max(variance + 1e-9, 0.0));
}

vec2 filter_at(ivec2 p, float z) {
    const vec2 centre = imageLoad(signal, p).xy;
    const vec3 n = decode_normal(imageLoad(guide_normal, p));
    const float n2 = dot(n, n);
    const float per_deviation = LOG2_E / local_deviation(p);

    vec2 sum = centre;
    float weights = 1.0;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            const ivec2 q = p + STEP * ivec2(x, y);
            if ((x != 0 || y != 0) && inside_frame(q)) {
                const vec2 tap = imageLoad(signal, q).xy;
                const float z_tap = imageLoad(view_depth, q).x;
                const float kernel = (x == 0 ? 1.0 : SIDE) * (y == 0 ? 1.0 : SIDE);
                const float stop = exp2(-abs(centre.x - tap.x) * per_deviation - abs(z - z_tap) * (LOG2_E / DEPTH_SIGMA_M));
                const float weight = kernel * stop * normal_weight(n, n2, decode_normal(imageLoad(guide_normal, q)));
                if (z_tap > 0.0) {
                    sum += vec2(weight, weight * weight) * tap;
                    weights += weight;
                }
            }
        }
    return sum / vec2(weights, weights * weights);
}

// The published last pass steepens what has converged: v^1.2 where the variance is gone.
float with_contrast(vec2 s) { return CONTRAST ? pow(abs(s.x), max(1.2 - s.y, 1.0)) : s.x; }

void for_pixel(ivec2 p) {
    const uint state = tile_meta[block_index(p / BLOCK)];
    const float z = imageLoad(view_depth, p).x;
    vec2 s = vec2(state == BLOCK_LIT ? 1.0 : 0.0, 0.0);
    if (state == BLOCK_WORK && z > 0.0) s = filter_at(p, z);
    s.x = with_contrast(s);
    store_filtered(p, vec4(s, 0.0, 0.0));
}

void main() { for_each_pixel(); }
