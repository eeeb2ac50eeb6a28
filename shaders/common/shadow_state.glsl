// SPDX-License-Identifier: MIT
// What the sheared denoiser keeps of a pixel from frame to frame, in 4 bytes, and what its passes hand on.

const float COUNT_CAP = 63.75;   // frames; in steps of 1/4
const int CELL = 4;               // pixels whose residuals are summed, per axis

struct ShadowState {
    float visibility;
    float count;     // frames that it stands for; 0: none
    float residual;  // running mean of what new frames said minus this, -.5 .. .5
};

uint pack_state(ShadowState s) {
    const uint v = uint(clamp(s.visibility, 0.0, 1.0) * 65535.0 + 0.5);
    const uint k = uint(clamp(s.count, 0.0, COUNT_CAP) * 4.0 + 0.5);
    const uint e = uint(clamp(s.residual, -0.5, 0.5) * 254.0 + 127.5);  // 0 is kept exactly
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

uvec2 pack_gathered(Gathered g) {
    const uint k = uint(clamp(g.count, 0.0, COUNT_CAP) * 4.0 + 0.5);
    const uint e = uint(clamp(g.residual, -0.5, 0.5) * 254.0 + 127.5);
    const uint se = uint(clamp(g.error, 0.0, 0.5) * 510.0 + 0.5);
    return uvec2(packUnorm2x16(vec2(g.now, g.past)), k | e << 8 | se << 16 | (g.counts ? 1u << 24 : 0u));
}

Gathered unpack_gathered(uvec2 words) {
    const vec2 v = unpackUnorm2x16(words.x);
    return Gathered(v.x, v.y, float(words.y & 0xffu) / 4.0, (float(words.y >> 8 & 0xffu) - 127.0) / 254.0,
                    float(words.y >> 16 & 0xffu) / 510.0, (words.y >> 24 & 1u) != 0u);
}

// A cell's past: nothing can have moved; it need not have been resampled; it was.
const uint PAST_CERTAIN = 0u, PAST_WHOLE = 1u, PAST_RESAMPLED = 2u;
const float TESTS_STEPS = 16.0, TESTS_OCTAVES = 13.0;  // per octave, and below 1
const float ALWAYS_TESTED = 1e9;

// Of a cell, for soften: how far apart its taps are (at most 7 px), what its past is, the rays per frame that test a pixel's
// disc, and what the own rays say that the state is wrong by, squared.
uint pack_softening(ivec2 steps, uint past_kind, float tests, float bias) {
    const uint t = uint(clamp(TESTS_STEPS * (log2(max(tests, 1e-9)) + TESTS_OCTAVES) + 0.5, 0.0, 255.0));
    return uint(steps.x) | uint(steps.y) << 3 | past_kind << 6 | t << 8 | packHalf2x16(vec2(0.0, bias));
}
ivec2 steps_of(uint word) { return ivec2(word & 7u, word >> 3 & 7u); }
uint past_kind_of(uint word) { return word >> 6 & 3u; }
float tests_of(uint word) {
    const uint t = word >> 8 & 0xffu;
    return t == 255u ? ALWAYS_TESTED : exp2(float(t) / TESTS_STEPS - TESTS_OCTAVES);
}
float bias_of(uint word) { return unpackHalf2x16(word).y; }

// A cell without any doubt is known by 16 bits of each kind, which take the place of its penumbra's radius (as a negative number)
// and of the word above: whoever copies it needs no load per pixel. Numbers, not bit patterns, because those may be NaNs.
const float IDLE_COUNT = 8.0;  // frames that it counts for
struct IdleCell {
    uint lit, tests;  // pixel (x, y) is bit 4 y + x
};

vec2 pack_idle(IdleCell c) { return vec2(-1.0 - float(c.lit), float(c.tests)); }
bool is_idle(vec2 packed) { return packed.x < 0.0; }
IdleCell unpack_idle(vec2 packed) { return IdleCell(uint(max(-1.0 - packed.x, 0.0)), uint(clamp(packed.y, 0.0, 65535.0))); }

ivec2 cell_grid() { return (ivec2(frame.size) + CELL - 1) / CELL; }
uint cell_index(ivec2 cell) { return uint(cell.y * cell_grid().x + cell.x); }
