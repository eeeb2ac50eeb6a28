// SPDX-License-Identifier: MIT
// Cascades and positions in them. Includer has a block `cascades`.

// Whether a cascade's numbers are numbers: written so that a NaN fails the test.
bool is_usable(Cascade c) {
    const vec4 sum = abs(c.map[0]) + abs(c.map[1]) + abs(c.map[2]);
    return sum.x + sum.y + sum.z + sum.w < 1e20 && c.texel_m > 0.0 && c.texel_m < 1e9 && c.depth_m > 0.0 &&
           c.depth_m < 1e12;
}

// That a host has filled in and that an image of them has a layer for.
uint cascade_count(int layers) { return min(cascades.count, uint(min(layers, cascades.c.length()))); }

// Camera-relative metres -> u, v, depth.
vec3 in_cascade(Cascade c, vec3 relative) { return vec4(relative, 1.0) * c.map; }

// The slope of a surface in a cascade, from its normal: metres along the light per metre across. Level where it is too
// steep for the difference to say anything.
const float STEEPEST = 64.0;
vec2 receiver_slope(Cascade c, vec3 n) {
    const vec3 across_u = normalize(vec3(c.map[0].xyz)), across_v = normalize(vec3(c.map[1].xyz));
    const vec3 along = normalize(vec3(c.map[2].xyz));
    const vec2 slope = -vec2(dot(n, across_u), dot(n, across_v)) / dot(n, along);
    return abs(slope.x) + abs(slope.y) < STEEPEST ? slope : vec2(0.0);
}
