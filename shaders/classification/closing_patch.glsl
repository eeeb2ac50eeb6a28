// SPDX-License-Identifier: MIT
// The proof that a surface closes a cone off. The axis pierces a triangle; from there a patch of triangles grows across
// every edge that meets the cone, until no border is left inside. The edge must have a neighbour, and the rays must pass
// both triangles the same way: no fold. Then a ray that turns from the axis to any other place in the cone leaves one
// triangle of the patch only into the next, so it is blocked as well. Windings do not matter, and any soup will do.
//
// A part of beam_query.glsl.

const uint NO_NEIGHBOUR = ~0u;

// Alpha-tested triangles touch a cone but never cover it: a ray may pass through a hole.
bool can_cover(uint leaf, uint which) { return !bvh_alpha_tested(leaf, which); }

// Whether no ray of the cone passes the surface around a triangle that its axis pierces. `first`: leaf << 1 | which.
bool covers(Walk walk, uint first) {
    const Cone cone = walk.cone;
    // Triangles of the patch as words of leaf_neighbours(), each entered by the edge opposite to its corner (the first by
    // none). Bit 3 has become the side that it must show for the edge to be no fold.
    uint patch_words[PATCH];
    patch_words[0] = first >> 1 << 4 | (first & 1u) << 2 | 3u;
    uint count = 1u;
    bool closed = true;
    for (uint i = 0u; i < count && closed; ++i) {
        const uint word = patch_words[i];
        const uint leaf = word >> 4;
        const bool second = (word & 4u) != 0u;
        const BvhLeaf corners = cone_leaf(cone, leaf);
        const uvec4 across = neighbours[leaf];
        // Two triangles of a leaf are each other's neighbours; see host/bvh/bvh.h for the words of the other edges.
        const bool pair = corners.d != corners.c;
        vec3 a = second ? corners.c : corners.a, b = corners.b, c = second ? corners.d : corners.c;
        uvec3 next = second ? uvec3(across.z, across.w, leaf << 4)
                            : uvec3(pair ? leaf << 4 | 6u : across.z, across.y, across.x);
        const int side = beam_side(walk, a, b, c);
        const uint from_below = side < 0 ? 8u : 0u;
        if (side == 0 || side == BEHIND || (i > 0u && from_below != (word & 8u)) || !can_cover(leaf, word >> 2 & 1u)) closed = false;
        for (uint k = 0u; k < 3u; ++k) {
            if (closed && k != (word & 3u) && edge_meets_cone(cone, b, c)) {
                const uint entered = next.x ^ from_below;
                bool known = false;
                for (uint j = 0u; j < count; ++j)
                    if (patch_words[j] >> 2 == entered >> 2) known = true;
                if (next.x == NO_NEIGHBOUR || (!known && count == PATCH)) closed = false;
                if (closed && !known) {
                    patch_words[count] = entered;
                    ++count;
                }
            }
            const vec3 rotated = a;
            a = b;
            b = c;
            c = rotated;
            next = next.yzx;
        }
    }
    return closed;
}
