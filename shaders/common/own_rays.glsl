// SPDX-License-Identifier: MIT
// What a pixel's own rays have said, in 4 bytes beside the sheared denoiser's state. Their mean is noisier than what the
// neighbours' rays say together, but it is of this pixel alone: where the two stay apart for longer than noise explains,
// the neighbours are wrong. And how often the bit flips tells a pixel in a penumbra, which goes on flipping, from one that a
// shadow's edge has passed, which flips once.
//
// Includer has rounded.glsl.

const float OWN_CAP = 63.0;          // frames that the mean is over
const float FLIP_FRAMES = 16.0;      // that the share of flips is over
const float UNDOUBTED = 8.0;         // frames of a past from which on the own rays are asked; all that they say, at twice as many

struct OwnRays {
    float visibility;  // mean of the bits
    float count;       // frames, whole; 0: none
    float flips;       // share of frames whose bit differs from the one before
    bool lit;          // the last bit
};

const OwnRays NO_RAYS = OwnRays(0.0, 0.0, 0.0, false);

uint pack_own(OwnRays o) {
    const uint v = rounded(clamp(o.visibility, 0.0, 1.0) * 65535.0), n = rounded(clamp(o.count, 0.0, OWN_CAP));
    return v | n << 16 | rounded(clamp(o.flips, 0.0, 1.0) * 511.0) << 22 | (o.lit ? 1u << 31 : 0u);
}

OwnRays unpack_own(uint word) {
    return OwnRays(float(word & 0xffffu) / 65535.0, float(word >> 16 & 63u), float(word >> 22 & 511u) / 511.0, word >> 31 != 0u);
}

// Have the rays said something else than `lit`, more often than once in a hundred frames?
bool disagrees(uint word, bool lit) {
    const uint v = word & 0xffffu;
    return (word >> 16 & 63u) != 0u && (lit ? v < 64880u : v > 655u);
}

OwnRays with_ray(OwnRays o, bool lit) {
    const float n = min(o.count + 1.0, OWN_CAP);
    const float flips = o.flips + ((lit != o.lit ? 1.0 : 0.0) - o.flips) / FLIP_FRAMES;
    return OwnRays(o.visibility + ((lit ? 1.0 : 0.0) - o.visibility) / n, n, flips, lit);
}

// Of the mean. Samples of low discrepancy: it falls as their number to the power of 1.5. The prior is so that a handful of
// equal bits is not certainty.
float mean_variance(OwnRays o) {
    const float n = max(o.count, 1.0), v = (n * o.visibility + 0.5) / (n + 1.0);
    return v * (1.0 - v) * inversesqrt(n * n * n);
}

// How far the own rays are asked, 0 to 1: not before the past has been believed for a while.
float trust(float frames_believed) { return clamp(frames_believed / UNDOUBTED - 1.0, 0.0, 1.0); }

// v (1 - v), as far as it shows in flips beyond those of something thin that has passed, which are two. Random bits flip
// 2 v (1 - v) of the time. Half of what that says, because blades that turn flip pixels, too, and are to be followed
// (docs/sheared.md).
float flipping(OwnRays o) {
    return 0.25 * max(o.flips - 2.0 / FLIP_FRAMES, 0.0);
}
