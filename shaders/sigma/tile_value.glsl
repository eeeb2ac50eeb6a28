// SPDX-License-Identifier: MIT
// How much of a penumbra the tiles around a pixel hold, 0 to 1, as a cubic B-spline through the smoothed tiles. The published lookup
// takes the image's size for the tiles' and drifts by up to half a tile where that is no multiple; this one does not.
//
// Includer declares: sampled image smooth_tiles; has sigma/sigma.glsl.

float tile_value(ivec2 p) {
    const vec2 at = (vec2(p) + 0.5) / float(TILE_PX) - 0.5, base = floor(at), f = at - base, g = 1.0 - f;
    const vec2 w0 = g * g * g / 6.0, w1 = (4.0 - 6.0 * f * f + 3.0 * f * f * f) / 6.0;
    const vec2 w2 = (4.0 - 6.0 * g * g + 3.0 * g * g * g) / 6.0, w3 = f * f * f / 6.0;
    const ivec2 last = tile_grid() - 1;
    const ivec4 x = clamp(int(base.x) + ivec4(-1, 0, 1, 2), 0, last.x), y = clamp(int(base.y) + ivec4(-1, 0, 1, 2), 0, last.y);
    const vec4 across = vec4(w0.x, w1.x, w2.x, w3.x), down = vec4(w0.y, w1.y, w2.y, w3.y);
    float sum = 0.0;
    [[unroll]] for (int j = 0; j < 4; ++j)
        sum += down[j] * dot(across, vec4(texelFetch(smooth_tiles, ivec2(x[0], y[j]), 0).y, texelFetch(smooth_tiles, ivec2(x[1], y[j]), 0).y,
                                          texelFetch(smooth_tiles, ivec2(x[2], y[j]), 0).y, texelFetch(smooth_tiles, ivec2(x[3], y[j]), 0).y));
    return sum;
}
