// SPDX-License-Identifier: MIT
// A cone of directions from a point, and what of a triangle lies in it. Vertices are taken to the cone's own frame: x, y
// across its axis, z along it; a point is inside where |xy| <= spread * z + radius and z >= 0.
//
// Every answer errs towards "meets": by CONE_ROUNDING of the lengths that went into it. A vertex minus the apex is off by
// half an ulp of itself, its three dot products with the frame by three more, and the products of two such points by the
// sum: 16 roundings bound each of them. Forms are chosen that do not cancel (the nearest point of an edge, not the
// discriminant of a quadratic).
//
// Includer has common/bvh_leaf.glsl.

const float ROUNDING = 5.9604644775390625e-8;  // 2^-24
const float CONE_ROUNDING = 16.0 * 5.9604644775390625e-8;

struct Cone {
    vec3 apex;
    mat3 frame;    // columns: across, across, axis; orthonormal
    float spread;  // tangent of the half angle
    float radius;  // at the apex already
};

vec3 cone_point(Cone cone, vec3 vertex) {
    precise vec3 p = vertex - cone.apex;
    return p * cone.frame;
}

float taxicab(vec3 p) { return abs(p.x) + abs(p.y) + abs(p.z); }
float taxicab(vec2 p) { return abs(p.x) + abs(p.y); }
float cross2(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

// Whether a segment may meet the cone (or what lies below its apex). |xy| - spread * z is convex along it; the least value
// is where its slope is zero, or at an end.
bool edge_meets_cone(Cone cone, vec3 a, vec3 b) {
    const vec3 d = b - a;
    const float climb = cone.spread * d.z;
    const float square = dot(d.xy, d.xy);
    const float rest = square - climb * climb;  // not positive: steeper than the cone, nearest at the far end
    const float along = (abs(cross2(a.xy, d.xy)) * climb * inversesqrt(max(rest, 1e-37)) - dot(a.xy, d.xy)) / square;
    const float t = rest > 0.0 ? clamp(along, 0.0, 1.0) : climb > 0.0 ? 1.0 : 0.0;
    const vec3 nearest = a + t * d;
    return length(nearest.xy) - cone.spread * nearest.z - cone.radius <=
           CONE_ROUNDING * (taxicab(a) + taxicab(b) + cone.radius);
}

// Signed distance of an edge from the axis times its length across, and how far rounding can move it.
vec2 axis_side(vec3 a, vec3 b) {
    return vec2(cross2(a.xy, b.xy), CONE_ROUNDING * (taxicab(a.xy) * taxicab(b) + taxicab(b.xy) * taxicab(a)));
}

bool certainly_positive(vec2 value) { return value.x > value.y; }
bool certainly_negative(vec2 value) { return value.x < -value.y; }

// How the axis, both ways from the apex, passes a triangle whose edges have these sides (opposite to a, b, c): through it,
// outside of it, or within rounding of its border.
const uint PIERCES_NOT = 0u;
const uint PIERCES_MAYBE = 1u;
const uint PIERCES = 2u;

uint axis_passes(vec2 sa, vec2 sb, vec2 sc, vec3 a, vec3 b, vec3 c) {
    const bool positive = certainly_positive(sa) || certainly_positive(sb) || certainly_positive(sc);
    const bool negative = certainly_negative(sa) || certainly_negative(sb) || certainly_negative(sc);
    if (positive && negative) return PIERCES_NOT;
    if (all(greaterThan(abs(vec3(sa.x, sb.x, sc.x)), vec3(sa.y, sb.y, sc.y)))) return PIERCES;
    // Small and far triangles have sides below the rounding; their box does not.
    const float margin = CONE_ROUNDING * (taxicab(a) + taxicab(b) + taxicab(c));
    const vec3 lo = min(min(a, b), c), hi = max(max(a, b), c);
    const bool near = max(lo.x, lo.y) <= margin && min(hi.x, hi.y) >= -margin && hi.z >= -margin;
    return near ? PIERCES_MAYBE : PIERCES_NOT;
}

// A leaf's corners in the cone's frame.
BvhLeaf cone_leaf(Cone cone, uint leaf) {
    const BvhLeaf v = bvh_leaf(leaf);
    return BvhLeaf(cone_point(cone, v.a), cone_point(cone, v.b), cone_point(cone, v.c), cone_point(cone, v.d));
}
