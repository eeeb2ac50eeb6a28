// SPDX-License-Identifier: MIT
// SIGMA, blur and second blur: 5x5 pixels for the penumbra's radius and for what is narrow, then eight taps of a disc as wide as
// the penumbra, stretched along the surface. The first reads rays, the second what the first made of them.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/disc_taps.glsl"
#include "common/guide_normal.glsl"
#include "common/pixels.glsl"
#include "common/view_rays.glsl"
#include "sigma/sigma.glsl"
#include "sigma/tile_value.glsl"

// Two means over the same taps: of the shadow, and of the penumbra's radius, which prefers narrow ones and knows no lit pixels.
struct Means {
    vec4 shadow;
    float weight, penumbra, penumbra_weight;
};

// Centre of the kernel.
struct Centre {
    OffPlane plane;
    float pixel_m, per_metre_off, penumbra;
};

const bool SECOND_PASS = HAS_SHADOW || HAS_COLOURED_SHADOW;

vec4 shadow_at(ivec2 q, float penumbra_q) {
    if (HAS_COLOURED_SHADOW) return decoded(imageLoad(coloured_shadow, q));
    if (HAS_SHADOW) return decoded(vec4(imageLoad(shadow, q).x));
    if (HAS_TRANSLUCENCY) return texelFetch(translucency, q, 0);
    return vec4(is_lit(penumbra_q) ? 1.0 : 0.0);
}

// The tap `offset` pixels away. `weight`: by its place; `reach_m`: a penumbra narrower than this counts for less.
void add(inout Means m, Centre c, ivec2 p, ivec2 offset, float weight, float reach_m) {
    const ivec2 q = p + offset;
    const float z = inside_frame(q) ? imageLoad(view_depth, q).x : 0.0;
    const float there = imageLoad(penumbra, q).x;
    const float off = abs(metres_off(c.plane, vec2(offset), z)) * c.per_metre_off;
    float w = weight * (1.0 - smoothstep(0.0, 1.0, off)) * (there < reach_m ? there / reach_m : 1.0);
    if (!(z > 0.0) || !of_a_kind(there, c.penumbra)) w = 0.0;
    if (!(w > 0.0)) return;
    m.shadow += w * shadow_at(q, there);
    m.weight += w;
    if (is_lit(there)) return;
    const float narrow = w * c.pixel_m / (c.pixel_m + there);
    m.penumbra += narrow * there;
    m.penumbra_weight += narrow;
}

// Off the image as far as it would have been on it.
float mirrored(float u) { return min(1.0 - abs(1.0 - 2.0 * fract(0.5 * u)), 0.99999); }

// The disc as seen: narrow where the surface is seen at a grazing angle.
vec2 stretched(vec3 n, ivec2 p) {
    const float facing = abs(dot(n, to_viewer(p)));
    const vec2 along = mix(1.0 - abs((n * frame.world_from_view).xy), vec2(1.0), facing);
    return along / max(along.x, along.y);
}

void write(ivec2 p, float radius_m, vec4 shadowed) {
    store_penumbra_out(p, vec4(radius_m));
    store_shadow_out(p, sqrt(clamp(shadowed, 0.0, 1.0)));
}

void for_pixel(ivec2 p) {
    const float z = imageLoad(view_depth, p).x;
    if (!(z > 0.0)) {
        write(p, LIT, vec4(1.0));
        return;
    }
    const float own = imageLoad(penumbra, p).x, scale = tile_value(p);
    const vec4 own_shadow = shadow_at(p, own);
    if (scale == 0.0 || own == 0.0) {
        write(p, own, own_shadow);
        return;
    }
    const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
    const Centre c = Centre(off_plane(view_rays(p, mat3(1.0)), n, position(p, z)), pixel_span_m(z),
                            1.0 / (PLANE_SENSITIVITY * frustum_m(z)), own);

    Means dense = Means(vec4(0.0), 0.0, 0.0, 0.0);
    for (int y = -2; y <= 2; ++y)
        for (int x = -2; x <= 2; ++x) add(dense, c, p, ivec2(x, y), disc_gaussian(0.5 * length(vec2(x, y))), 0.0);
    const float radius_m = dense.penumbra / max(dense.penumbra_weight, 1e-6);
    const float wide = smoothstep(0.0, 2.0, radius_m / c.pixel_m);  // nothing narrower than 2 pixels is blurred

    const float weight = mix(4.0, 1.0, wide), known = dense.penumbra_weight > 0.0 ? weight : 0.0;
    Means m = Means(weight * mix(own_shadow, dense.shadow / dense.weight, wide), weight, known * radius_m, known);
    const vec2 reach = kernel_radius(radius_m / c.pixel_m, scale) * stretched(n, p), size = vec2(frame.size);
    const mat2 turn = disc_turn(SECOND_PASS ? 0.25 : 0.0);
    for (int i = 0; i < 8; ++i) {
        const vec2 uv = (vec2(p) + 0.5 + reach * (turn * DISC_TAPS[i])) / size, inside = vec2(mirrored(uv.x), mirrored(uv.y));
        const float by_place = uv == clamp(uv, 0.0, 1.0) ? disc_weight(i) : 1.0;
        add(m, c, p, ivec2(inside * size) - p, by_place, radius_m);
    }
    write(p, m.penumbra_weight > 0.0 ? m.penumbra / m.penumbra_weight : own, m.shadow / m.weight);
}

void main() { for_each_pixel(); }
