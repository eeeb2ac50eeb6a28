// SPDX-License-Identifier: MIT
// Colours as they may be stored: not negative, not NaN, and far enough below fp16's 65504 that sums of a few stay finite.
const float MAX_RADIANCE = 32752.0;

// The comparison is false for NaN, so a NaN becomes 0.
vec3 storable(vec3 c) { return min(mix(vec3(0.0), c, greaterThan(c, vec3(0.0))), MAX_RADIANCE); }
