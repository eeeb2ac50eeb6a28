// SPDX-License-Identifier: MIT
// Verdicts and ray hits to an image, for pipelines without a denoiser: 0 where a receiver is occluded, else 1 (sky included); between
// where a part of the sun is hidden, or several rays of a pixel disagree.
#include "node.glsl"
#include "common/pixels.glsl"
#include "common/tiles.glsl"
#include "common/reuse_words.glsl"

// What an earlier frame has kept of a pixel.
float kept_share(ivec2 p) {
    const uint mask = kept_mask(p / TILE), pixel = uint((p.y & 3) * 8 + (p.x & 7));
    const uint share = kept_masks[mask * SHARE_WORDS + pixel / 4u] >> 8u * (pixel & 3u) & 0xffu;
    if (share != 0u) return float(share) / 256.0;
    return (kept_hits[mask] >> pixel & 1u) == 0u ? 1.0 : 0.0;
}

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
    if (HAS_REUSE_WORDS) {  // of a reused tile classify alone has decided pixels
        const bool kept = reuse_words[i] == REUSED && (receiver_words[i] & ~hits[i] & pixel_bit(p)) != 0u;
        if (kept) lit = kept_share(p);
    }
    imageStore(visibility, p, vec4(lit));
}

void main() { for_each_pixel(); }
