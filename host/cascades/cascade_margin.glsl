// SPDX-License-Identifier: MIT
// How far, in texels, rounding may have moved a triangle's sides: a fixed share of a texel, and two ulps of coordinates
// of vertices that lie far outside of the map.
float margin_texels(vec3 a, vec3 b, vec3 c) {
    const vec2 largest = max(max(abs(a.xy), abs(b.xy)), abs(c.xy));
    return 1.0 / 1024.0 + 2.4e-7 * 4.0 * max(largest.x, largest.y);
}

// The whole texels about a triangle that lie in the map; false where there are none, or for NaN.
bool texel_box(vec3 a, vec3 b, vec3 c, out vec2 low, out vec2 high) {
    const float margin = margin_texels(a, b, c);
    low = max(floor(min(min(a.xy, b.xy), c.xy) - margin), vec2(0.0));
    high = min(ceil(max(max(a.xy, b.xy), c.xy) + margin), vec2(cascade.size));
    return all(lessThan(low, high));
}
