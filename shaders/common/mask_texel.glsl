// SPDX-License-Identifier: MIT
// Which texel of an alpha mask a texture coordinate falls on: the nearest one, of the full-size image, repeated. One
// definition for the G-buffer, the tree and ray queries, so that what is seen is what casts.
//
// Nearest and without mip levels, because whether a texel is there is then decided once, by the host, and is the same for
// every ray on every device: two of them can differ only where rounding moves a hit over a texel's border. A bilinear edge
// would be smoother, but its place would hang on the filter's precision (8 bits on most GPUs), and a ray has no footprint
// to choose a mip level by.
ivec2 mask_texel(vec2 uv, uvec2 size) {
    vec2 at = uv - floor(uv);
    return min(ivec2(at * vec2(size)), ivec2(size) - 1);
}
