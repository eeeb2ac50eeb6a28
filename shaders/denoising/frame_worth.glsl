// SPDX-License-Identifier: MIT
// How many frames of one ray per pixel a frame is worth to a pixel, as a texel of r8: 0, or its logarithm in eighths of an octave.
float pack_worth(float frames) { return frames > 0.0 ? clamp(8.0 * log2(frames) + 65.0, 1.0, 255.0) / 255.0 : 0.0; }
float unpack_worth(float texel) { return texel > 0.0 ? exp2((texel * 255.0 - 65.0) / 8.0) : 0.0; }
