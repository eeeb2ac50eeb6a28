// SPDX-License-Identifier: MIT
// What a pixel's own rays have said, in 4 bytes beside the sheared denoiser's state. Their mean is noisier than what the
// neighbours' rays say together, but it is of this pixel alone: where the two stay apart for longer than noise explains,
// the neighbours are wrong. And how often the bit flips tells a pixel in a penumbra, which goes on flipping, from one that a
// shadow's edge has passed, which flips once.

const float OWN_CAP = 63.0;          // frames that the mean is over
const float FLIP_FRAMES = 16.0;      // that the share of flips is over

struct OwnRays {
    float visibility;  // mean of the bits
    float count;       // frames, whole; 0: none
    float flips;       // share of frames whose bit differs from the one before
    bool lit;          // the last bit
};

const OwnRays NO_RAYS = OwnRays(0.0, 0.0, 0.0, false);

uint pack_own(OwnRays o) {
    const uint v = uint(clamp(o.visibility, 0.0, 1.0) * 65535.0 + 0.5), n = uint(clamp(o.count, 0.0, OWN_CAP));
    return v | n << 16 | uint(clamp(o.flips, 0.0, 1.0) * 511.0 + 0.5) << 22 | (o.lit ? 1u << 31 : 0u);
}

OwnRays unpack_own(uint word) {
    return OwnRays(float(word & 0xffffu) / 65535.0, float(word >> 16 & 63u), float(word >> 22 & 511u) / 511.0, word >> 31 != 0u);
}

OwnRays with_ray(OwnRays o, bool lit) {
    const float n = min(o.count + 1.0, OWN_CAP);
    const float flips = o.flips + ((lit != o.lit ? 1.0 : 0.0) - o.flips) / FLIP_FRAMES;
    return OwnRays(o.visibility + ((lit ? 1.0 : 0.0) - o.visibility) / n, n, flips, lit);
}

// v (1 - v), as far as it shows in flips beyond those of something thin that has passed, which are two. Random bits flip
// 2 v (1 - v) of the time. Half of what that says, because blades that turn flip pixels, too, and are to be followed
// (docs/sheared.md).
float flipping(OwnRays o) {
    return 0.25 * max(o.flips - 2.0 / FLIP_FRAMES, 0.0);
}
