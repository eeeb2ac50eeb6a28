// SPDX-License-Identifier: MIT
// Verdicts and ray hits to an image, for pipelines without a denoiser: 0 where a receiver is occluded, else 1 (sky included); between
// where a part of the sun is hidden, or several rays of a pixel disagree.
#include "node.glsl"
#include "common/pixels.glsl"
#include "common/tiles.glsl"

void for_pixel(ivec2 p) {
    const uint i = tile_index(p / TILE);
    float lit = (hits[i] & receiver_words[i] & pixel_bit(p)) == 0u ? 1.0 : 0.0;
    if (HAS_FRACTION) {
        const float between = imageLoad(fraction, p).x;
        if (between != 0.0) lit = between;
    }
    if (HAS_COVERAGE) {
        const float share = imageLoad(coverage, p).x * (255.0 / 256.0);
        if (share != 0.0) lit = share;
    }
    imageStore(visibility, p, vec4(lit));
}

void main() { for_each_pixel(); }
