// SPDX-License-Identifier: MIT
// How long RELAX's pasts are, and their lengths in 8 bits: whole frames of 255, which is exact.

const float MOST_FRAMES = 63.0;      // of the long past
const float MOST_FAST_FRAMES = 6.0;  // of the short one
const float FIX_FRAMES = 4.0;        // pasts up to this long are made up for by what is around

float decode_frames(float texel) { return floor(255.0 * texel + 0.5); }
float encode_frames(float frames) { return floor(min(frames, 255.0) + 0.5) / 255.0; }
