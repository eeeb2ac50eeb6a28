// SPDX-License-Identifier: MIT
// How far, in texels, rounding may have moved a triangle's sides: a fixed share of a texel, and two ulps of coordinates
// of vertices that lie far outside of the map.
float margin_texels(vec3 a, vec3 b, vec3 c) {
    const vec2 largest = max(max(abs(a.xy), abs(b.xy)), abs(c.xy));
    return 1.0 / 1024.0 + 2.4e-7 * 4.0 * max(largest.x, largest.y);
}
