// SPDX-License-Identifier: MIT
// Which pixels have a ray in a frame where not all have one: every second on a checkerboard, or one of 2x2, another in each of four
// frames. Where the specular lobe has its turn the diffuse one has not, so that half of the rays for either is one ray per pixel.
// In a workgroup of 8x8 those that have one come first, so that whole subgroups end at once.
//
// Includer has common/pixels.glsl, reflections/lobe.glsl and reflections/ray_numbers.glsl and declares: constant RAYS.

const uint TURN_OF_LOBE = LOBE == LOBE_DIFFUSE ? 1u : 0u;

// Of the one pixel of 2x2: x, and y in the second bit. Opposite corners first.
uint quarter_in_turn() { return uint[](0u, 3u, 1u, 2u)[frame.frame_index + TURN_OF_LOBE & 3u]; }

bool in_turn(ivec2 p) {
    if (RAYS == RAYS_HALF) return (uint(p.x + p.y) + frame.frame_index + TURN_OF_LOBE & 1u) == 0u;
    if (RAYS == RAYS_QUARTER) return (uint(p.x & 1) | uint(p.y & 1) << 1) == quarter_in_turn();
    return true;
}

// Those that have one are numbered without gaps: every second number of a sequence is a sequence that fills less evenly.
uint index_in_turn(ivec2 p, uint time) {
    if (RAYS == RAYS_HALF) return ray_index(p, time) >> 1;  // all are odd or all even
    if (RAYS == RAYS_QUARTER) return ray_index(p >> 1, time);
    return ray_index(p, time);
}

// Whether a neighbour's ray says little of a lobe: its mirrored direction is off by as much as the lobe is wide. Such a pixel has a ray
// in every frame.
bool is_narrow(float roughness) {
    const float neighbour = (frame.flags & FRAME_ORTHOGRAPHIC) != 0u ? 0.0 : 2.0 * frame.pixel_angle;
    return is_mirror(roughness) || LOBE == LOBE_SPECULAR && roughness * roughness < neighbour;
}

// A workgroup's pixel, from its corner.
uvec2 pixel_of_lane(uint lane) {
    const uint turn = RAYS == RAYS_HALF ? lane >> 5 : lane >> 4, k = RAYS == RAYS_HALF ? lane & 31u : lane & 15u;
    const uint column = 2u * (k & 3u), row = k >> 2;
    if (RAYS == RAYS_HALF) return uvec2(column + (row + frame.frame_index + TURN_OF_LOBE + turn & 1u), row);
    const uint offset = quarter_in_turn() ^ turn;
    return uvec2(column + (offset & 1u), 2u * row + (offset >> 1));
}

void for_each_pixel_in_turn() {
    const uvec3 group = gl_WorkGroupSize;
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (RAYS != RAYS_ALL) {
        if (group.y == 8u) p = ivec2(8u * gl_WorkGroupID.xy + pixel_of_lane(gl_LocalInvocationIndex));
    }
    if (inside_frame(p)) for_pixel(p);
}
