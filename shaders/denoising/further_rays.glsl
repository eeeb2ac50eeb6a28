// SPDX-License-Identifier: MIT
// A pixel's own rays, where it has several, beside what its neighbours' say.
//
// Includer has sheared_gather.glsl.
#include "denoising/further_bits.glsl"

// Of others' further rays, what they make a frame worth to who has none. They go where a first ray was an exception, so that frames with
// many say something else than those with few, and a mean by their number is off.
const float OTHERS_SHARE = 0.5;
const float EVEN_GAIN = 0.25;  // an estimate of many rays is packed as of a quarter of them, with a quarter of the variance

float rays_worth(Estimate e) { return e.rays > 1.0 ? e.rays / e.gain : 0.0; }

Estimate with_own(Estimate around, uint word, bool first_lit) {
    if (word == 0u) return around;
    const float own = even_worth(word), all = own + rays_worth(around);
    const float v = around.visibility + own / all * (lit_share(word, first_lit) - around.visibility);
    return Estimate(v, EVEN_GAIN * all, EVEN_GAIN, around.each);
}

// Frames with one ray per pixel that this one is worth: as many as its rays are worth those of one frame. They lie evenly, but so do a
// pixel's rays of one frame after the other, n frames of which are worth n^EVEN_POINTS as well.
float frames_worth(Estimate around, uint word) {
    const float own = word == 0u ? 1.0 : even_worth(word), others = rays_worth(around);
    const float each = word == 0u ? max(OTHERS_SHARE * around.each, 1.0) : around.each;
    const float worth = (others > 0.0 && word == 0u ? others : own + others) / max(others / each, 1.0);
    return pow(max(worth, 1.0), 1.0 / EVEN_POINTS);
}

// Frames that a past is worth at most where the pixel's own rays say otherwise: as many as are off by what the two differ, beyond the noise of
// these. Spread evenly they have less of it than v (1 - v) / n before an edge, but not behind leaves.
const float OWN_NOISE = 8.0;  // squared deviations that prove nothing
float believed(Past past, uint word, bool first_lit) {
    const float own = float(further_count(word) + 1u), share = lit_share(word, first_lit), d = share - past.visibility;
    const float v = (past.count * past.visibility + own * share) / (past.count + own), variance = v * (1.0 - v);
    const float bias = d * d - OWN_NOISE * variance / own;  // squared
    return bias > 0.0 ? variance / bias : past.count;
}

// The same of the own rays' mean: where nothing can have changed all rays count alike, since behind leaves several are not that even. Else a
// past that is over gives way by what this frame's are worth.
float own_worth(uint word) {
    if (word == 0u) return 1.0;
    return MAY_CHANGE ? even_worth(word) : float(further_count(word) + 1u);
}
