// SPDX-License-Identifier: MIT
// Several lights that are near, five texels each: the words of the block Light. One after the other they stand in the place of the one
// that other nodes have.
//
// Includer has what common/light.glsl asks for and declares: uniform usamplerBuffer lights.
Light light;
#include "common/light.glsl"

int light_count() { return textureSize(lights) / 5; }

Light light_at(int i) {
    const uvec4 a = texelFetch(lights, 5 * i), b = texelFetch(lights, 5 * i + 1), c = texelFetch(lights, 5 * i + 2),
                d = texelFetch(lights, 5 * i + 3), e = texelFetch(lights, 5 * i + 4);
    const vec4 u = uintBitsToFloat(b), v = uintBitsToFloat(c), facing = uintBitsToFloat(d);
    return Light(uintBitsToFloat(a.xyz), a.w, u.xyz, u.w, v.xyz, v.w, facing.xyz, facing.w, uintBitsToFloat(e.xyz), e.w);
}
