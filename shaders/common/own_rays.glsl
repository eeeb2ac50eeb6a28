// SPDX-License-Identifier: MIT
// What a pixel's own rays have said, a part of the denoiser's state. Their mean is noisier than what the
// neighbours' rays say together, but it is of this pixel alone: where the two stay apart for longer than noise explains,
// the neighbours are wrong. And how often the bit flips tells a pixel in a penumbra, which goes on flipping, from one that a
// shadow's edge has passed, which flips once.
//
// Includer has rounded.glsl and dithered.glsl, and says by the constant MANY_RAYS whether frames may have several rays per pixel.

const float FLIP_FRAMES = 16.0;      // that the share of flips is over
const float MOST_FLIPS = 0.6;        // share; random bits have half at most
const float UNDOUBTED = 8.0;         // frames of a past from which on the own rays are asked; all that they say, at twice as many

struct OwnRays {
    float visibility;  // mean of the bits
    float count;       // frames of one ray; 0: none
    float flips;       // share of frames whose bit differs from the one before
    bool lit;          // the last bit
};

const OwnRays NO_RAYS = OwnRays(0.0, 0.0, 0.0, false);

// Of the mean as the state keeps it.
float mean_steps() { return MANY_RAYS ? 63.0 : 127.0; }

// In 5 bits, and above them the mean in steps of 1 / `steps`. The count is kept as a share of
// `frames`, those that the state stands for, of which it is most often all.
const float SHARE_STEPS = 3.0, FLIP_STEPS = 3.0;

uint pack_own(OwnRays o, float frames, float steps, uint thresholds) {
    const uint share = dithered_root(clamp(o.count / max(frames, 1e-3), 0.0, 1.0), SHARE_STEPS, threshold(thresholds, 0u));
    const uint flips = dithered(clamp(o.flips / MOST_FLIPS, 0.0, 1.0) * FLIP_STEPS, threshold(thresholds, 1u));
    const uint mean = dithered(clamp(o.visibility, 0.0, 1.0) * steps, threshold(thresholds, 3u));
    return (o.lit ? 1u : 0u) | share << 1 | flips << 3 | mean << 5;
}

OwnRays unpack_own(uint word, float frames, float steps) {
    return OwnRays(float(int(word >> 5)) / steps, squared(word >> 1 & 3u, SHARE_STEPS) * frames,
                   float(int(word >> 3 & 3u)) * (MOST_FLIPS / FLIP_STEPS), (word & 1u) != 0u);
}

// `lit`: the frame's first ray; `share`: of all its rays that reach the sun; `frames` of one ray that they are worth.
OwnRays with_rays(OwnRays o, bool lit, float share, float frames) {
    const float n = o.count + frames;
    const float flips = o.flips + ((lit != o.lit ? 1.0 : 0.0) - o.flips) / FLIP_FRAMES;
    return OwnRays(o.visibility + (share - o.visibility) * frames / n, n, flips, lit);
}

// Of what rounding by thresholds leaves in the kept mean, in steps squared: it does not fall with the number of frames, and where it is left
// out, what is nothing but rounding looks like a past that is wrong.
const float ROUNDING_OF_ONE = 0.25, ROUNDING_OF_MANY = 2.0;
float rounding_variance() { return (MANY_RAYS ? ROUNDING_OF_MANY : ROUNDING_OF_ONE) / (mean_steps() * mean_steps()); }

// Of the mean. Samples of low discrepancy: it falls as their number to the power of 1.5; several of a frame are counted as what they are
// worth. The prior is so that a handful of equal bits is not certainty.
float mean_variance(OwnRays o) {
    const float n = max(o.count, 1.0), v = (n * o.visibility + 0.5) / (n + 1.0);
    return v * (1.0 - v) * inversesqrt(n * n * n) + rounding_variance();
}

// The same of a surface that moves across the pixels and takes its samples from each: these do not repel each other.
float mean_variance_across(OwnRays o) { return mean_variance(o) * sqrt(max(o.count, 1.0)); }

// How far the own rays are asked, 0 to 1: not before the past has been believed for a while.
float trust(float frames_believed) { return clamp(frames_believed / UNDOUBTED - 1.0, 0.0, 1.0); }

// v (1 - v), as far as it shows in flips beyond those of something thin that has passed, which are two. Random bits flip
// 2 v (1 - v) of the time. Half of what that says, because blades that turn flip pixels, too, and are to be followed
// (docs/denoiser.md).
float flipping(OwnRays o) {
    return 0.25 * max(o.flips - 2.0 / FLIP_FRAMES, 0.0);
}
