// SPDX-License-Identifier: MIT
// An image between its texels, as far as a frame uses it: what lies beside those `size` texels is never read. A linear sampler reads
// it with a weight of 0, which what is no number survives, and rounds by where in the whole of the image a place lies, to 8 bits of
// weight on most devices: a plan for larger frames would give other images.

// `texel`: finite, in texels; a texel's centre is at + 0.5. Clamped to the edge.
vec4 bilinear(sampler2D image, vec2 texel, ivec2 size) {
    const vec2 at = clamp(texel - 0.5, vec2(0.0), vec2(size - 1));
    const ivec2 low = ivec2(at), high = min(low + 1, size - 1);
    const vec2 share = at - vec2(low);
    return mix(mix(texelFetch(image, low, 0), texelFetch(image, ivec2(high.x, low.y), 0), share.x),
               mix(texelFetch(image, ivec2(low.x, high.y), 0), texelFetch(image, high, 0), share.x), share.y);
}
