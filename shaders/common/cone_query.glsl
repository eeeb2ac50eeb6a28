// SPDX-License-Identifier: MIT
// One question to the hierarchy of host/bvh.h: does a cone of shadow rays meet nothing, is it blocked by a surface that
// closes it off, or neither? The first two are proofs that no ray of the cone is needed.
//
// Lit: no triangle meets the cone. Shadowed: the axis pierces a triangle, and the patch of triangles around it has no
// border inside the cone. The patch grows across every edge that meets the cone; the edge must have a neighbour, and be no
// fold seen from the apex (both triangles show the apex the same face). Then moving from the axis to any other
// direction of the cone leaves one triangle of the patch only into the next, so every ray is blocked. Windings do not
// matter, and any soup will do.
// A cone that has met something is followed along its axis only: what remains to be found is a cover.
//
// Includer declares: uniform usamplerBuffer scene_nodes, scene_leaves, neighbours; const uint PATCH (triangles), BUDGET (steps).
#include "common/bvh.glsl"
#include "common/cone.glsl"

const uint CONE_MIXED = 0u;
const uint CONE_CLEAR = 1u;
const uint CONE_COVERED = 2u;

const uint NO_NEIGHBOUR = ~0u;

struct Leaf {
    vec3 v0, v1, v2, v3;  // in the cone's frame
};

Leaf cone_leaf(Cone cone, uint leaf) {
    const int texel = int(leaf * 3u);
    const vec4 q0 = uintBitsToFloat(texelFetch(scene_leaves, texel));
    const vec4 q1 = uintBitsToFloat(texelFetch(scene_leaves, texel + 1));
    const vec4 q2 = uintBitsToFloat(texelFetch(scene_leaves, texel + 2));
    return Leaf(cone_point(cone, q0.xyz), cone_point(cone, vec3(q0.w, q1.xy)), cone_point(cone, vec3(q1.zw, q2.x)),
                cone_point(cone, q2.yzw));
}

// Alpha-tested triangles touch a cone but never cover it: a ray may pass through a hole. Nothing else about them differs.
bool can_cover(uint leaf, uint which) { return true; }

// Whether no ray of the cone passes the surface around a triangle that its axis pierces. `first`: leaf << 1 | which.
bool covers_cone(Cone cone, uint first) {
    // The words of leaf_neighbours(), each entered by the edge opposite to its corner; the first by none.
    uint patch_words[PATCH];
    patch_words[0] = first << 2 | 3u;
    uint count = 1u;
    bool closed = can_cover(first >> 1, first & 1u);
    for (uint i = 0u; i < count && closed; ++i) {
        const uint word = patch_words[i];
        const uint leaf = word >> 3;
        const bool second = (word & 4u) != 0u;
        const Leaf corners = cone_leaf(cone, leaf);
        const uvec4 across = texelFetch(neighbours, int(leaf));
        // Two triangles of a leaf are each other's neighbours; see host/bvh.h for the words of the other edges.
        const bool pair = corners.v3 != corners.v2;
        vec3 a = second ? corners.v2 : corners.v0, b = corners.v1, c = second ? corners.v3 : corners.v2;
        uvec3 next = second ? uvec3(across.z, across.w, leaf << 3)
                            : uvec3(pair ? leaf << 3 | 6u : across.z, across.y, across.x);
        for (uint k = 0u; k < 3u; ++k) {
            if (k != (word & 3u) && edge_meets_cone(cone.spread, b, c)) {
                const uint n = next.x;
                bool crossed = false;
                if (n != NO_NEIGHBOUR && can_cover(n >> 3, n >> 2 & 1u)) {
                    const Leaf there = cone_leaf(cone, n >> 3);
                    const uint corner = n & 7u;  // 0 1 2: v0 v1 v2; 4 5 6: v2 v1 v3
                    const vec3 d = corner == 0u                   ? there.v0
                                   : (corner & 3u) == 1u          ? there.v1
                                   : corner == 6u                 ? there.v3
                                                                  : there.v2;
                    const vec2 ours = facing(b, c, a), theirs = facing(b, c, d);
                    const bool smooth_edge = (certainly_positive(ours) && certainly_negative(theirs)) ||
                                             (certainly_negative(ours) && certainly_positive(theirs));
                    bool known = false;
                    for (uint j = 0u; j < count; ++j)
                        if (patch_words[j] >> 2 == n >> 2) known = true;
                    crossed = smooth_edge && (known || count < PATCH);
                    if (crossed && !known) {
                        patch_words[count] = n;
                        ++count;
                    }
                }
                if (!crossed) closed = false;
            }
            const vec3 first_corner = a;
            a = b;
            b = c;
            c = first_corner;
            next = next.yzx;
        }
    }
    return closed;
}

// What of a box a cone can meet, axis by axis. With h the distance along the cone's axis, the box of its disc spans
// apex_k + h * (axis_k -+ spread * sqrt(1 - axis_k^2)): two flanks, each of which meets a plane of the box at one h. A
// flank that moves away from its plane bounds h from below, one that moves towards it from above; where one moves each
// way, as in an axis across which the cone goes, both bound it from below.
struct ConeSlabs {
    vec3 near_inverse, far_inverse;  // 1 / slope of the flank that bounds h from below, and of the other
    bvec3 rising;                    // the first flank meets the low plane, the other the high one
    vec3 also_near, not_far;         // added to the other's h: 0, or out of the way
};

vec3 inverse_slope(vec3 slope) {
    const float tiny = 8.271806125530277e-25;  // 2^-80: no 0 * inf
    const vec3 signed_tiny = mix(vec3(tiny), vec3(-tiny), lessThan(slope, vec3(0.0)));
    return 1.0 / mix(signed_tiny, slope, greaterThanEqual(abs(slope), vec3(tiny)));
}

// Widened by what rounding does to a slope; boxes keep a distance of their own from their planes (host/bvh.cpp).
ConeSlabs cone_slabs(vec3 axis, float spread) {
    const vec3 across = (spread * 1.0001 + 1e-6) * sqrt(max(1.0 - axis * axis, vec3(0.0)));
    const vec3 upper = axis + across, lower = axis - across;
    const vec3 upper_inverse = inverse_slope(upper), lower_inverse = inverse_slope(lower);
    ConeSlabs slabs;
    slabs.rising = greaterThanEqual(upper, vec3(0.0));
    slabs.near_inverse = mix(lower_inverse, upper_inverse, slabs.rising);
    slabs.far_inverse = mix(upper_inverse, lower_inverse, slabs.rising);
    const bvec3 both_ways = notEqual(slabs.rising, greaterThanEqual(lower, vec3(0.0)));
    slabs.also_near = mix(vec3(-3e38), vec3(0.0), both_ways);
    slabs.not_far = mix(vec3(0.0), vec3(3e38), both_ways);
    return slabs;
}

void cone_slab(inout vec4 near, inout vec4 far, uint low_planes, uint high_planes, float grid_step, float base, bool rising,
               float near_inverse, float far_inverse, float also_near, float not_far) {
    near = max(near, bvh_planes(rising ? low_planes : high_planes, grid_step * near_inverse, base * near_inverse));
    const vec4 other = bvh_planes(rising ? high_planes : low_planes, grid_step * far_inverse, base * far_inverse);
    near = max(near, other + also_near);
    far = min(far, other + not_far);
}

// Children whose boxes the cone may meet, bit k for child k; as bvh_hit_children().
uint cone_hit_children(ConeSlabs slabs, vec3 apex, uvec4 n0, uvec4 n1, uvec4 n2) {
    const vec3 grid_step = uintBitsToFloat((uvec3(n0.w, n0.w >> 8, n0.w >> 16) & 255u) << 23);
    const vec3 base = uintBitsToFloat(n0.xyz) - apex;
    vec4 near = vec4(0.0), far = vec4(3e38);
    cone_slab(near, far, n1.z, n1.w, grid_step.x, base.x, slabs.rising.x, slabs.near_inverse.x, slabs.far_inverse.x,
              slabs.also_near.x, slabs.not_far.x);
    cone_slab(near, far, n2.x, n2.y, grid_step.y, base.y, slabs.rising.y, slabs.near_inverse.y, slabs.far_inverse.y,
              slabs.also_near.y, slabs.not_far.y);
    cone_slab(near, far, n2.z, n2.w, grid_step.z, base.z, slabs.rising.z, slabs.near_inverse.z, slabs.far_inverse.z,
              slabs.also_near.z, slabs.not_far.z);
    const uvec4 hit = mix(uvec4(0), uvec4(1, 2, 4, 8), lessThanEqual(near, far * 1.000002));
    return hit.x | hit.y | hit.z | hit.w;
}

struct LeafAnswer {
    bool touched;
    uint pierced;  // bit 0, 1: the axis passes through the first, the second triangle
};

// `clean`: nothing has been met so far; only then it matters whether the cone is touched.
LeafAnswer cone_meets_leaf(Cone cone, uint leaf, bool clean) {
    const Leaf v = cone_leaf(cone, leaf);
    const vec2 s01 = axis_side(v.v0, v.v1), s12 = axis_side(v.v1, v.v2), s20 = axis_side(v.v2, v.v0),
               s13 = axis_side(v.v1, v.v3), s32 = axis_side(v.v3, v.v2), s21 = vec2(-s12.x, s12.y);
    LeafAnswer answer = LeafAnswer(false, 0u);
    const uint first = axis_pierces(s12, s20, s01, v.v0, v.v1, v.v2), second = axis_pierces(s13, s32, s21, v.v2, v.v1, v.v3);
    answer.pierced = uint(first == PIERCES) | uint(second == PIERCES) << 1;
    if (clean)
        answer.touched = first != PIERCES_NOT || second != PIERCES_NOT || edge_meets_cone(cone.spread, v.v0, v.v1) ||
                         edge_meets_cone(cone.spread, v.v1, v.v2) || edge_meets_cone(cone.spread, v.v2, v.v0) ||
                         edge_meets_cone(cone.spread, v.v1, v.v3) || edge_meets_cone(cone.spread, v.v3, v.v2);
    return answer;
}

// CONE_CLEAR, CONE_COVERED or CONE_MIXED. The walk is that of occluded() in bvh.glsl, whose comments hold here too.
uint query_cone(Cone cone) {
    const vec3 axis = cone.frame[2];
    const ConeSlabs wide = cone_slabs(axis, cone.spread), thin = cone_slabs(axis, 0.0);
    const uint away = uint(axis.x > 0.0) | uint(axis.y > 0.0) << 1 | uint(axis.z > 0.0) << 2;
    uint group = 1u;
    uint leaf_first = 0u, leaf_mask = 0u;
    uint stack[bvh_stack_size];
    uint depth = 0u;
    bool clean = true, covered = false;
    uint steps = 0u;
    while (true) {
        const uint leaf_bit = leaf_mask & (~leaf_mask + 1u);
        if (leaf_bit != 0u) {
            const uint leaf = leaf_first + bvh_bit_index(leaf_bit);
            const LeafAnswer answer = cone_meets_leaf(cone, leaf, clean);
            if (answer.touched) clean = false;
            if ((answer.pierced & 1u) != 0u && covers_cone(cone, leaf << 1)) covered = true;
            if (!covered && (answer.pierced & 2u) != 0u && covers_cone(cone, leaf << 1 | 1u)) covered = true;
            leaf_mask ^= leaf_bit;
        }
        const bool visit = leaf_mask == 0u && (group & 15u) != 0u;
        uint hits = 0u, bit = 0u;
        uvec4 n0, n1, n2;
        if (visit) {
            bit = group & (~group + 1u);
            const int texel = int(((group >> 6) + (bvh_bit_index(bit) ^ (group >> 4 & 3u))) * 3u);
            n0 = texelFetch(scene_nodes, texel);
            n1 = texelFetch(scene_nodes, texel + 1);
            n2 = texelFetch(scene_nodes, texel + 2);
            ConeSlabs slabs = thin;
            if (clean) slabs = wide;
            hits = cone_hit_children(slabs, cone.apex, n0, n1, n2);
        }
        group ^= bit;
        stack[depth] = group;
        if (visit) {
            leaf_mask = hits & n0.w >> 28;
            leaf_first = n1.y;
            hits &= n0.w >> 24;
            if (hits != 0u) {
                depth += uint((group & 15u) != 0u);
                const bool last_first = (away >> (n1.x & 3u) & 1u) != 0u;
                group = n1.x >> 2 << 6 | (last_first ? 48u | bvh_reverse4(hits) : hits);
            }
        }
        if ((group & 15u) == 0u && depth > 0u) group = stack[--depth];
        ++steps;
        if (covered || steps >= BUDGET || ((group & 15u) | leaf_mask) == 0u) break;
    }
    const bool finished = ((group & 15u) | leaf_mask) == 0u;
    return covered ? CONE_COVERED : clean && finished ? CONE_CLEAR : CONE_MIXED;
}
