// SPDX-License-Identifier: MIT
// Adds what one light would spend rays on to what those before it would. A light that casts none, as there is none for a point's
// shadow to share, hands on what it got.
#include "node.glsl"
#include "common/rounded.glsl"
#include "budget/ray_worth.glsl"
#include "budget/light_share.glsl"

uint own(uint i) {
    if (i >= POOLED_GAINS) return HAS_FURTHER_RAYS ? further_rays[i - POOLED_GAINS] : 0u;
    if (i == POOLED_FIRST_RAYS) return HAS_FIRST_RAYS ? first_rays[1] : 0u;
    return HAS_PIXELS ? pixels[i] : 0u;
}

void main() {
    for (uint i = gl_LocalInvocationIndex; i < POOLED_GAINS + GAIN_BINS; i += gl_WorkGroupSize.x)
        pooled[i] = own(i) + (HAS_BEFORE ? before[i] : 0u);
}
