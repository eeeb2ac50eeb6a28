// SPDX-License-Identifier: MIT
// Verdicts and ray hits to an image, for pipelines without a denoiser: 0 where a receiver is occluded, else 1 (sky included); between
// where a part of the sun is hidden, or several rays of a pixel disagree.
#include "node.glsl"
#include "common/tiles.glsl"
#include "common/reuse_words.glsl"

// What an earlier frame has kept of a pixel.
float kept_share(uint mask, uint pixel) {
    const uint share = kept_masks[mask * SHARE_WORDS + pixel / 4u] >> 8u * (pixel & 3u) & 0xffu;
    if (share != 0u) return float(share) / 256.0;
    return (kept_hits[mask] >> pixel & 1u) == 0u ? 1.0 : 0.0;
}

// An invocation has pixels of one tile (per_thread: 1 or 4 across, and 1, 2 or 4 down), whose words it reads once.
void main() {
    const ivec2 first = ivec2(gl_GlobalInvocationID.xy * uvec2(PER_THREAD_X, PER_THREAD_Y)), tile = first / TILE;
    if (!all(lessThan(first, ivec2(frame.size)))) return;
    const uint i = tile_index(tile), hit = hits[i], receiver = receiver_words[i];
    // Of a reused tile classify alone has decided pixels.
    const uint kept = HAS_REUSE_WORDS && reuse_words[i] == REUSED ? receiver & ~hit : 0u;
    for (int y = 0; y < int(PER_THREAD_Y); ++y) {
        if (first.y + y >= int(frame.size.y)) break;
        vec4 row = vec4(0.0);
        for (int x = 0; x < int(PER_THREAD_X); ++x) {
            const ivec2 p = first + ivec2(x, y);
            float lit = (hit & receiver & pixel_bit(p)) == 0u ? 1.0 : 0.0;
            if (HAS_FRACTION) {
                const float between = imageLoad(fraction, p).x;
                if (between != 0.0) lit = between;
            }
            if (HAS_COVERAGE) {
                const float share = imageLoad(coverage, p).x * (255.0 / 256.0);
                if (share != 0.0) lit = share;
            }
            if ((kept & pixel_bit(p)) != 0u) lit = kept_share(kept_mask(tile), uint((p.y & 3) * 8 + (p.x & 7)));
            row[x] = lit;
        }
        if (PER_THREAD_X == 4u)
            store4_visibility(first + ivec2(0, y), row);
        else
            store_visibility(first + ivec2(0, y), vec4(row.x));
    }
}
