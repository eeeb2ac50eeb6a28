// SPDX-License-Identifier: MIT
#include "node.glsl"  // generated from invert.json: visibility, shadow, params.gain, frame

void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(shadow)))) return;
    imageStore(shadow, p, vec4(params.gain * (1.0 - texelFetch(visibility, p, 0).x)));
}
