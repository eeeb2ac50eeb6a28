// SPDX-License-Identifier: MIT
// Which samples of a light the two triangles of a leaf hide from a receiver.
//
// With its corners V relative to the receiver a triangle meets the direction D where D = b0 V0 + b1 V1 + b2 V2, all b >= 0, and
// b_i has the sign of det(V) times (V_j x V_k) . D. So each edge is a line across the light, wherever its corners are: nothing
// is clipped, also where a triangle reaches behind the receiver. On which side of its plane the receiver is, det(V), is another
// question: the receiver's own surface is within rounding of it, and with the wrong sign would hide the whole light. It is decided as
// trace decides it (bvh_plane_ahead): a plane within its corners' rounding of the start hides nothing.
//
// Rounding: with u = 2^-24 and r, s the distances of an edge's corners, V is off by 4 u r, an edge V x W by 12 u r s, and the line across the light
// by 12 u r s / (|V x W| across the axis * radius): for an edge of length l at distance r, 12 u r / (l sin * radius).
//
// Includer has common/bvh.glsl with ASKS_VIEWER and SHARED_VIEWER, common/light.glsl and light_mask.glsl and declares: blocks light, scene; uniform image2D light_samples;
// and calls see_viewer() before the first leaf, with a barrier on a GPU.

const float UNIT_ROUNDING = 5.9604644775390625e-8;  // 2^-24

// A point off the pixel's surface, in the scene's frame, and the light's axes, z towards it: turned about z by another angle
// for each pixel and frame, so that the errors of neighbours have nothing in common. Of what is near the axes need not be
// at right angles (seen_light.glsl).
struct Receiver {
    vec3 start;
    float beyond_edge_m;  // that the start may lie past the end of what it is on (common/ray_offset.glsl)
    vec3 x, y, z;
    float dither;
    // Of what is near alone: whether the axes are left-handed; along z, before what every triangle hides the light, and behind what none does.
    bool mirrored;
    float before, behind;
};

// The corner of all its triangles is rounded once, and alike for each; fused products would break V x W = -(W x V).
vec3 along_axes(Receiver r, vec3 v) {
    precise vec3 seen = vec3(dot(v, r.x), dot(v, r.y), dot(v, r.z));
    return seen;
}

vec3 edge_line(vec3 v, vec3 w) {
    precise vec3 e = vec3(v.y * w.z - v.z * w.y, v.z * w.x - v.x * w.z, v.x * w.y - v.y * w.x);
    return e;
}

// Whether a line leaves all of the light on its positive side. It need not say so; what it says light_line() says, too.
bool leaves_all(LightShape shape, vec3 e) { return e.z > shape.radius * (abs(e.x) + abs(e.y)); }

// Whether the triangle of three lines lies beside the light, whichever side of its plane the receiver is on.
bool lies_beside(LightShape shape, vec3 e, vec3 f, vec3 g) {
    return (leaves_all(shape, e) || leaves_all(shape, f) || leaves_all(shape, g)) &&
           (leaves_all(shape, -e) || leaves_all(shape, -f) || leaves_all(shape, -g));
}

float taxi(vec3 v) { return abs(v.x) + abs(v.y) + abs(v.z); }

// A height over a plane, times twice the triangle's area, and how far rounding can move it.
struct Height {
    float value, error;
};
bool in_doubt(Height h) { return abs(h.value) <= h.error; }

// From the edges alone: differences keep their own digits, where a product of three corners keeps those of their distance.
Height height_of(vec3 to_a, vec3 ab, vec3 ac) {
    return Height(dot(cross(ab, ac), to_a), 16.0 * UNIT_ROUNDING * taxi(ab) * taxi(ac) * taxi(to_a));
}

// With twice the digits, and 0 where the plane is within its corners' rounding.
Height height_for_sure(vec3 start, vec3 a, vec3 b, vec3 c) {
    const Twofold to_a = twofold_difference(a, start);
    const Twofold n = cross_product(twofold_difference(b, a), twofold_difference(c, a));
    const float height = dot_product(n, to_a);
    precise vec3 reach = max(max(abs(to_a.hi), abs(b - start)), abs(c - start));
    precise float displaced = bvh_vertex_roundings * max(max(reach.x, reach.y), reach.z) * taxi(n.hi);
    return Height(abs(height) > displaced ? height : 0.0, 0.0);
}

// How far along d = (x, y, 1) the near side of a sphere is, less its housing.
float surface_along(Receiver r, vec3 d) {
    const float radius = light.u.x, to_centre = r.before / (1.0 - LIGHT_HOUSING) + radius, d2 = dot(d, d);
    const float tangent2 = (to_centre - radius) * (to_centre + radius);
    return (1.0 - LIGHT_HOUSING) * (to_centre - sqrt(max(to_centre * to_centre - d2 * tangent2, 0.0))) / d2;
}

// Without the samples that are seen through a hole of triangle `which`; those in `known` are not asked for. `opposite`: the edges' lines, whose
// values at a sample are the weights of the corners that they lie opposite to, so that the texture coordinate is a quotient of two such lines.
LightMask without_holes(LightShape shape, uint leaf, uint which, vec3 opposite[3], LightMask mask, LightMask known) {
    const uint word = bvh_alpha_word(leaf, which);
    LightMask asked = mask_if(word != 0u, mask_without(mask, known));
    const AlphaRecord record = alpha_record((max(word, 16u) >> 4) - 1u);
    const uint corner0 = word & 3u, corner1 = word >> 2 & 3u;
    const vec3 w0 = opposite[corner0], w1 = opposite[corner1], w2 = opposite[3u - corner0 - corner1], w = w0 + w1 + w2;
    const vec3 u = w0 * record.uv0.x + w1 * record.uv1.x + w2 * record.uv2.x, v = w0 * record.uv0.y + w1 * record.uv1.y + w2 * record.uv2.y;
    while (!mask_is_empty(asked)) {
        const LightMask lowest = mask_lowest(asked);
        const vec3 d = to_sample(shape, sample_point(shape, mask_index(lowest)));
        if (!alpha_there(record, vec2(dot(u, d), dot(v, d)) / dot(w, d))) mask = mask_without(mask, lowest);
        asked = mask_without(asked, lowest);
    }
    return mask;
}

// Of a mask what a triangle hides of it up to `end` along z, where its corners are at `ends` and `z`. `sum` of its edges' lines: along
// d = (x, y, 1) its plane is at det / (sum . d). Corners decide where they can: a line for nothing could leave a sample.
LightMask hidden_up_to(Receiver r, LightShape shape, float end, vec3 sum, float det, vec2 ends, float z, bool below, LightMask mask) {
    if (max(ends.y, z) < end) return mask;
    if (min(ends.x, z) >= end) return NO_SAMPLES;
    return mask_and(mask, mask_flipped(positive_side(light_line(shape, r.dither, vec3(sum.xy, sum.z - det / end))), below));
}

// .. of a light that ends between `before` and `behind`. Samples of a sphere that lie between are asked for one by one.
LightMask before_light(Receiver r, LightShape shape, vec3 sum, float det, vec2 ends, float z, bool below, LightMask mask) {
    LightMask sure = hidden_up_to(r, shape, r.before, sum, det, ends, z, below, mask);
    if (r.before != r.behind) {
        LightMask asked = mask_without(hidden_up_to(r, shape, r.behind, sum, det, ends, z, below, mask), sure);
        while (!mask_is_empty(asked)) {
            const LightMask lowest = mask_lowest(asked);
            const vec3 d = to_sample(shape, sample_point(shape, mask_index(lowest)));
            if (abs(det) < surface_along(r, d) * abs(dot(sum, d))) sure = mask_or(sure, lowest);
            asked = mask_without(asked, lowest);
        }
    }
    return sure;
}

bvec2 looked_through(Receiver r, BvhLeaf corners, bvec2 matters) {
    return bvec2(matters.x && is_looked_through(r.start, r.beyond_edge_m, corners.a, corners.b, corners.c),
                 matters.y && is_looked_through(r.start, r.beyond_edge_m, corners.c, corners.b, corners.d));
}

// On which side of the planes of a leaf's two triangles the receiver is, where that `matters`.
void decide_sides(Receiver r, BvhLeaf corners, vec3 a, vec3 b, vec3 c, vec3 d, vec3 bc_line, bvec2 matters, out Height first, out Height second) {
    precise vec3 to_a = corners.a - r.start, to_b = corners.b - r.start, to_c = corners.c - r.start, to_d = corners.d - r.start;
    float error = 32.0 * UNIT_ROUNDING * taxi(b) * taxi(c);
    first = Height(dot(a, bc_line), error * taxi(a));
    second = Height(-dot(d, bc_line), error * taxi(d));
    if (HAS_LIGHT) {  // along axes that lie low the corners have lost digits
        const vec3 n = cross(to_b, to_c);
        error = 32.0 * UNIT_ROUNDING * taxi(to_b) * taxi(to_c);
        first = Height(dot(to_a, n), error * taxi(to_a));
        second = Height(-dot(to_d, n), error * taxi(to_d));
    }
    if (matters.x && in_doubt(first) || matters.y && in_doubt(second)) {
        if (in_doubt(first)) first = height_of(to_a, corners.b - corners.a, corners.c - corners.a);
        if (in_doubt(second)) second = height_of(to_c, corners.b - corners.c, corners.d - corners.c);
    }
    const bvec2 unsure = bvec2(matters.x && in_doubt(first), matters.y && in_doubt(second));
    if (any(unsure)) {
        if (unsure.x) first = height_for_sure(r.start, corners.a, corners.b, corners.c);
        if (unsure.y) second = height_for_sure(r.start, corners.c, corners.b, corners.d);
    }
    if (!ON_CPU && !matters.y) second.value = 0.0;  // where there is none its height is anything that rounding makes
}

// Adds to `hidden` what the leaf hides, where it is `wanted`.
void hide_by_leaf(Receiver r, LightShape shape, uint leaf, BvhLeaf corners, bool wanted, inout LightMask hidden) {
    // Before all that needs registers, of which a GPU has few.
    const bvec2 transparent = ON_CPU ? bvec2(false) : looked_through(r, corners, bvec2(wanted));
    precise vec3 to_a = corners.a - r.start, to_b = corners.b - r.start, to_c = corners.c - r.start, to_d = corners.d - r.start;
    const vec3 a = along_axes(r, to_a), b = along_axes(r, to_b), c = along_axes(r, to_c), d = along_axes(r, to_d);
    const vec3 bc_line = edge_line(b, c);
    Height first, second;
    // Before the other lines, which need registers: a GPU has few. A leaf of one triangle has d in c, whose side is never sure.
    if (!ON_CPU) {
        if (!wanted) return;
        decide_sides(r, corners, a, b, c, d, bc_line, bvec2(!transparent.x, !transparent.y && corners.d != corners.c), first, second);
        if (transparent.x) first.value = 0.0;
    }
    const vec3 ab_line = edge_line(a, b), ca_line = edge_line(c, a), bd_line = edge_line(b, d), dc_line = edge_line(d, c);
    // Most do, before all pixels of a subgroup where that is small, and the rest is dear.
    if (ON_CPU && (!wanted || lies_beside(shape, ab_line, bc_line, ca_line) && lies_beside(shape, bd_line, dc_line, -bc_line))) return;
    // Whether d is on one side of both outer edges of the first triangle. Here, where the corners are still in registers.
    precise vec2 at_d = vec2(dot(ab_line, d), dot(ca_line, d));
    const bool d_above = min(at_d.x, at_d.y) >= 0.0, d_below = max(at_d.x, at_d.y) <= 0.0;
    const LightLine ab = light_line(shape, r.dither, ab_line), bc = light_line(shape, r.dither, bc_line),
                    ca = light_line(shape, r.dither, ca_line), bd = light_line(shape, r.dither, bd_line),
                    dc = light_line(shape, r.dither, dc_line);
    const bvec2 none_above = bvec2(none_positive(ab) || none_positive(bc) || none_positive(ca),
                                   none_positive(bd) || none_positive(dc) || none_negative(bc));
    const bvec2 none_below = bvec2(none_negative(ab) || none_negative(bc) || none_negative(ca),
                                   none_negative(bd) || none_negative(dc) || none_positive(bc));
    bvec2 matters = bvec2(!(none_above.x && none_below.x), !(none_above.y && none_below.y));
    if (HAS_LIGHT) {
        const float nearest = min(b.z, c.z);
        matters = bvec2(matters.x && min(a.z, nearest) < r.behind, matters.y && min(d.z, nearest) < r.behind);
    }

    if (ON_CPU) {
        const float close = 2.0 * r.beyond_edge_m * taxi(r.z);  // along z, nearer than which one of its corners is then
        const bvec2 close_ones = bvec2(min(a.z, min(b.z, c.z)) < close, min(d.z, min(b.z, c.z)) < close);
        const bvec2 through = looked_through(r, corners, bvec2(matters.x && close_ones.x, matters.y && close_ones.y));
        matters = bvec2(matters.x && !through.x, matters.y && !through.y);
    }
    if (ON_CPU) decide_sides(r, corners, a, b, c, d, bc_line, matters, first, second);
    bvec2 below = bvec2(first.value < 0.0, second.value < 0.0);
    if (HAS_LIGHT && r.mirrored) below = not(below);
    const bvec2 hides = bvec2(matters.x && first.value != 0.0 && !(below.x ? none_below.x : none_above.x),
                              matters.y && second.value != 0.0 && !(below.y ? none_below.y : none_above.y));
    if (any(hides)) {
        const LightMask above_bc = positive_side(bc),
                        in_first = mask_and(mask_flipped(positive_side(ab), below.x), mask_flipped(positive_side(ca), below.x)),
                        in_second = mask_and(mask_flipped(positive_side(bd), below.y), mask_flipped(positive_side(dc), below.y));
        // Each triangle of a convex pair lies within the other's outer edges, too. Lines of the table are rounded, and those of a triangle
        // that is thinner than samples lie apart enclose some beside it, so that all that is fine would look too large.
        const bool convex = all(hides) && below.x == below.y && (below.x ? d_below : d_above);
        LightMask by_first = mask_and(mask_flipped(above_bc, below.x), mask_and(in_first, mask_or_any(in_second, !convex)));
        LightMask by_second = mask_and(mask_flipped(above_bc, !below.y), mask_and(in_second, mask_or_any(in_first, !convex)));
        by_first = mask_if(hides.x, by_first);
        by_second = mask_if(hides.y, by_second);
        if (HAS_LIGHT) {
            const float farthest = max(b.z, c.z);
            if (max(farthest, max(a.z, d.z)) > r.before) {
                const vec2 ends = vec2(min(b.z, c.z), max(b.z, c.z));
                by_first = before_light(r, shape, ab_line + bc_line + ca_line, dot(a, bc_line), ends, a.z, below.x, by_first);
                by_second = before_light(r, shape, bd_line + dc_line - bc_line, -dot(d, bc_line), ends, d.z, below.y, by_second);
            }
        }
        if (HAS_SCENE_ALPHA) {
            by_first = without_holes(shape, leaf, 0u, vec3[3](bc_line, ca_line, ab_line), by_first, hidden);
            by_second = without_holes(shape, leaf, 1u, vec3[3](bd_line, dc_line, -bc_line), by_second, mask_or(hidden, by_first));
        }
        hidden = mask_or(hidden, mask_or(by_first, by_second));
    }
}
