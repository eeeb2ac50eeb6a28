// SPDX-License-Identifier: MIT
// What is known of a texel of a shadow map: everything in it lies at `least` or farther from the sun, and on or below
// the plane level + dot(slope, p - centre). Metres, from the cascade's depth 0. A texel without surfaces has
// least = NO_SURFACE.

struct CascadeNode {
    float least;
    float level;
    vec2 slope;
};

const float NO_SURFACE = 1e30;
const float NOTHING_KNOWN = -1e30;  // below every depth: such a texel is never ruled out

CascadeNode cascade_node(vec4 texel) {
    // A texel whose numbers are no numbers is one of which nothing is known; written so that a NaN fails the test.
    if (!(abs(texel.x) <= NO_SURFACE && abs(texel.y) <= NO_SURFACE && abs(texel.z) + abs(texel.w) < 3e30))
        return CascadeNode(NOTHING_KNOWN, NOTHING_KNOWN, vec2(0.0));
    return CascadeNode(texel.x, texel.y, texel.zw);
}
