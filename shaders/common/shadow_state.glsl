// SPDX-License-Identifier: MIT
// What the sheared denoiser keeps of a pixel from frame to frame, in 4 bytes, and what its passes hand on.
//
// Includer has rounded.glsl.

const float COUNT_CAP = 63.75;   // frames; in steps of 1/4
const int CELL = 4;               // pixels whose residuals are summed, per axis

struct ShadowState {
    float visibility;
    float count;     // frames that it stands for; 0: none
    float residual;  // running mean of what new frames said minus this, -.5 .. .5
};

uint pack_state(ShadowState s) {
    const uint v = rounded(clamp(s.visibility, 0.0, 1.0) * 65535.0);
    const uint k = rounded(clamp(s.count, 0.0, COUNT_CAP) * 4.0);
    const uint e = rounded(clamp(s.residual, -0.5, 0.5) * 254.0 + 127.0);  // 0 is kept exactly
    return v | k << 16 | e << 24;
}

ShadowState unpack_state(uint word) {
    return ShadowState(float(word & 0xffffu) / 65535.0, float(word >> 16 & 0xffu) / 4.0,
                       (float(word >> 24) - 127.0) / 254.0);
}

// One frame's answer beside the reprojected past.
struct Gathered {
    float now, past;  // visibilities
    float count;      // of the past; 0: there is none
    float residual;   // running mean, this frame included
    float error;      // standard error of `now`, at most .5
    bool counts;      // a receiver that looks at the sun
};

const uint COUNTS = 1u << 24;

uvec2 pack_gathered(Gathered g) {
    const uint now = rounded(clamp(g.now, 0.0, 1.0) * 65535.0), past = rounded(clamp(g.past, 0.0, 1.0) * 65535.0);
    const uint k = rounded(clamp(g.count, 0.0, COUNT_CAP) * 4.0);
    const uint e = rounded(clamp(g.residual, -0.5, 0.5) * 254.0 + 127.0);
    const uint se = rounded(clamp(g.error, 0.0, 0.5) * 510.0);
    return uvec2(now | past << 16, k | e << 8 | se << 16 | (g.counts ? COUNTS : 0u));
}

Gathered unpack_gathered(uvec2 words) {
    const vec2 v = unpackUnorm2x16(words.x);
    return Gathered(v.x, v.y, float(words.y & 0xffu) / 4.0, (float(words.y >> 8 & 0xffu) - 127.0) / 254.0,
                    float(words.y >> 16 & 0xffu) / 510.0, (words.y & COUNTS) != 0u);
}

// A cell's past: nothing can have moved; it need not have been resampled; it was.
const uint PAST_CERTAIN = 0u, PAST_WHOLE = 1u, PAST_RESAMPLED = 2u;
const float TESTS_STEPS = 8.0, TESTS_OCTAVES = 13.0;  // per octave, and below 1
const uint MOST_TESTS = 127u;
const float ALWAYS_TESTED = 1e9;

// Of a cell, for soften: how far apart its taps are (at most 7 px), what its past is, whether unlike pixels are among its own and
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
const float IDLE_COUNT = 8.0;  // frames that an idle cell counts for

bool is_idle(uint word) { return word != NOT_IDLE; }
bool idled_as(uint word, bool lit) { return is_idle(word) && (word >> 16 & (lit ? ~word : word)) == 0u; }

ivec2 cell_grid() { return (ivec2(frame.size) + CELL - 1) / CELL; }
uint cell_index(ivec2 cell, uvec2 size) { return uint(cell.y * ((int(size.x) + CELL - 1) / CELL) + cell.x); }
uint cell_index(ivec2 cell) { return cell_index(cell, uvec2(frame.size)); }
