// SPDX-License-Identifier: MIT
// How much of a penumbra the tiles around a pixel hold, 0 to 1, as a cubic B-spline through the smoothed tiles: sixteen texels by
// four bilinear taps. The published lookup takes the image's size for the tiles' and drifts by up to half a tile where that is no
// multiple; this one does not.
//
// Includer declares: sampled image smooth_tiles; has common/bilinear.glsl and sigma/sigma.glsl.

float smooth_tile(vec2 texel) { return bilinear(smooth_tiles, texel, tile_grid()).y; }

float tile_value(ivec2 p) {
    const vec2 at = (vec2(p) + 0.5) / float(TILE_PX) - 0.5;
    const vec2 f = fract(at), g = 1.0 - f, middle = floor(at) + 0.5;
    const vec2 w0 = g * g * g / 6.0, w1 = (4.0 - 6.0 * f * f + 3.0 * f * f * f) / 6.0;
    const vec2 w2 = (4.0 - 6.0 * g * g + 3.0 * g * g * g) / 6.0, w3 = f * f * f / 6.0;
    const vec2 low = w0 + w1, high = w2 + w3;
    const vec2 before = middle - 1.0 + w1 / low, after = middle + 1.0 + w3 / high;
    return low.y * (low.x * smooth_tile(before) + high.x * smooth_tile(vec2(after.x, before.y))) +
           high.y * (low.x * smooth_tile(vec2(before.x, after.y)) + high.x * smooth_tile(after));
}
