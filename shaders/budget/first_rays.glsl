// SPDX-License-Identifier: MIT
// How many pixels get a first ray where a budget does not reach for all: of one light the same share of all, of several one in proportion
// to their light's share of all light, and nobody more than one.
//
// Includer has light_share.glsl and declares the buffers pixel_counts and, of several lights, pooled.

const uint SHARES = HAS_POOLED ? SHARE_CLASSES : 1u;  // of one light alone all pixels are of the first class
const uint UNSURE = 0u, OTHERS = 1u, IDLE = 2u;

float pixels_that_are(uint kind, uint share) {
    return float(HAS_POOLED ? pooled[3u * share + kind] : pixel_counts[kind]);
}

// Shares of a class are a factor times its weight, and 1 at most. The greatest factor: only under a light of less than a 32nd of all some
// are left out however many rays there are. (From an eighth on the picture's squared error is greater by 1 to 6 %.)
const float WHOLE = 32.0;
float weight_of(uint share) { return exp2(-float(share)); }

float cast_by(float factor, float counts[SHARE_CLASSES]) {
    float rays = 0.0;
    for (uint c = 0u; c < SHARES; ++c) rays += min(factor * weight_of(c), 1.0) * counts[c];
    return rays;
}

// The factor that casts so many rays.
float factor_for(float rays, float counts[SHARE_CLASSES]) {
    float whole = 0.0;  // of the classes that have 1
    for (uint full = 0u; full < SHARES; ++full) {
        float weighted = 0.0;
        for (uint c = full; c < SHARES; ++c) weighted += counts[c] * weight_of(c);
        const float factor = max(rays - whole, 0.0) / max(weighted, 1.0);
        if (factor * weight_of(full) <= 1.0) return min(factor, WHOLE);
        whole += counts[full];
    }
    return WHOLE;
}
