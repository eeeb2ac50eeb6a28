// SPDX-License-Identifier: MIT
// Cascades and positions in them. Includer has a block `cascades`.

// Whether a cascade's numbers are numbers: written so that a NaN fails the test.
bool is_usable(Cascade c) {
    const vec4 sum = abs(c.map[0]) + abs(c.map[1]) + abs(c.map[2]);
    return sum.x + sum.y + sum.z + sum.w < 1e20 && c.texel_m > 0.0 && c.texel_m < 1e9 && c.depth_m > 0.0 &&
           c.depth_m < 1e12;
}

// Camera-relative metres -> u, v, depth.
vec3 in_cascade(Cascade c, vec3 relative) { return vec4(relative, 1.0) * c.map; }
