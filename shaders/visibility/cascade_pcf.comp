// SPDX-License-Identifier: MIT
// Percentage-closer filtering (Reeves, Salesin, Cook 1987): the share of a disc of texels that lets the sun through. Each
// tap is compared with the receiver's own plane at the tap's place, so that a slope needs no bias; what remains is a
// bias of about a texel. No penumbra, no thin casters, shadows that start a texel away: what rays are for.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/cascade_place.glsl"
#include "common/guide_normal.glsl"
#include "common/pixels.glsl"
#include "common/poisson_disc.glsl"

float lit_share(Cascade c, int layer, vec3 at, vec3 n) {
    const ivec2 size = textureSize(cascade_maps, 0).xy;
    const vec2 slope = receiver_slope(c, n);
    // A texel's depth is that of its centre, half a texel off at most on each axis.
    const float bias_m = c.texel_m * (params.bias_texels + 0.5 * (abs(slope.x) + abs(slope.y)));
    uint lit = 0u;
    for (uint i = 0u; i < TAPS; ++i) {
        const vec2 offset = POISSON[i] * params.radius_texels;
        const ivec2 texel = clamp(ivec2(floor(at.xy * vec2(size) + offset)), ivec2(0), size - 1);
        const float caster_m = texelFetch(cascade_maps, ivec3(texel, layer), 0).x * c.depth_m;
        const float receiver_m = at.z * c.depth_m + dot(slope, offset) * c.texel_m;
        lit += uint(!(caster_m < receiver_m - bias_m));
    }
    return float(lit) / float(TAPS);
}

void for_pixel(ivec2 p) {
    const float z = imageLoad(view_depth, p).x;
    float visible = 1.0;
    if (z > 0.0) {
        const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
        const vec3 relative = position(p, z);
        visible = dot(n, sun.to_sun) > 0.0 ? 1.0 : 0.0;
        bool inside = false;
        for (uint k = 0u; k < cascade_count(textureSize(cascade_maps, 0).z) && visible > 0.0; ++k) {
            const Cascade c = cascades.c[k];
            const vec3 at = in_cascade(c, relative);
            const vec2 border = (params.radius_texels + 1.0) / vec2(textureSize(cascade_maps, 0).xy);
            if (!inside && is_usable(c) && all(greaterThan(at.xy, border)) && all(lessThan(at.xy, 1.0 - border))) {
                inside = true;
                visible = lit_share(c, int(k), at, n);
            }
        }
    }
    store_visibility(p, vec4(visible));
}

void main() { for_each_pixel(); }
