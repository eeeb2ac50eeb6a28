// SPDX-License-Identifier: MIT
// Second pass of the denoiser: how much of the past to keep. Where nothing moves, the differences between this
// frame and the past are noise of a known size; sums over the surroundings, of the differences and of their running
// means, with sign and squared, show when they are more than that. Pooled, because one pixel's difference proves nothing;
// with sign, because noise cancels and a moving edge does not; squared, because two moving edges do. The count of frames
// decays by what they are too much. An invocation owns a cell of 4x4 pixels.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/guide_normal.glsl"
#include "common/rounded.glsl"
#include "denoising/many_rays.glsl"
#include "common/dithered.glsl"
#include "common/own_rays.glsl"
#include "common/shadow_state.glsl"
#include "common/view_rays.glsl"
#include "denoising/frame_worth.glsl"
#include "denoising/working_cells.glsl"

const float RESIDUAL_VARIANCE = 0.2 / 1.8;  // of a running mean with weight .2, over that of one frame
const float CLAMP_ERRORS = 5.0;             // insurance only, where something may have changed: the test nearly always comes first
const float GAIN_OF_SURROUNDINGS = 1.5;     // share of the surroundings' mean difference, over that of the own
// Of a frame, squared, beyond what it says itself. Frames that say lit or dark have the least error, by their own word: weighted by that alone
// they pull a mean towards the two.
const float UNTOLD_ERROR = 1e-4, UNTOLD_OF_MANY = 0.01;

// Excess of what the cells around say over what noise says, 0 where nothing moves. In a static penumbra the four
// quotients have means between .5 and 1.1 at every width.
float excess_at(ivec2 cell) {
    const ivec2 grid = cell_grid();
    float d = 0.0, e = 0.0, v = 0.0, d2 = 0.0, e2 = 0.0, c = 0.0;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            const ivec2 q = cell + ivec2(x, y);
            if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, grid)) || is_idle(idle_word(idle_cells[cell_index(q)]))) continue;
            const vec4 first = cells[2u * cell_index(q)], second = cells[2u * cell_index(q) + 1u];
            const float w = (x == 0 ? 1.0 : 0.5) * (y == 0 ? 1.0 : 0.5);
            d += w * first.x;
            e += w * first.y;
            v += w * first.z;
            d2 += w * first.w;
            e2 += w * second.x;
            c += w * w * second.y;
        }
    const float sf = d * d / (c + 1e-4), ss = e * e / (RESIDUAL_VARIANCE * c + 1e-4);
    const float qf = d2 / (v + 1e-4), qs = e2 / (RESIDUAL_VARIANCE * v + 1e-4);
    return max(0.0, sf - 9.0) + max(0.0, ss - 7.0) + 2.0 * max(0.0, qf - 2.5) + 2.0 * max(0.0, qs - 2.5);
}

// Between a frame and a past, where a pixel has one. Of a cell that is idle gather leaves nothing but what it is: they are the same.
struct Difference {
    bool counts;
    float frame_less_past, error;
};

Difference difference_at(ivec2 p) {
    const uint idle = idle_word(idle_cells[cell_index(p / CELL)]);
    Difference d = Difference((idle >> uint(16 + CELL * (p.y % CELL) + p.x % CELL) & 1u) != 0u, 0.0, 0.0);
    if (!is_idle(idle)) {
        const Gathered g = unpack_gathered(imageLoad(gathered, p).xy, 1.0);
        d = Difference(g.counts && g.count > 0.0, g.now - g.past, g.error);
    }
    return d;
}

// Mean difference between frame and past over 3x3 taps of the same surface, `step` pixels apart; 0: nothing is asked.
float surrounding_difference(ivec2 p, int step, ViewRays rays) {
    const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
    const Surface surface = surface_at(rays, n, imageLoad(view_depth, p).x, params.plane_tolerance);
    const ivec2 last = ivec2(frame.size) - 1;
    float sum = 0.0, weights = 0.0;
    for (int y = -1; y <= (step > 0 ? 1 : -2); ++y)
        for (int x = -1; x <= 1; ++x) {
            const ivec2 q = clamp(p + step * ivec2(x, y), ivec2(0), last);
            const Difference d = difference_at(q);
            const bool same = d.counts && shows(surface, vec2(q - p), imageLoad(view_depth, q).x);
            const float w = same ? 1.0 / (d.error * d.error + (MANY_RAYS ? UNTOLD_OF_MANY : UNTOLD_ERROR)) : 0.0;
            sum += w * d.frame_less_past;
            weights += w;
        }
    return weights > 0.0 ? sum / weights : 0.0;
}

bool is_settled(ivec2 cell, bool) {
    const uint idle = idle_word(idle_cells[cell_index(cell)]);
    // Counted by what there is to do: in a branch, as loops of a known length, they take lavapipe longer.
    for (int i = 0; i < (is_idle(idle) ? CELL * CELL : 0); ++i) {
        const uint v = (idle >> uint(i) & 1u) != 0u
                           ? pack_state(ShadowState(1.0, 0.0, 0.0, OwnRays(1.0, 0.0, 0.0, true)), 0u)
                           : pack_state(ShadowState(0.0, 0.0, 0.0, NO_RAYS), 0u);
        const uint count = (idle >> uint(i + 16) & 1u) != 0u
                               ? pack_state(ShadowState(0.0, IDLE_COUNT, 0.0, OwnRays(0.0, IDLE_COUNT, 0.0, false)), 0u)
                               : 0u;
        store_state(cell * CELL + in_cell(i), uvec4(v | count, 0u, 0u, 0u));
    }
    return is_idle(idle);
}

// Of a past, as if the visibility wandered by so little from frame to frame that a mean over COUNT_CAP frames of one ray is best: that
// of frames which are worth more then is over fewer, and is worth sqrt(frames) as much.
float kept(float count) { return count / (1.0 + count / (COUNT_CAP * (COUNT_CAP - 1.0))); }

void work_on(ivec2 cell) {
    const ivec2 first = cell * CELL;
    const vec2 size = cells[2u * cell_index(cell) + 1u].zw;
    const float radius_px = size.x;
    const bool certain = past_kind_of(floatBitsToUint(size.y)) == PAST_CERTAIN;
    const float shrink = 1.0 / (1.0 + 0.5 * excess_at(cell));
    const int step = clamp(int(0.5 * min(radius_px, 8.0) + 0.5), 1, 4);
    const ViewRays corner = view_rays(first, mat3(1.0));
    for (int i = 0; i < CELL * CELL; ++i) {
        const ivec2 offset = in_cell(i), p = first + offset;
        const uvec2 words = imageLoad(gathered, p).xy;
        float worth = 1.0;  // of this frame
        if (HAS_FRAMES && (words.y & TESTED) != 0u) worth = unpack_worth(imageLoad(frames, p).x);
        const Gathered g = unpack_gathered(words, worth);
        ShadowState s = ShadowState(g.now, g.counts ? worth : 0.0, 0.0, g.own);
        if (g.counts && g.count > 0.0) {
            const float off = CLAMP_ERRORS * g.error, past = certain ? g.past : clamp(g.past, g.now - off, g.now + off);
            const float left = g.count * shrink;
            s.count = min(left + worth, MANY_RAYS ? max(COUNT_CAP * sqrt(max(worth, 1.0)), kept(left)) : COUNT_CAP);
            const float a = worth / s.count;
            // Below OWN_RAY_PX no neighbour's ray was asked, so that theirs have nothing to say in common.
            const float a_around = radius_px < (MANY_RAYS ? OWN_RAY_PX : 1.0) ? a : min(1.0, GAIN_OF_SURROUNDINGS * a);
            const float around = surrounding_difference(p, a_around > a ? step : 0, moved(corner, vec2(offset)));
            s.visibility = clamp(past + a * (g.now - past) + (a_around - a) * around, 0.0, 1.0);
            s.residual = shrink < 0.5 ? 0.5 * g.residual : g.residual;
        }
        store_state(p, uvec4(pack_state(s, thresholds_at(p)), 0u, 0u, 0u));
    }
}

void main() {
    settle_cells();
    for (uint i = gl_LocalInvocationIndex; i < left_count; i += lanes_in_workgroup()) work_on(cell_of(left_cells[i]));
}
