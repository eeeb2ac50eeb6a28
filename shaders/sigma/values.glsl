// SPDX-License-Identifier: MIT
// What one ray says to SIGMA beside the radius of a penumbra.

const float LIT = 65504.0;  // a penumbra of this means lit, of 0 that the pixel is turned away or touches its blocker

bool is_lit(float penumbra) { return penumbra >= LIT; }

// So little comes through that nothing does.
bool is_opaque(vec3 transmittance) { return dot(transmittance, vec3(0.2126, 0.7152, 0.0722)) < 0.003; }
