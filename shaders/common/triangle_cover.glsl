// SPDX-License-Identifier: MIT
// Which samples of the light two triangles of a leaf hide from a receiver.
//
// With corners relative to the receiver a triangle meets the direction D where D = b0 V0 + b1 V1 + b2 V2, all b >= 0; b_i has the sign
// of det(V) times (V_j x V_k) . D. So each edge is a line across the light, wherever the corners lie: nothing is clipped, also where a
// triangle reaches behind the receiver. On which side of the receiver its plane lies, det(V), is another matter: the receiver's own surface is within
// rounding of it, and a wrong sign would hide the whole light. It is decided as trace decides it (bvh_plane_ahead): a
// plane within its corners' rounding of the receiver hides nothing.
//
// Includer has common/bvh.glsl and common/light_mask.glsl.
const float UNIT_ROUNDING = 5.9604644775390625e-8;  // 2^-24

// Where a receiver looks from: the start of its shadow rays, in the scene's frame, and the light's axes, turned about the
// light's middle by another angle for each pixel: z towards it.
struct Receiver {
    vec3 start;
    vec3 x, y, z;
    float dither;
};

// Rounded alike for every triangle at this corner; `precise`: with fused products a x b = -(b x a) would not hold.
vec3 corner_seen(Receiver r, vec3 from_start) {
    precise vec3 v = vec3(dot(from_start, r.x), dot(from_start, r.y), dot(from_start, r.z));
    return v;
}

vec3 edge_seen(vec3 a, vec3 b) {
    precise vec3 e = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    return e;
}

float taxi(vec3 v) { return abs(v.x) + abs(v.y) + abs(v.z); }

// Twice the area times the distance of the triangle's plane from the receiver, and how far rounding can move it. Differences of corners
// keep their own digits, where the product of three corners keeps those of their distance.
vec2 plane_height(vec3 to_a, vec3 ab, vec3 ac) {
    const vec3 n = cross(ab, ac);
    return vec2(dot(n, to_a), 16.0 * UNIT_ROUNDING * taxi(ab) * taxi(ac) * taxi(to_a));
}

// The same with twice the digits, 0 where the plane is within its corners' rounding.
float plane_height_exactly(vec3 start, vec3 a, vec3 b, vec3 c) {
    const Twofold to_a = twofold_difference(a, start);
    const Twofold n = cross_product(twofold_difference(b, a), twofold_difference(c, a));
    const float height = dot_product(n, to_a);
    precise vec3 reach = max(max(abs(to_a.hi), abs(b - start)), abs(c - start));
    const float extent = max(max(reach.x, reach.y), reach.z);
    precise float displaced = bvh_vertex_roundings * extent * taxi(n.hi);
    return abs(height) > displaced ? height : 0.0;
}

bool in_doubt(vec2 height) { return abs(height.x) <= height.y; }

// The samples that the leaf hides; none where it is not `wanted`. Called by every lane of the subgroup that walks.
void hide_by_leaf(Receiver r, LightDisc disc, uint leaf, bool wanted, inout LightMask hidden) {
    const BvhLeaf corners = bvh_leaf(leaf);
    precise vec3 to_a = corners.a - r.start, to_b = corners.b - r.start, to_c = corners.c - r.start, to_d = corners.d - r.start;
    const vec3 a = corner_seen(r, to_a), b = corner_seen(r, to_b), c = corner_seen(r, to_c), d = corner_seen(r, to_d);
    const vec3 eab = edge_seen(a, b), ebc = edge_seen(b, c), eca = edge_seen(c, a), ebd = edge_seen(b, d), edc = edge_seen(d, c);
    const LightLine ab = light_line(disc, r.dither, eab), bc = light_line(disc, r.dither, ebc), ca = light_line(disc, r.dither, eca),
                    bd = light_line(disc, r.dither, ebd), dc = light_line(disc, r.dither, edc);
    const bvec2 none_above = bvec2(none_positive(ab) || none_positive(bc) || none_positive(ca),
                                   none_positive(bd) || none_positive(dc) || none_negative(bc));
    const bvec2 none_below = bvec2(none_negative(ab) || none_negative(bc) || none_negative(ca),
                                   none_negative(bd) || none_negative(dc) || none_positive(bc));
    const float ebc_size = taxi(b) * taxi(c);
    vec2 first = vec2(dot(a, ebc), 32.0 * UNIT_ROUNDING * taxi(a) * ebc_size),
         second = vec2(dot(d, -ebc), 32.0 * UNIT_ROUNDING * taxi(d) * ebc_size);
    const bvec2 matters = bvec2(wanted && !(none_above.x && none_below.x), wanted && !(none_above.y && none_below.y));
    // Loops that run once: a device without branches would do this for every leaf.
    for (bool once = matters.x && in_doubt(first) || matters.y && in_doubt(second); once; once = false) {
        if (in_doubt(first)) first = plane_height(to_a, corners.b - corners.a, corners.c - corners.a);
        if (in_doubt(second)) second = plane_height(to_c, corners.b - corners.c, corners.d - corners.c);
    }
    const bvec2 unsure = bvec2(matters.x && in_doubt(first), matters.y && in_doubt(second));
    for (bool once = any(unsure); once; once = false) {
        if (unsure.x) first.x = plane_height_exactly(r.start, corners.a, corners.b, corners.c);
        if (unsure.y) second.x = plane_height_exactly(r.start, corners.c, corners.b, corners.d);
    }
    const bvec2 below = bvec2(first.x < 0.0, second.x < 0.0);
    const bvec2 hides = bvec2(matters.x && first.x != 0.0 && !(below.x ? none_below.x : none_above.x),
                              matters.y && second.x != 0.0 && !(below.y ? none_below.y : none_above.y));
    for (bool once = any(hides); once; once = false) {
        const LightMask above_bc = positive_side(bc);
        const LightMask by_first = mask_and(mask_flipped(above_bc, below.x), mask_and(mask_flipped(positive_side(ab), below.x),
                                                                                      mask_flipped(positive_side(ca), below.x)));
        const LightMask by_second = mask_and(mask_flipped(above_bc, !below.y), mask_and(mask_flipped(positive_side(bd), below.y),
                                                                                        mask_flipped(positive_side(dc), below.y)));
        hidden = mask_or(hidden, mask_or(mask_if(hides.x, by_first), mask_if(hides.y, by_second)));
    }
}
