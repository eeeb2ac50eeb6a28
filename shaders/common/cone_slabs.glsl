// SPDX-License-Identifier: MIT
// Cones against the boxes of common/bvh_boxes.glsl. A cone may be thick: at its apex it has a radius already.
//
// Includer has common/bvh_boxes.glsl.

// What of a box a cone can meet, axis by axis. With h the distance along the cone's axis, the box of its disc spans
// apex_k -+ radius * w + h * (axis_k -+ spread * w), w = sqrt(1 - axis_k^2): two flanks, each of which meets a plane of the box at one h. A
// flank that moves away from its plane bounds h from below, one that moves towards it from above; where one moves each
// way, as in an axis across which the cone goes, both bound it from below.
struct ConeSlabs {
    vec3 near_inverse, far_inverse;  // 1 / slope of the flank that bounds h from below, and of the other
    bvec3 rising;                    // the first flank meets the low plane, the other the high one
    vec3 also_near, not_far;         // added to the other's h: 0, or out of the way
    bool crosses;                    // whether the cone goes across any axis, else one flank bounds h from below and the other from above
    vec3 thickness;                  // by which the flanks start apart from the apex: radius * w
    float reach;                     // where the cone ends, along its axis
};

vec3 inverse_slope(vec3 slope) {
    const float tiny = 8.271806125530277e-25;  // 2^-80: no 0 * inf
    const vec3 signed_tiny = mix(vec3(tiny), vec3(-tiny), lessThan(slope, vec3(0.0)));
    return 1.0 / mix(signed_tiny, slope, greaterThanEqual(abs(slope), vec3(tiny)));
}

// Of whatever at a distance of 1 along its axis lies in the box from `lower` to `upper`, and at h in one h times as large.
ConeSlabs slabs_of_slopes(vec3 lower, vec3 upper) {
    const vec3 upper_inverse = inverse_slope(upper), lower_inverse = inverse_slope(lower);
    ConeSlabs slabs;
    slabs.rising = greaterThanEqual(upper, vec3(0.0));
    slabs.near_inverse = mix(lower_inverse, upper_inverse, slabs.rising);
    slabs.far_inverse = mix(upper_inverse, lower_inverse, slabs.rising);
    const bvec3 both_ways = notEqual(slabs.rising, greaterThanEqual(lower, vec3(0.0)));
    slabs.crosses = any(both_ways);
    slabs.also_near = mix(vec3(-3e38), vec3(0.0), both_ways);
    slabs.not_far = mix(vec3(0.0), vec3(3e38), both_ways);
    slabs.thickness = vec3(0.0);
    slabs.reach = 3e38;
    return slabs;
}

// Widened by what rounding does to a slope; boxes keep a distance of their own from their planes (host/bvh/bvh.cpp).
ConeSlabs cone_slabs(vec3 axis, float spread, float radius) {
    const vec3 tilt = sqrt(max(1.0 - axis * axis, vec3(0.0)));
    const vec3 across = (spread * 1.0001 + 1e-6) * tilt;
    ConeSlabs slabs = slabs_of_slopes(axis - across, axis + across);
    slabs.thickness = radius * (tilt + 1e-3);
    return slabs;
}

// One axis of the four children of a node: its planes, and what the flanks say of them.
struct ConeSlab {
    uint first, second;  // planes that the flanks meet
    float first_step, first_base, second_step, second_base;
};

ConeSlab cone_slab(ConeSlabs slabs, int axis, uint low_planes, uint high_planes, float grid_step, float base) {
    const bool rising = slabs.rising[axis];
    const float thickness = slabs.thickness[axis], below = base - thickness, above = base + thickness;
    return ConeSlab(rising ? low_planes : high_planes, rising ? high_planes : low_planes, grid_step * slabs.near_inverse[axis],
                    (rising ? below : above) * slabs.near_inverse[axis], grid_step * slabs.far_inverse[axis],
                    (rising ? above : below) * slabs.far_inverse[axis]);
}

vec4 first_flank(ConeSlab slab) { return bvh_planes(slab.first, slab.first_step, slab.first_base); }
vec4 second_flank(ConeSlab slab) { return bvh_planes(slab.second, slab.second_step, slab.second_base); }

// Children whose boxes the cone may meet, bit k for child k; as bvh_hit_children().
uint cone_hit_children(ConeSlabs slabs, vec3 apex, uvec4 n0, uvec4 n1, uvec4 n2) {
    const vec3 grid_step = uintBitsToFloat((uvec3(n0.w, n0.w >> 8, n0.w >> 16) & 255u) << 23);
    const vec3 base = uintBitsToFloat(n0.xyz) - apex;
    const ConeSlab x = cone_slab(slabs, 0, n1.z, n1.w, grid_step.x, base.x), y = cone_slab(slabs, 1, n2.x, n2.y, grid_step.y, base.y),
                   z = cone_slab(slabs, 2, n2.z, n2.w, grid_step.z, base.z);
    const vec4 near = bit_max(bit_max(vec4(0.0), first_flank(x)), bit_max(first_flank(y), first_flank(z)));
    const vec4 other_x = second_flank(x), other_y = second_flank(y), other_z = second_flank(z);
    if (ON_CPU && !slabs.crosses) return bvh_hits(near, bit_min(bit_min(vec4(slabs.reach), other_x), bit_min(other_y, other_z)));
    return bvh_hits(bit_max(bit_max(near, other_x + slabs.also_near.x), bit_max(other_y + slabs.also_near.y, other_z + slabs.also_near.z)),
                    bit_min(bit_min(vec4(slabs.reach), other_x + slabs.not_far.x), bit_min(other_y + slabs.not_far.y, other_z + slabs.not_far.z)));
}
