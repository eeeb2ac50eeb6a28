// SPDX-License-Identifier: MIT
// Published form: the mean radiance of 8x8 pixels, bilinear. Not listed tiles are black: published, too.
//
// Includer declares: sampler average_radiance; has common/bilinear.glsl.
vec3 average_at(ivec2 p) { return bilinear(average_radiance, (vec2(p) + 0.5) / 8.0, (ivec2(frame.size) + 7) / 8).rgb; }
