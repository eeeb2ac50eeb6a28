// SPDX-License-Identifier: MIT
// How far a frame and the past may differ where nothing has changed, and what of it a cell hands on.
//
// Includer has shadow_past.glsl, bit_rows.glsl and this_frame.glsl, and declares the image view_depth.

const float SHARE_PER_RADIUS = 1.0;  // per pixel: of the pixels beside a narrow penumbra, how many lie in it
const float LEAST_SHARE = 0.02;
const float KNOWN = 12.0;  // frames after which a past in a penumbra is taken at its word
// Flips that a still edge shows, of what its length and width say (see flips_of), and how many a window may always show: one
// surprise is no proof. Half of it follows a moving shadow best and is enough for one that stands still (docs/denoiser.md).
const float FLIP_SHARE = 0.5, FEWEST_FLIPS = 0.8;
const float PAIRS_PER_PX = 1.2732;  // of an edge, mean over its angles: 4 / pi
const float CELLS_POOLED = 16.0;    // weight of drift's window in cells, so that it has all of FEWEST_FLIPS; see there
// Of the noise of the own rays' mean, taken for no bias: with 1.5 instead, 8 frames of a 32 px edge lose a quarter.
const float NOISE_SHARE = 3.0;

// Does the pixel next to this one, which the same ray of light could hit, say something else?
int differs(Receiver r, ivec2 offset) {
    const ivec2 q = r.in_rows + offset;
    const bool same = shows(r.surface, vec2(offset), imageLoad(view_depth, r.p + offset).x);
    return is_tested(q) && is_lit(q) != is_lit(r.in_rows) && same ? 1 : 0;
}

// In a narrow penumbra the bits are all there is, and a pixel of a young past says nothing of its own variance: it flips
// or it does not. How many flip depends on the edge: over a length L (`pairs` of unlike neighbours) and a width of 2r lie 2rL
// pixels whose visibilities are anything between 0 and 1, so the mean of v (1 - v) is a sixth.
float flips_of(int pairs, float radius_px, float by_count) {
    return FLIP_SHARE * float(pairs) / PAIRS_PER_PX * radius_px / 3.0 * (1.0 + by_count) + FEWEST_FLIPS / CELLS_POOLED;
}

// Standard error of a frame, squared, if the past is right: in a faint penumbra now and then all rays agree, and that is no certainty.
float error_by_past(Estimate now, Past past) {
    return min(past.count / KNOWN, 1.0) * past.visibility * (1.0 - past.visibility) * now.gain / now.rays;
}

// Of the difference between a frame and the past where nothing moves. A pixel beside a narrow penumbra is seldom in it,
// unless its past says that it is. `frames`: that this one is worth.
float null_variance(Estimate now, Past past, float radius_px, float frames) {
    const float share = clamp(SHARE_PER_RADIUS * radius_px, LEAST_SHARE, 1.0);
    const float v = (now.rays * now.visibility + past.count * past.visibility) / (now.rays + past.count);
    const float variance = max(max(share * v * (1.0 - v), flipping(past.own)) * now.gain / now.rays, error_by_past(now, past));
    return variance * (1.0 + frames / past.count) + 1e-5;
}

// What drift reads of a cell: sums over its pixels.
struct Sums {
    float d, e, v, d2, e2, c;
};
const Sums NO_SUMS = Sums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0);

// What the past is wrong by, squared: its differences from what the pixels' own rays have said, beyond the noise of these.
// Over a cell, because one pixel's difference proves little. What is shrunk by it (soften) is at no place much worse than
// either of the two: James and Stein 1961, "Estimation with Quadratic Loss", with the noise taken to be larger than it is.
// To it comes a part of the past's own noise: a handful of neighbours' rays per frame averages out more slowly than the
// own ones, which repel each other in time. All of it would cost a twentieth where a penumbra has many rays.
const float PAST_NOISE_SHARE = 0.5;

struct Bias {
    float differences, noise, past_noise, n;
};

void add_pixel(inout Bias b, Past past, Estimate now, float frames) {
    // The more rays this frame has, the less of the state is the past's: by its share of all frames, and where its own may be over by this
    // frame's number alone.
    const float all = trust(past.count), rays = max(frames, 1.0), w = all * (MAY_CHANGE ? 1.0 / rays : past.count / (past.count + rays - 1.0));
    const float d = past.own.visibility - past.visibility;
    b.differences += w * d * d;
    b.noise += w * (past.elsewhere ? mean_variance_across(past.own) : mean_variance(past.own));
    if (now.rays > 1.0) b.past_noise += w * frames * squared_error(now) / max(past.count, 1.0);
    b.n += all;
}

float mean_bias(Bias b) {
    return (max(b.differences - NOISE_SHARE * b.noise, 0.0) + PAST_NOISE_SHARE * b.past_noise) / max(b.n, 1.0);
}
