// SPDX-License-Identifier: MIT
// An image between its texels, as far as a frame uses it: what lies beside those `size` texels is never read. A linear sampler reads
// it with a weight of 0, which what is no number survives, and rounds by where in the whole of the image a place lies, to 8 bits of
// weight on most devices: a plan for larger frames would give other images.

// Defines TYPE NAME(vec2 texel, ivec2 size): between the four texels that TEXEL(q) reads, clamped to the edge. `texel` is finite, in
// texels; a texel's centre is at + 0.5.
#define BILINEAR(TYPE, NAME, TEXEL)                                                                            \
    TYPE NAME(vec2 texel, ivec2 size) {                                                                        \
        const vec2 at = clamp(texel - 0.5, vec2(0.0), vec2(size - 1));                                         \
        const ivec2 low = ivec2(at), high = min(low + 1, size - 1);                                            \
        const vec2 share = at - vec2(low);                                                                     \
        return mix(mix(TEXEL(low), TEXEL(ivec2(high.x, low.y)), share.x),                                      \
                   mix(TEXEL(ivec2(low.x, high.y)), TEXEL(high), share.x), share.y);                           \
    }
