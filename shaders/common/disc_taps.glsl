// SPDX-License-Identifier: MIT
// Eight places of a disc that NVIDIA's denoisers blur with, four on its rim and four half way, turned anew every frame.

const float DISC_DIAGONAL = 0.35355339;
const vec2 DISC_TAPS[8] = vec2[](vec2(1, 0), vec2(-1, 0), vec2(0, 1), vec2(0, -1), vec2(DISC_DIAGONAL, DISC_DIAGONAL),
                                 vec2(-DISC_DIAGONAL, DISC_DIAGONAL), vec2(DISC_DIAGONAL, -DISC_DIAGONAL),
                                 vec2(-DISC_DIAGONAL, -DISC_DIAGONAL));

// Of how far from the middle, the rim being 1.
float disc_gaussian(float r) { return exp(-0.66 * r * r); }
float disc_weight(int tap) { return disc_gaussian(tap < 4 ? 1.0 : 0.5); }

const uint TURN_PER_FRAME = 2479700525u;  // 1 / sqrt(3), of 2^32: a product in floats would have ever fewer angles, and none but one after some days

// Taps repeat after a quarter turn; `quarters` turns a second pass between those of a first.
mat2 disc_turn(float quarters) {
    const float angle = 1.5707963 * (float(frame.frame_index * TURN_PER_FRAME >> 8) / 16777216.0 + quarters), c = cos(angle), s = sin(angle);
    return mat2(c, s, -s, c);
}
