// SPDX-License-Identifier: MIT
// What a pixel's own rays say where it has several: `refine` leaves them as a word, and the first one is the pixel's bit.
//
// Includer declares the buffer ray_bits, where HAS_RAY_BITS.

// Their points lie evenly over the sun, so that they are worth more than as many random ones (docs/budget.md).
const float EVEN_POINTS = 1.6;

uint further_at(ivec2 p) {
    uint word = 0u;
    if (HAS_RAY_BITS) word = ray_bits[clamp(p.y * int(frame.size.x) + p.x, 0, int(frame.size.x * frame.size.y) - 1)];
    return word;
}

uint further_count(uint word) { return word == 0u ? 0u : uint(findMSB(word)); }

// Of the pixel's rays, the first included.
float lit_share(uint word, bool first_lit) {
    const uint further = further_count(word);
    const int lit = int(further) - bitCount(word ^ 1u << further) + (first_lit ? 1 : 0);
    return float(lit) / float(further + 1u);
}

// Do some of them say something else than `lit`?
bool further_disagree(uint word, bool lit) {
    const int occluded = bitCount(word) - 1;
    return word != 0u && occluded != (lit ? 0 : int(further_count(word)));
}

float even_worth(uint word) { return pow(float(further_count(word) + 1u), EVEN_POINTS); }
