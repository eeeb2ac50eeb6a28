// SPDX-License-Identifier: MIT
// Which body that shines a pixel's ray of this frame may be aimed at, if any: one of those of which the lobe shows something but would
// find it by chance alone, with a chance in proportion to what it brings, hidden or not, and the less the more of the lobe it fills, down
// to none from a half on. All that follows holds for any choice that knows nothing of where the rays go.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/sun_sample.glsl"
#include "common/hash.glsl"
#include "reflections/lobe.glsl"
#include "reflections/pixel_lobe.glsl"
#include "reflections/emitters.glsl"

// Where on the sphere's cone the lobe responds most, roughly.
vec3 towards(Emitter emitter, vec3 x, vec3 mirrored) {
    const vec3 to = emitter.center - x, beside = max(dot(to, mirrored), 0.0) * mirrored - to;
    const float length2 = dot(beside, beside), radius2 = emitter.radius * emitter.radius;
    return normalize(to + beside * (length2 > radius2 ? sqrt(radius2 / length2) : 1.0));
}

uint chosen(ivec2 p, float z, float roughness) {
    if (is_mirror(roughness)) return 0u;
    const vec3 x = position(p, z);
    const Lobe lobe = pixel_lobe(p, unpack_direction(imageLoad(octahedral_normal, p).x), roughness);
    const vec3 mirrored = LOBE == LOBE_DIFFUSE ? lobe.n : reflect(-lobe.v, lobe.n);
    const uint number = noise_hash(uint(p.x) ^ noise_hash(uint(p.y) ^ noise_hash(frame.frame_index ^ noise_hash(params.seed ^ 0x51ED270Bu))));
    const vec2 u = noise_unit(uvec2(number, noise_hash(number)));
    float sum = 0.0, u_kept = u.x;
    uint kept = 0u;
    for (uint i = 0u; i < uint(textureSize(emitters) / 2); ++i) {
        const Emitter emitter = emitter_of(i + 1u);
        const vec3 to = emitter.center - x;
        const float d2 = dot(to, to);
        if (!(d2 > emitter.radius * emitter.radius)) continue;
        const vec2 what = uintBitsToFloat(texelFetch(emitters, int(2u * i + 1u)).xy);
        const float sees = what.y / d2, shown = density_and_response(lobe, towards(emitter, x, mirrored)).y * sees;
        const float fills = LOBE == LOBE_DIFFUSE ? 0.0 : share_of_lobe(emitter, x, lobe), weight = what.x * shown * max(1.0 - 2.0 * fills, 0.0);
        if (!(weight > 0.0)) continue;
        sum += weight;
        const float share = weight / sum;
        if (u_kept < share) {
            kept = i + 1u;
            u_kept /= share;
        } else {
            u_kept = (u_kept - share) / max(1.0 - share, 1e-6);
        }
    }
    return u.y * (sum + params.background) < sum ? kept : 0u;
}

void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (!inside_frame(p)) return;
    const float z = imageLoad(view_depth, p).x;
    const uint number = z > 0.0 ? chosen(p, z, pixel_roughness(p)) : 0u;
    store_aimed(p, vec4(float(number) / 255.0));
}
