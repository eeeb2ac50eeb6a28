// SPDX-License-Identifier: MIT
// Published form: the mean radiance of 8x8 pixels, bilinear. Not listed tiles are black: published, too.
//
// Includer declares: image average_radiance; has common/bilinear.glsl.
#define AVERAGE(q) imageLoad(average_radiance, q).rgb
BILINEAR(vec3, average_between, AVERAGE)
vec3 average_at(ivec2 p) { return average_between((vec2(p) + 0.5) / 8.0, (ivec2(frame.size) + 7) / 8); }
