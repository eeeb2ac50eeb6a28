// SPDX-License-Identifier: MIT
// Temporal average of one-bit shadow samples, and how far a spatial filter may go to finish the work.
// - The average is 1/n of each of the last n <= 32 samples and is kept unfiltered: it converges to the pixel's own
//   visibility, however narrow the penumbra. Low-discrepancy samples make it worth far more than 32 independent ones.
// - n restarts where the surface was not seen before, and shrinks where the shadow moves (common/drift.glsl) and as the
//   sun does (common/sun_change.glsl).
// - Where n is small, what the bits of 3x3 pixels say together joins the average (common/edge_pattern.glsl), for the filters
//   and not for the history.
// - Beside it stands a tolerance: its deviation, wider the softer the shadow's edge is here and 0 at a hard one
//   (common/bit_window.glsl). The filters mix values that differ by less.
// - Blocks of 8x8 pixels whose surroundings agree are what they say, at once and without a history.
// An invocation owns a column of a block.
#include "node.glsl"
#include "common/bit_window.glsl"
#include "common/camera.glsl"
#include "common/drift.glsl"
#include "common/cubic.glsl"
#include "common/guide_normal.glsl"
#include "common/pixels.glsl"
#include "common/previous_surface.glsl"
#include "common/edge_pattern.glsl"
#include "common/tiles.glsl"
#include "common/sun_change.glsl"

const float CAP = 32.0;                 // samples
const float RESIDUAL_VARIANCE = 0.003;  // of a pixel that has always been lit, so that one surprise is not proof
const float SAME_FACE = 0.9;            // cosine: beyond a crease the sun stands differently
const float HARD = 2.2;                 // softness below which nothing is filtered
const float LARGEST_GAIN = 20.0;        // of the filters' tolerance squared
const float PRIOR = 2.0;                // samples that the neighbourhood's mean is worth in a pixel's variance

Surroundings surroundings(ivec2 block) {
    Surroundings around;
    for (int y = 0; y < 6; ++y)
        for (int x = 0; x < 3; ++x) {
            const ivec2 tile = ivec2(block.x - 1 + x, 2 * block.y - 2 + y);
            const bool inside = all(greaterThanEqual(tile, ivec2(0))) && all(lessThan(tile, tile_grid()));
            around.lit[y][x] = inside ? visibility_words[tile_index(tile)] : 0u;
            around.receivers[y][x] = inside ? receiver_words[tile_index(tile)] : 0u;
        }
    return around;
}

// Uniform where all receivers agree that the filters' seven pixels and the windows can reach.
uint block_state(Surroundings around) {
    uvec3 any_lit = uvec3(0u), any_dark = uvec3(0u);
    for (int y = 0; y < 6; ++y) {
        any_lit |= around.lit[y] & around.receivers[y];
        any_dark |= ~around.lit[y] & around.receivers[y];
    }
    if ((any_dark.x | any_dark.y | any_dark.z) == 0u) return BLOCK_LIT;  // also where there is no receiver
    return (any_lit.x | any_lit.y | any_lit.z) == 0u ? BLOCK_SHADOWED : BLOCK_WORK;
}

struct Past {
    float visibility;
    float count;     // 0: there is none
    float contrast;  // between the texels that it is resampled from; 0: it is one of them
};

const Past NO_PAST = Past(0.0, 0.0, 0.0);

// What a texel of the previous frame says, unless it is not a visibility.
bool history_at(ivec2 q, out float visibility) {
    visibility = imageLoad(history, q).x;
    return visibility >= 0.0 && visibility <= 1.0;
}

bool shows_plane(ivec2 q, vec3 here, vec3 n, float tolerance_m) {
    if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, ivec2(frame.prev_size)))) return false;
    const float z = imageLoad(view_depth_prev, q).x;
    const vec3 n_prev = unit_or_zero(decode_normal(imageLoad(guide_normal_prev, q)));
    return z > 0.0 && dot(n, n_prev) > SAME_FACE && lies_on_plane(previous_position(q, z), here, n, tolerance_m);
}

// Resampling by halves and halves again would blur the history a little every frame.
float sharper(ivec2 corner, vec2 t, float low, float high, float linear) {
    const vec4 wx = cubic_weights(t.x), wy = cubic_weights(t.y);
    const ivec2 last = ivec2(frame.prev_size) - 1;
    float sum = 0.0;
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x)
            sum += wx[x] * wy[y] * imageLoad(history, clamp(corner + ivec2(x, y) - 1, ivec2(0), last)).x;
    return sum >= low ? min(sum, high) : sum < low ? low : linear;  // the last for NaN
}

Past past_of(ivec2 p, float z) {
    const Reprojection there = reproject(p, texelFetch(motion, p, 0).xy);
    if (!there.on_screen || (frame.flags & FRAME_RESET) != 0u) return NO_PAST;
    const vec3 here = position(p, z);
    const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
    const float tolerance_m = params.plane_tolerance * pixel_span_m(z);

    const vec2 at = there.uv * vec2(frame.prev_size) - 0.5;
    const ivec2 corner = ivec2(floor(at + 1e-3));
    const vec2 t = clamp(at - vec2(corner), 0.0, 1.0);
    float weights = 0.0, visibility = 0.0, count = 0.0, low = 1.0, high = 0.0;
    for (int i = 0; i < 4; ++i) {
        const ivec2 q = corner + ivec2(i & 1, i >> 1);
        const float weight = ((i & 1) != 0 ? t.x : 1.0 - t.x) * ((i >> 1) != 0 ? t.y : 1.0 - t.y);
        float v = 0.0;
        if (weight > 1e-3 && shows_plane(q, here, n, tolerance_m) && history_at(q, v)) {
            weights += weight;
            visibility += weight * v;
            count += weight * imageLoad(count_prev, q).x;
            low = min(low, v);
            high = max(high, v);
        }
    }
    if (weights == 0.0) return NO_PAST;
    Past past = Past(visibility / weights, CAP * count / weights, max(high - low, 0.0));
    if (weights > 0.99 && high > low) past.visibility = sharper(corner, t, low, high, past.visibility);
    return past;
}
// Nothing moves: the pixel's past is its own. Where jitter moved an edge across it, the past is that of both surfaces,
// as the picture is; a pixel that showed the sky has none, its count is 0.
Past own_past(ivec2 p) {
    float v = 0.0;
    if ((frame.flags & FRAME_RESET) != 0u || !history_at(p, v)) return NO_PAST;
    return Past(v, CAP * imageLoad(count_prev, p).x, 0.0);
}

// A past that saw another sun.
Past under_this_sun(Past past) {
    if (!HAS_SUN || !HAS_SUN_PREV) return past;
    past.count = samples_left(past.count, sun_share(sun, sun_prev));
    if (past.count <= 0.0) return NO_PAST;
    return past;
}

// Where neighbouring texels differ by more than their noise, the camera's motion has put an edge between them whose
// place resampling cannot know and this frame's sample does. From 0: nothing of the kind, to 1: a hard edge.
float resampling_error(Past past) {
    const float noise = pow(max(past.count, 1.0), -CONVERGENCE);  // of the squared difference of two texels, and some more
    return clamp(past.contrast * past.contrast - noise, 0.0, 1.0);
}

Residuals residual(Past past, float bit) {
    if (past.count <= 0.0) return Residuals(0.0, 0.0);
    const float variance = past.visibility * (1.0 - past.visibility) * (1.0 + 1.0 / past.count);
    return Residuals(bit - past.visibility, variance + RESIDUAL_VARIANCE);
}

float tolerance_of(float visibility, float count, float mean, float softness) {
    const float p = (count * visibility + PRIOR * mean) / (count + PRIOR);
    const float excess = max(softness - HARD, 0.0), gain = min(excess * excess, LARGEST_GAIN);
    return params.softness * sqrt(max(p * (1.0 - p), 0.0) * pow(count, -CONVERGENCE) * gain);
}

// To a multiple of 2^-11, which fp16 holds exactly up to 1; up or down at random, right on average. Rounding to nearest
// would stop an average over 32 frames 0.008 short of 1.
float stochastically_rounded(float visibility, ivec2 p) {
    uint h = (uint(p.x) * 0x9E3779B1u) ^ (uint(p.y) * 0x85EBCA77u) ^ (frame.frame_index * 0xC2B2AE3Du);
    h = (h ^ h >> 15) * 0x2C1B3C6Du;
    h = (h ^ h >> 12) * 0x297A2D39u;
    const float random = float((h ^ h >> 15) >> 8) / 16777216.0;
    return floor(visibility * 2048.0 + random) / 2048.0;
}

// What the 3x3 pixels around row j of the column say.
float pattern_at(Surroundings around, int column, int j, uint surface) {
    uint lit = 0u, receivers = 0u;
    for (int i = 0; i < 3; ++i) {
        const int y = 7 + j + i;
        lit |= (row_of(around.lit[y >> 2], y & 3) >> (column + 7) & 7u) << 3 * i;
        receivers |= (row_of(around.receivers[y >> 2], y & 3) >> (column + 7) & 7u) << 3 * i;
    }
    return visibility_by_pattern(edge_pattern(lit, receivers & surface));
}

void main() {
    const int lane = int(gl_LocalInvocationID.x), column = lane & 7;
    const ivec2 block = ivec2(gl_GlobalInvocationID.x >> 3, gl_GlobalInvocationID.y);
    const ivec2 top = block * BLOCK + ivec2(column, 0);
    const bool inside = inside_frame(top);

    uint state = BLOCK_LIT;
    Surroundings around;
    Past past[8];
    float bit[8];
    Residuals upper = Residuals(0.0, 0.0), lower = Residuals(0.0, 0.0);
    if (inside) {
        around = surroundings(block);
        state = block_state(around);
        // Counted by what there is to do: older software devices run both sides of a branch, but no loop that no lane enters.
        for (int j = 0; j < (state == BLOCK_WORK ? 8 : 0); ++j) {
            const ivec2 p = top + ivec2(0, j);
            const uint mask = pixel_bit(p);
            past[j] = NO_PAST;
            bit[j] = (around.lit[2 + (j >> 2)].y & mask) != 0u ? 1.0 : 0.0;
            if ((around.receivers[2 + (j >> 2)].y & mask) != 0u) {
                if (HAS_MOTION)
                    past[j] = past_of(p, imageLoad(view_depth, p).x);
                else
                    past[j] = own_past(p);
                past[j] = under_this_sun(past[j]);
                const Residuals r = residual(past[j], bit[j]);
                if (j < 4) upper = Residuals(upper.sum + r.sum, upper.variance + r.variance);
                else lower = Residuals(lower.sum + r.sum, lower.variance + r.variance);
            }
        }
    }
    share_residuals(lane, upper, lower);
    barrier();
    if (!inside) return;

    if (column == 0) tile_meta[block_index(block)] = state;
    vec2 forget = vec2(1.0);  // upper and lower rows
    float means[8];
    vec2 softness;
    for (int once = 0; once < (state == BLOCK_WORK ? 1 : 0); ++once) {
        const vec2 drifted = max(vec2(drift(lane, params.drift_threshold)), local_drift(lane, params.local_threshold));
        forget = 1.0 / (1.0 + 0.5 * drifted);
        local_means(around, column, means);
        softness = softness_of(around, column);
    }
    for (int j = 0; j < 8; ++j) {
        const ivec2 p = top + ivec2(0, j);
        if (inside_frame(p)) {
            const bool receives = (around.receivers[2 + (j >> 2)].y & pixel_bit(p)) != 0u;
            // A uniform block's pixels, and whatever receives nothing: that is lit.
            float average = state == BLOCK_SHADOWED && receives ? 0.0 : 1.0;
            vec2 filtered = vec2(average, 0.0);
            float samples = receives ? CAP : 0.0;
            if (state == BLOCK_WORK && receives) {
                const float error = resampling_error(past[j]);
                const float trusted = min(past[j].count, (1.0 - error) / max(error, 1e-3));
                samples = min(trusted * (j < 4 ? forget.x : forget.y) + 1.0, CAP);
                average = mix(past[j].visibility, bit[j], 1.0 / samples);
                filtered.y = tolerance_of(average, samples, means[j], j < 4 ? softness.x : softness.y) *
                             (1.0 - error) * (1.0 - error);
                const float share = share_of_pattern(samples, params.pattern_samples);
                filtered.x = average;
                if (share > LEAST_SHARE)
                    filtered.x = mix(average, pattern_at(around, column, j, surface_around(p)), share);
                average = stochastically_rounded(average, p);
            }
            imageStore(accumulated, p, vec4(average));
            imageStore(signal, p, vec4(filtered, 0.0, 0.0));
            imageStore(count, p, vec4(samples / CAP));
        }
    }
}
