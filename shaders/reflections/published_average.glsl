// SPDX-License-Identifier: MIT
// Published form: the mean radiance of 8x8 pixels, bilinear. Not listed tiles are black: published, too.
//
// Includer declares: sampler average_radiance.
vec3 average_at(ivec2 p) {
    const vec2 size = vec2(textureSize(average_radiance, 0)) * 8.0;  // the frame's, rounded up to tiles
    return textureLod(average_radiance, (vec2(p) + 0.5) / size, 0.0).rgb;
}
