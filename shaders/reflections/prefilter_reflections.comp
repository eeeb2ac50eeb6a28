// SPDX-License-Identifier: MIT
// Published form, second pass: 15 fixed neighbours, weighted by surface and by how far their radiance lies from the mean around.
#include "node.glsl"
#define TILE_RADIANCE(q) texelFetch(radiance, q, 0)
#include "common/guide_normal.glsl"
#include "reflections/glossy.glsl"
#include "reflections/published_tile.glsl"
#include "common/bilinear.glsl"
#include "reflections/published_average.glsl"

// Halton (2, 3), stretched to -3..3.
const ivec2 TAPS[15] = ivec2[](ivec2(0, 1), ivec2(-2, 1), ivec2(2, -3), ivec2(-3, 0), ivec2(1, 2), ivec2(-1, -2), ivec2(3, 0),
                               ivec2(-3, 3), ivec2(0, -3), ivec2(-1, -1), ivec2(2, 1), ivec2(-2, -2), ivec2(1, 0), ivec2(0, 2),
                               ivec2(3, -1));

shared uvec2 tile_surface[256];  // normal and variance in half precision
shared float tile_depth[256];

uint around_index(ivec2 offset) {
    const ivec2 at = ivec2(gl_LocalInvocationIndex & 7u, gl_LocalInvocationIndex >> 3) + 4 + offset;
    return uint(at.y * 16 + at.x);
}

vec4 surface_around(ivec2 offset) {
    const uvec2 word = tile_surface[around_index(offset)];
    return vec4(unpackHalf2x16(word.x), unpackHalf2x16(word.y));
}

void load_surfaces(ivec2 first) {
    for (uint i = gl_LocalInvocationIndex; i < 256u; i += 64u) {
        const ivec2 q = first - 4 + ivec2(i & 15u, i >> 4);
        const bool there = inside_frame(q);
        const vec3 n = there ? unit_or_zero(decode_normal(imageLoad(guide_normal, q))) : vec3(0.0);
        const float variance = there ? imageLoad(variance_first, q).x : 0.0;
        tile_surface[i] = uvec2(packHalf2x16(n.xy), packHalf2x16(vec2(n.z, variance)));
        tile_depth[i] = there ? imageLoad(view_depth, q).x : 0.0;
    }
    barrier();
}

float radiance_weight(vec3 c, vec3 average, float variance) {
    return max(exp(-(0.6 + 0.1 * variance) * length(average - c)), 0.01);
}

void main() {
    ivec2 first, p;
    if (!listed_reflection_tile(first, p)) return;
    load_tile_radiance(first);
    load_surfaces(first);
    const float z = inside_frame(p) ? tile_depth[around_index(ivec2(0))] : 0.0;
    if (!(z > 0.0)) return;
    const vec4 c = around_lane(ivec2(0)), surface = surface_around(ivec2(0));
    const float roughness = imageLoad(extracted_roughness, p).x, variance = surface.w;
    if (!(variance > 0.0) || !is_glossy(roughness) || is_mirror_like(roughness)) {
        store_prefiltered(p, c);
        store_variance_second(p, vec4(variance));
        return;
    }
    const vec3 average = average_at(p);
    float weights = radiance_weight(c.rgb, average, variance);
    vec3 sum = weights * c.rgb;
    float variances = weights * weights * variance;
    const float of_variance = max(0.1, 1.0 - exp(-4.4 * variance));
    for (int i = 0; i < 15; ++i) {
        if (!inside_frame(p + TAPS[i])) continue;
        const vec4 other = surface_around(TAPS[i]);
        const vec3 its = around_lane(TAPS[i]).rgb;
        const float z_other = tile_depth[around_index(TAPS[i])];
        // Published defects: the depth's weight grows with z^2, so far away nothing is filtered and near by too much; a power of 512
        // of a cosine in half precision.
        const float weight = pow(max(dot(surface.xyz, other.xyz), 0.0), 512.0) * exp(-abs(z - z_other) * z * 4.0) *
                             radiance_weight(its, average, variance) * of_variance;
        sum += weight * its;
        variances += weight * weight * other.w;
        weights += weight;
    }
    store_prefiltered(p, vec4(sum / weights, c.w));
    store_variance_second(p, vec4(variances / (weights * weights)));
}
