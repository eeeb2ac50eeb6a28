// SPDX-License-Identifier: MIT
// Published form: what reproject, prefilter and resolve share: the listed tile, 16x16 texels of radiance around it in shared
// memory in half precision (2 KiB), their Gaussian mean and variance, temporal variance.
//
// Includer declares: buffers denoiser_tiles, denoise_args; defines TILE_RADIANCE(p), the image that is loaded.
#include "common/group_rows.glsl"

shared uvec2 tile_radiance[256];

// False where the group has no tile. `first`: the tile's first pixel, `p`: this lane's.
bool listed_reflection_tile(out ivec2 first, out ivec2 p) {
    const uint index = entry_of_group();
    if (index >= denoise_args[7]) return false;
    const uint word = denoiser_tiles[index];
    first = ivec2(word & 0xffffu, word >> 16);
    p = first + ivec2(gl_LocalInvocationIndex & 7u, gl_LocalInvocationIndex >> 3);
    return true;
}

bool inside_frame(ivec2 p) { return all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, ivec2(frame.size))); }

void load_tile_radiance(ivec2 first) {
    for (uint i = gl_LocalInvocationIndex; i < 256u; i += 64u) {
        const ivec2 q = first - 4 + ivec2(i & 15u, i >> 4);
        const vec4 texel = inside_frame(q) ? TILE_RADIANCE(q) : vec4(0.0);
        tile_radiance[i] = uvec2(packHalf2x16(texel.xy), packHalf2x16(texel.zw));
    }
    barrier();
}

// `offset` from this lane's pixel, -4..4 each.
vec4 around_lane(ivec2 offset) {
    const ivec2 at = ivec2(gl_LocalInvocationIndex & 7u, gl_LocalInvocationIndex >> 3) + 4 + offset;
    const uvec2 word = tile_radiance[at.y * 16 + at.x];
    return vec4(unpackHalf2x16(word.x), unpackHalf2x16(word.y));
}

struct LocalStatistics {
    vec3 mean, variance;
};

// Published: 81 loads by brute force where two passes of 9 would do; its half-precision sums are single here.
LocalStatistics local_statistics() {
    vec3 sum = vec3(0.0), squares = vec3(0.0);
    float weights = 0.0;
    for (int y = -4; y <= 4; ++y)
        for (int x = -4; x <= 4; ++x) {
            const float weight = exp(-3.0 * float(x * x + y * y) / 25.0);
            const vec3 c = around_lane(ivec2(x, y)).rgb;
            sum += weight * c;
            squares += weight * c * c;
            weights += weight;
        }
    const vec3 mean = sum / weights;
    return LocalStatistics(mean, abs(squares / weights - mean * mean));
}

float published_luminance(vec3 c) { return max(dot(c, vec3(0.299, 0.587, 0.114)), 1e-3); }

float temporal_variance(vec3 history, vec3 c) {
    const float a = published_luminance(history), b = published_luminance(c);
    const float difference = (a - b) / max(max(a, b), 0.5);
    return difference * difference;
}

// Towards the middle of the box.
vec3 clip_to_box(vec3 low, vec3 high, vec3 c) {
    const vec3 middle = 0.5 * (low + high), extent = 0.5 * (high - low) + 0.001;
    const vec3 ratio = abs((c - middle) / extent);
    const float farthest = max(max(ratio.x, ratio.y), ratio.z);
    return farthest > 1.0 ? middle + (c - middle) / farthest : c;
}
