// SPDX-License-Identifier: MIT
// The colour history between its texels.
//
// Includer has camera.glsl and declares the sampled image history.

vec3 history_tap(vec2 texel) { return textureLod(history, history_coordinate(texel, textureSize(history, 0)), 0.0).xyz; }

// Catmull-Rom over 4x4 texels from nine bilinear taps: the two inner weights of an axis share one tap between them.
vec3 history_at(vec2 texel) {
    const vec2 base = floor(texel - 0.5) + 0.5;
    const vec2 f = texel - base;
    const vec2 w0 = f * (-0.5 + f * (1.0 - 0.5 * f));
    const vec2 w1 = 1.0 + f * f * (-2.5 + 1.5 * f);
    const vec2 w2 = f * (0.5 + f * (2.0 - 1.5 * f));
    const vec2 w3 = f * f * (-0.5 + 0.5 * f);
    const vec2 at[3] = vec2[](base - 1.0, base + w2 / (w1 + w2), base + 2.0);
    const vec2 w[3] = vec2[](w0, w1 + w2, w3);
    vec3 sum = vec3(0.0);
    for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 3; ++x) sum += w[x].x * w[y].y * history_tap(vec2(at[x].x, at[y].y));
    return sum;
}
