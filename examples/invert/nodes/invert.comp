// SPDX-License-Identifier: MIT
#include "node.glsl"           // generated from invert.json: visibility, shadow, params.gain, frame
#include "common/pixels.glsl"  // penumbra's own, of which share/penumbra/shaders/ has copies to read: for_each_pixel()

void for_pixel(ivec2 p) { imageStore(shadow, p, vec4(params.gain * (1.0 - texelFetch(visibility, p, 0).x))); }

void main() { for_each_pixel(); }
