// SPDX-License-Identifier: MIT
// What the denoiser keeps of a pixel from frame to frame, in 4 bytes, and what its passes hand on.
//
// Includer has rounded.glsl, dithered.glsl and own_rays.glsl, and says by the constant MANY_RAYS whether frames may have several rays per pixel.

const int CELL = 4;  // pixels whose residuals are summed, per axis
// A disc's larger radius in pixels, up to which a handful of neighbours' rays would do the own one's average harm.
const float OWN_RAY_PX = 1.25;

struct ShadowState {
    float visibility;
    float count;     // frames that it stands for, 1 to COUNT_CAP; 0: none
    float residual;  // running mean of what new frames said minus this, -.5 .. .5
    OwnRays own;
};

// From the lowest bit, where frames have one ray per pixel: visibility 10, count 6, residual 4 (its sign is the last), own rays 12. Counts are
// 1 + c^2 / 63: no step is as much as two frames, so that one more frame is always one step on. Where they may have several, a past may be
// worth many more frames of one, and a frame any number: the count has 7 bits, 1 + c^2 / 16 rounded by thresholds, and the own rays' mean 6.
const float VISIBILITY_STEPS = 1023.0, RESIDUAL_STEPS = 7.0;
const uint COUNT_BITS = MANY_RAYS ? 7u : 6u, MEAN_BITS = MANY_RAYS ? 6u : 7u, OWN_BITS = MEAN_BITS + 5u;
float most_steps() { return MANY_RAYS ? 126.0 : 62.0; }
float count_steps() { return MANY_RAYS ? 16.0 : 63.0; }
const float COUNT_CAP = 1.0 + 62.0 * 62.0 / 63.0;  // of frames of one ray

uint pack_state(ShadowState s, uint thresholds) {
    const uint v = dithered(clamp(s.visibility, 0.0, 1.0) * VISIBILITY_STEPS, threshold(thresholds, 0u));
    const float most = most_steps() * most_steps(), beyond_one = clamp(count_steps() * (s.count - 1.0), 0.0, most);
    const uint c = MANY_RAYS ? dithered_root(beyond_one / most, most_steps(), threshold(thresholds, 1u)) : rounded(sqrt(beyond_one));
    const uint k = s.count > 0.0 ? 1u + c : 0u;
    const uint e = dithered_root(min(2.0 * abs(s.residual), 1.0), RESIDUAL_STEPS, threshold(thresholds, 2u));
    return v | k << 10 | (e | (s.residual < 0.0 ? 8u : 0u)) << 10u + COUNT_BITS | pack_own(s.own, s.count, mean_steps(), thresholds) << 32u - OWN_BITS;
}

float visibility_in(uint word) { return float(int(word & 0x3ffu)) / VISIBILITY_STEPS; }
float own_visibility_in(uint word) { return float(int(word >> 32u - MEAN_BITS)) / mean_steps(); }
bool has_count(uint word) { return (word >> 10 & (1u << COUNT_BITS) - 1u) != 0u; }
float count_in(uint word) {
    const float c = float(int(word >> 10 & (1u << COUNT_BITS) - 1u)) - 1.0;
    return c < 0.0 ? 0.0 : 1.0 + c * c / count_steps();
}

float residual_in(uint word) {
    const uint residual = word >> 10u + COUNT_BITS;
    const float e = 0.5 * squared(residual & 7u, RESIDUAL_STEPS);
    return (residual & 8u) != 0u ? -e : e;
}

ShadowState unpack_state(uint word) {
    const float count = count_in(word);
    return ShadowState(visibility_in(word), count, residual_in(word),
                       unpack_own(word >> 32u - OWN_BITS, count, mean_steps()));
}

// Have the pixel's own rays said something else than `lit`, more often than once in a hundred frames?
bool disagrees(uint word, bool lit) {
    const uint mean = word >> 32u - MEAN_BITS;
    if (MANY_RAYS) return has_count(word) && abs(visibility_in(word) - (lit ? 1.0 : 0.0)) > 0.01;
    return has_count(word) && (lit ? mean < rounded(mean_steps()) - 1u : mean > 1u);
}

// One frame's answer beside the reprojected past.
struct Gathered {
    float now, past;  // visibilities
    float count;      // of the past; 0: there is none
    float residual;   // running mean, this frame included
    float error;      // standard error of `now`, at most .5
    bool counts;      // a receiver that looks at the sun
    OwnRays own;      // this frame included
};

const uint TESTED = 1u << 15;
// Multiples, so that a state goes through unchanged: what rounding it added would add up over the frames.
const float GATHERED_STEPS = 2.0 * VISIBILITY_STEPS, GATHERED_MEAN_STEPS = MANY_RAYS ? 32.0 * 63.0 : 16.0 * 127.0;

// What the state will stand for; `worth`: this frame's.
float frames_with(float count, float worth) { return MANY_RAYS ? count + worth : min(count + 1.0, COUNT_CAP); }

uvec2 pack_gathered(Gathered g, float worth, uint thresholds) {
    const uint now = rounded(clamp(g.now, 0.0, 1.0) * GATHERED_STEPS), past = rounded(clamp(g.past, 0.0, 1.0) * GATHERED_STEPS);
    const uint e = rounded(clamp(g.residual, -0.5, 0.5) * 1022.0 + 511.0);  // 0 is kept exactly
    uint k = rounded(min(g.count, COUNT_CAP) * 4.0);
    if (MANY_RAYS) k = g.count > 0.0 ? 1u + rounded(sqrt(clamp(count_steps() * (g.count - 1.0), 0.0, most_steps() * most_steps()))) : 0u;
    const uint se = rounded(sqrt(clamp(g.error, 0.0, 0.5) * 2.0) * 127.0);
    return uvec2(now | past << 11 | e << 22, k | se << 8 | (g.counts ? TESTED : 0u) |
                                                 pack_own(g.own, frames_with(g.count, worth), GATHERED_MEAN_STEPS, thresholds) << 16);
}

Gathered unpack_gathered(uvec2 words, float worth) {
    const ivec2 v = ivec2(words.x & 0x7ffu, words.x >> 11 & 0x7ffu);
    const float count = MANY_RAYS ? count_in((words.y & 0xffu) << 10) : float(int(words.y & 0xffu)) / 4.0;
    return Gathered(float(v.x) / GATHERED_STEPS, float(v.y) / GATHERED_STEPS, count, (float(int(words.x >> 22)) - 511.0) / 1022.0,
                    0.5 * squared(words.y >> 8 & 0x7fu, 127.0), (words.y & TESTED) != 0u,
                    unpack_own(words.y >> 16, frames_with(count, worth), GATHERED_MEAN_STEPS));
}

// A cell's past: nothing can have moved; it need not have been resampled; it was.
const uint PAST_CERTAIN = 0u, PAST_WHOLE = 1u, PAST_RESAMPLED = 2u;
const float TESTS_STEPS = 7.0, TESTS_OCTAVES = 13.0;  // per octave, and below 1
const uint MOST_TESTS = 127u;
const float ALWAYS_TESTED = 1e9;

const int NEAR_STEP = 7;  // 1 px, and the taps count for less

// Of a cell, for soften: how far apart its taps are (at most 6 px, or NEAR_STEP), what its past is, whether unlike pixels are among its own and
// those next to it, the rays per frame that test a pixel's disc, and what the own rays say that the state is wrong by, squared.
uint pack_softening(ivec2 steps, uint past_kind, bool unlike, float tests, float bias) {
    const uint t = rounded(clamp(TESTS_STEPS * (log2(max(tests, 1e-9)) + TESTS_OCTAVES), 0.0, float(MOST_TESTS)));
    return uint(steps.x) | uint(steps.y) << 3 | past_kind << 6 | (unlike ? 0x100u : 0u) | t << 9 | packHalf2x16(vec2(0.0, bias));
}
ivec2 steps_of(uint word) { return ivec2(word & 7u, word >> 3 & 7u); }
uint past_kind_of(uint word) { return word >> 6 & 3u; }
bool unlike_in(uint word) { return (word & 0x100u) != 0u; }
float tests_of(uint word) {
    const uint t = word >> 9 & MOST_TESTS;
    return t == MOST_TESTS ? ALWAYS_TESTED : exp2(float(t) / TESTS_STEPS - TESTS_OCTAVES);
}
float bias_of(uint word) { return unpackHalf2x16(word).y; }

// A cell without any doubt, as a word: the lower 16 bits say which pixels are lit, the upper ones which of them look at the sun;
// pixel (x, y) is bit 4 y + x. All that look at it say the same, so that two that do not mean a cell with work.
const uint NOT_IDLE = 0x00030001u;
// In idle_cells, where 0, as which a past begins that nothing has left, is a cell with work.
uint idle_word(uint stored) { return stored ^ NOT_IDLE; }
const float IDLE_COUNT = 8.0;  // frames that an idle cell counts for

bool is_idle(uint word) { return word != NOT_IDLE; }
bool idled_as(uint word, bool lit) { return is_idle(word) && (word >> 16 & (lit ? ~word : word)) == 0u; }

ivec2 cell_grid() { return (ivec2(frame.size) + CELL - 1) / CELL; }
uint cell_index(ivec2 cell, uvec2 size) { return uint(cell.y * ((int(size.x) + CELL - 1) / CELL) + cell.x); }
uint cell_index(ivec2 cell) { return cell_index(cell, uvec2(frame.size)); }
