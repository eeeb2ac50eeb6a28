// SPDX-License-Identifier: MIT
// The four corners of a square: the texels around a place, the pixels diagonal to one, the ends of a block.

ivec2 corner(int i) { return ivec2(i & 1, i >> 1); }         // of the unit square
ivec2 diagonal(int i) { return 2 * ivec2(i & 1, i >> 1) - 1; }  // from its middle

// What a corner counts at a place in the square.
float bilinear_share(int i, vec2 t) { return ((i & 1) != 0 ? t.x : 1.0 - t.x) * ((i >> 1) != 0 ? t.y : 1.0 - t.y); }
