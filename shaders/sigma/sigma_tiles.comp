// SPDX-License-Identifier: MIT
// SIGMA, first pass: which 16x16 tiles have a penumbra in them, how wide it is, and which are sky alone. A workgroup owns a tile,
// an invocation 2x4 of its pixels.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/pixels.glsl"
#include "sigma/sigma.glsl"

const uint PIXELS = 256u;

// Three counts of at most 256 in one word: pixels that no kernel would change if all were so (lit or without a shadow to soften;
// dark), and sky.
shared uint s_counts;
shared uint s_radius;  // bits of a float that is not negative, so that they are ordered as it is

const uint FIELD = 10u, FIELD_MASK = (1u << FIELD) - 1u;

void main() {
    if (gl_LocalInvocationIndex == 0u) s_counts = s_radius = 0u;
    barrier();

    const ivec2 first = ivec2(gl_GlobalInvocationID.xy) * ivec2(PER_THREAD_X, PER_THREAD_Y);
    uint counts = 0u;
    float radius = 0.0;
    for (int y = 0; y < int(PER_THREAD_Y); ++y)
        for (int x = 0; x < int(PER_THREAD_X); ++x) {
            const ivec2 p = first + ivec2(x, y);
            const float z = inside_frame(p) ? imageLoad(view_depth, p).x : 0.0;
            const float shadow = z > 0.0 ? imageLoad(penumbra, p).x : LIT;
            const bool sky = !(z > 0.0), hard = shadow == 0.0, lit = is_lit(shadow);
            const bool dark = !lit && !(HAS_TRANSLUCENCY && z > 0.0 && !is_opaque(texelFetch(translucency, p, 0).yzw));
            counts += uint(lit || sky || hard) | uint(dark || sky) << FIELD | uint(sky) << 2u * FIELD;
            if (!sky && !lit) radius = max(radius, kernel_radius(shadow / pixel_span_m(z), 1.0));
        }
    atomicAdd(s_counts, counts);
    atomicMax(s_radius, floatBitsToUint(radius));
    barrier();

    if (gl_LocalInvocationIndex != 0u) return;
    const uvec3 total = uvec3(s_counts, s_counts >> FIELD, s_counts >> 2u * FIELD) & FIELD_MASK;
    const float mixed = total.x == PIXELS || total.y == PIXELS ? 0.0 : 1.0, sky = total.z == PIXELS ? 1.0 : 0.0;
    store_tiles(ivec2(gl_WorkGroupID.xy), vec4(mixed, min(uintBitsToFloat(s_radius) / 16.0, 1.0), sky, 0.0));
}
