// SPDX-License-Identifier: MIT
// One level of an edge-aware filter over 3x3 pixels a step apart (Dammertz et al. 2010, "Edge-Avoiding A-Trous Wavelet
// Transform"), guided by the deviation that the signal carries (Schied et al. 2017): what is sure is left alone. Of the output
// alone; the past stays unfiltered.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/guide_normal.glsl"
#include "common/pixels.glsl"
#include "reflections/same_surface.glsl"

const float KERNEL[2] = float[](0.5, 0.25);

// A lobe turns twice as far as the normal, and is as wide as its alpha.
float lobe_weight(Shown here, Shown there) {
    const vec3 across = cross(here.n, there.n);
    const float width = LOBE == LOBE_DIFFUSE ? 0.25 : 0.01 + 0.25 * here.roughness * here.roughness;
    return exp(-0.5 * dot(across, across) / (width * width));
}

void for_pixel(ivec2 p) {
    const Shown here = shown(p);
    const vec4 own = texelFetch(signal, p, 0);
    if (!(here.z > 0.0) || own.w == 0.0) {
        imageStore(filtered, p, own);
        return;
    }
    const float phi = LOBE == LOBE_DIFFUSE ? 6.0 : 1.0 + 5.0 * clamp(5.0 * (here.roughness - 0.2), 0.0, 1.0);
    vec3 sum = KERNEL[0] * KERNEL[0] * own.rgb;
    float weights = KERNEL[0] * KERNEL[0], variance = weights * weights * own.w * own.w;
    for (int i = 0; i < 9; ++i) {
        if (i == 4) continue;
        const ivec2 o = ivec2(i % 3, i / 3) - 1, q = p + o * int(STEP);
        const Shown there = shown(q);
        if (!same_surface(here, there)) continue;
        const vec4 other = texelFetch(signal, q, 0);
        const float difference = length(other.rgb - own.rgb);
        const float weight = KERNEL[abs(o.x)] * KERNEL[abs(o.y)] * lobe_weight(here, there) * exp(-difference / (phi * own.w));
        sum += weight * other.rgb;
        variance += weight * weight * other.w * other.w;
        weights += weight;
    }
    imageStore(filtered, p, vec4(sum / weights, sqrt(variance) / weights));
}

void main() { for_each_pixel(); }
