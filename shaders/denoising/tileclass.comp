// SPDX-License-Identifier: MIT
// Tile classification and temporal accumulation of one-bit shadow samples, in the published form of the FidelityFX
// Shadow Denoiser 1.x: its formulas and constants, its borders (nothing outside the image, and no renormalisation),
// its storage. What it gets wrong is kept on purpose: this is the baseline.
// An invocation owns a column of an 8x8 block, so that a row of bits is weighted once for the eight pixels below and
// above it.
#include "node.glsl"
#include "common/bilinear.glsl"
#include "common/camera.glsl"
#include "common/corners.glsl"
#include "common/guide_normal.glsl"
#include "common/pixels.glsl"
#include "common/round_store.glsl"
#include "common/tiles.glsl"

#define HISTORY(q) imageLoad(history, q).x
BILINEAR(float, history_at, HISTORY)

const int RADIUS = 8;
// exp(-3 i^2 / 81), i = 0 .. 8
const float WEIGHT[9] = float[](1.0, 0.96364044, 0.86230336, 0.71653131, 0.55289200, 0.39616443, 0.26359714, 0.16286807,
                                0.09344611);
const float WEIGHT_SUM = 9.0228857;  // over i = -8 .. 8

// Bits of the 8x4 word `tile`; zero outside the grid.
uint visibility_word(ivec2 tile) {
    const bool inside = all(greaterThanEqual(tile, ivec2(0))) && all(lessThan(tile, tile_grid()));
    return inside ? visibility_words[tile_index(tile)] : 0u;
}

// BLOCK_LIT or BLOCK_SHADOWED where all bits that the filters' seven pixels and the 17x17 mean can reach agree, or where
// there is no receiver at all; else BLOCK_WORK.
uint block_state(ivec2 block) {
    const ivec2 first = ivec2(block.x, 2 * block.y);
    uint any_lit = 0u, any_dark = 0u, any_receiver = 0u;
    for (int y = -2; y <= 3; ++y)
        for (int x = -1; x <= 1; ++x) {
            const ivec2 tile = first + ivec2(x, y);
            const uint word = visibility_word(tile);
            any_lit |= word;
            any_dark |= ~word & inside_mask(tile);
        }
    for (int y = 0; y < 2; ++y)
        if (first.y + y < tile_grid().y) any_receiver |= receiver_words[tile_index(first + ivec2(0, y))];
    if (any_receiver == 0u || any_lit == 0u) return BLOCK_SHADOWED;
    return any_dark == 0u ? BLOCK_LIT : BLOCK_WORK;
}

// Weighted sum of one row's 17 bits around column x: bit i of `bits` is column x - 8 + i.
float row_sum(uint bits) {
    float sum = float(bits >> RADIUS & 1u) * WEIGHT[0];
    for (int i = 1; i <= RADIUS; ++i)
        sum += float((bits >> (RADIUS - i) & 1u) + (bits >> (RADIUS + i) & 1u)) * WEIGHT[i];
    return sum;
}

float column_weight(int distance) { return abs(distance) <= RADIUS ? WEIGHT[min(abs(distance), RADIUS)] : 0.0; }

// 17x17 means of the visibility of the eight pixels of a column.
void local_means(ivec2 block, int column, out float mean[8]) {
    for (int j = 0; j < 8; ++j) mean[j] = 0.0;
    for (int y = -2; y <= 3; ++y) {
        const ivec2 tile = ivec2(block.x, 2 * block.y + y);
        const uint left = visibility_word(tile - ivec2(1, 0)), centre = visibility_word(tile),
                   right = visibility_word(tile + ivec2(1, 0));
        for (int row = 0; row < 4; ++row) {
            const uint bits = (left >> 8 * row & 0xffu) | (centre >> 8 * row & 0xffu) << 8 |
                              (right >> 8 * row & 0xffu) << 16;
            const float sum = row_sum(bits >> column);
            for (int j = 0; j < 8; ++j) mean[j] += sum * column_weight(4 * y + row - j);
        }
    }
    for (int j = 0; j < 8; ++j) mean[j] /= WEIGHT_SUM * WEIGHT_SUM;
}

// Motion of the nearest surface among the four pixels of p's 2x2 quad: silhouettes move with what is in front.
vec2 quad_motion(ivec2 p) {
    ivec2 nearest = p;
    float z = imageLoad(view_depth, p).x;
    for (int i = 0; i < 4; ++i) {
        const ivec2 q = (p & ~1) + corner(i);
        const float z_q = inside_frame(q) ? imageLoad(view_depth, q).x : 0.0;
        if (z_q > 0.0 && z_q < z) {
            z = z_q;
            nearest = q;
        }
    }
    return texelFetch(motion, nearest, 0).xy;
}

// Largest relative error of the previous depth: 1 %, towards 10 % where the surface is seen at a grazing angle.
float depth_tolerance(ivec2 p) {
    const float facing = dot(unit_or_zero(decode_normal(imageLoad(guide_normal, p))), to_viewer(p));
    float grazing = 1.0 - clamp(facing, 0.0, 1.0);
    grazing *= grazing;
    grazing *= grazing;
    return mix(0.01, 0.1, grazing * grazing);
}

// Whether the previous frame saw this surface where it is now said to have been. Comparisons that a NaN fails.
bool seen_before(ivec2 p, float z, Reprojection there) {
    if (!there.on_screen || (frame.flags & FRAME_RESET) != 0u) return false;
    const float expected = previous_depth(position(p, z));
    const float previous = imageLoad(view_depth_prev, previous_texel(there.uv)).x;
    return abs(previous - expected) < depth_tolerance(p) * expected;
}

struct Accumulated {
    vec2 signal;   // visibility, variance
    vec3 moments;  // mean, sum of squared deviations, count
};

Accumulated accumulate(ivec2 p, float z, float mean) {
    const uint word = visibility_word(p / TILE);
    const float bit = (word & pixel_bit(p)) != 0u ? 1.0 : 0.0;
    const Reprojection there = reproject(p, quad_motion(p));

    // Welford's running mean and deviation.
    vec3 moments = vec3(0.0);
    if (seen_before(p, z, there)) moments = imageLoad(moments_prev, previous_texel(there.uv)).xyz;
    const float deviation = bit - moments.x;
    moments.z += 1.0;
    moments.x += deviation / moments.z;
    moments.y += deviation * (bit - moments.x);
    float variance = moments.z > 1.0 ? moments.y / (moments.z - 1.0) : 1.0;

    const float spatial_variance = max(mean - mean * mean, 0.0);
    const float half_box = params.clamp_sigma * sqrt(spatial_variance);
    float before = bit;
    if ((frame.flags & FRAME_RESET) == 0u)
        before = history_at(there.uv * vec2(frame.prev_size), ivec2(frame.prev_size));
    // History that left the box is counted as less.
    const float outside = (before - mean) / max(half_box, 0.001);
    moments.z *= exp(-outside * outside / 20.0);
    if (moments.z < 16.0) variance = max(variance, spatial_variance) * max(16.0 - moments.z, 1.0);

    const float weight = mix(0.05, 1.0, sqrt(max(8.0 - moments.z, 0.0) / 8.0));
    const float clamped = clamp(before, mean - half_box, mean + half_box);
    return Accumulated(vec2(mix(clamped, bit, weight), variance), moments);
}

void store(ivec2 p, Accumulated a) {
    store_reprojected(p, vec4(a.signal, 0.0, 0.0));
    store_moments(p, vec4(round_to(a.moments.xy, FLOAT11_BITS), round_to(a.moments.z, FLOAT10_BITS), 0.0));
}

void main() {
    const int column = int(gl_GlobalInvocationID.x) & 7;
    const ivec2 block = ivec2(gl_GlobalInvocationID.x >> 3, gl_GlobalInvocationID.y);
    const ivec2 top = block * BLOCK + ivec2(column, 0);
    if (!inside_frame(top)) return;

    const uint state = block_state(block);
    if (column == 0) tile_meta[block_index(block)] = state;
    const float uniform_value = state == BLOCK_LIT ? 1.0 : 0.0;
    float mean[8];
    if (state == BLOCK_WORK) local_means(block, column, mean);

    for (int j = 0; j < 8; ++j) {
        const ivec2 p = top + ivec2(0, j);
        if (inside_frame(p)) {
            const float z = imageLoad(view_depth, p).x;
            Accumulated a = Accumulated(vec2(0.0), vec3(0.0));
            if (state != BLOCK_WORK)
                a = Accumulated(vec2(uniform_value, 0.0), vec3(uniform_value, 0.0, z > 0.0 ? 1.0 : 0.0));
            else if (z > 0.0)
                a = accumulate(p, z, mean[j]);
            store(p, a);
        }
    }
}
