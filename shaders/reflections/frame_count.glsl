// SPDX-License-Identifier: MIT
// How many frames a past stands for, as images keep it: in quarters, 255 of them at most, as a fraction of 1. 0: there is none.

const float MOST_QUARTERS = 255.0;

float encode_frames(float n) { return floor(min(4.0 * n, MOST_QUARTERS) + 0.5) / MOST_QUARTERS; }
float decode_frames(float texel) { return floor(texel * MOST_QUARTERS + 0.5) * 0.25; }
