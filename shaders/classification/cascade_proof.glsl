// SPDX-License-Identifier: MIT
// Proof that nothing reaches into the cones of a tile's shadow rays, from lower bounds of all casters (cascade_node.glsl).
// The whole workgroup, one tile, looks at the texels of the tile's search area together and lists those that matter to some
// pixel; each pixel is then tested against the list.
//
// A texel matters to a point at depth z (metres from the cascade's depth 0, growing away from the sun) only if
//   it may be above it:                    least < z - slack
//   the cone reaches its square:           d <= t (z - least), with t the tangent of the sun's angular radius and d the
//                                          distance across the light from the point to the square
//   its plane is not the point's own:      e = z - plane at the point > slack and, where q = 1 - t |slope| > 0,
//                                          d <= t e / q: at distance r across the light a ray has risen by r / t at
//                                          least, the geometry by e + |slope| r at most.
// `slack` keeps the point's own surface from blocking it: a share of a texel, plus what fp32 rounds away. Casters lower
// than that above the surface are lost; there is no other bias. Every test is written so that a NaN does not exclude.

const uint LIST = 128u;       // texels; where more matter, nothing is proved
const float NOBODY = -1e30;   // what lanes without a pixel add to a maximum

struct Tile {
    vec2 low, high;    // box across the light
    float deepest;     // greatest z
    vec2 centre, slope;
    float above;       // z <= above + dot(slope, p - centre) for all of the tile's points
};

struct Search {
    float tangent, slack;
    float blur;        // by how far across the light a point may be off: rounding, and the offset that rays start with
    uint cascade;
    float texel_m;
};

shared vec4 slots[32];
// Two lists: one that holds while the other is tried.
shared vec4 list_nodes[2][LIST];
shared uint list_places[2][LIST];
shared uint list_count[2];
shared vec2 guess;

// The maximum over the workgroup. All invocations call it.
vec4 tile_max(vec4 v) {
    v = subgroupMax(v);
    barrier();  // the slots have been read
    if (subgroupElect()) slots[gl_SubgroupID] = v;
    barrier();
    v = slots[0];
    for (uint i = 1u; i < gl_NumSubgroups; ++i) v = max(v, slots[i]);
    return v;
}

// `slope`: of the receiver under the tile as the one lane that `speaks` sees it; any value gives a bound.
Tile tile_about(bool wanted, vec3 at, bool speaks, vec2 slope) {
    if (speaks) guess = slope;
    const vec4 a = tile_max(wanted ? vec4(at.xy, -at.xy) : vec4(NOBODY));
    Tile tile;
    tile.low = -a.zw;
    tile.high = a.xy;
    tile.centre = 0.5 * (tile.low + tile.high);
    tile.slope = guess;
    const float above = at.z - dot(tile.slope, at.xy - tile.centre);
    const vec4 b = tile_max(wanted ? vec4(at.z, above, 0.0, 0.0) : vec4(NOBODY));
    tile.deepest = b.x;
    tile.above = b.y;
    return tile;
}

float outside(float low, float high, float node_low, float node_high) {
    return max(max(node_low - high, low - node_high), 0.0);
}

// Whether a texel matters to no point of a box below a plane. A pixel is a box of no size.
bool is_excluded(Search s, Tile t, CascadeNode node, ivec2 place, out float distance_m) {
    const vec2 low = vec2(place) * s.texel_m, high = low + s.texel_m;
    const vec2 gap = vec2(outside(t.low.x, t.high.x, low.x, high.x), outside(t.low.y, t.high.y, low.y, high.y));
    distance_m = max(length(gap) - s.blur, 0.0);
    if (node.least >= t.deepest - s.slack) return true;
    if (distance_m > s.tangent * (t.deepest - node.least)) return true;
    // The greatest height of the points over the node's plane.
    const vec2 half_size = 0.5 * (t.high - t.low);
    const float height = t.above - (node.level + dot(node.slope, t.centre - 0.5 * (low + high))) +
                         dot(abs(t.slope - node.slope), half_size);
    const float q = 1.0 - s.tangent * length(node.slope);
    return q > 0.0 && (height <= s.slack || distance_m * q > s.tangent * height);
}

// The texels of a box, those that matter. False where they are too many.
bool fill_list(uint list, Search s, Tile t, vec2 low, vec2 high) {
    const ivec2 begin = ivec2(floor(low / s.texel_m)), size = ivec2(floor(high / s.texel_m)) + 1 - begin;
    barrier();  // nobody reads this list any more
    if (gl_LocalInvocationIndex == 0u) list_count[list] = 0u;
    barrier();
    for (int i = int(gl_LocalInvocationIndex); i < size.x * size.y; i += 32) {
        const ivec2 place = begin + ivec2(i % size.x, i / size.x);
        const CascadeNode node = cascade_node(texelFetch(cascade_bounds, ivec3(place, int(s.cascade)), 0));
        float distance_m;
        if (!is_excluded(s, t, node, place, distance_m)) {
            const uint at = atomicAdd(list_count[list], 1u);
            if (at >= LIST) continue;
            list_nodes[list][at] = vec4(node.least, node.level, node.slope);
            list_places[list][at] = uint(place.x) | uint(place.y) << 16;
        }
    }
    barrier();
    return list_count[list] <= LIST;
}

struct Proof {
    bool lit;
    float nearest_m, farthest_m;  // along the light: where a blocker may be, if not
};

// One pixel against the final list.
Proof test_list(Search s, uint list, vec3 at) {
    Tile point = Tile(at.xy, at.xy, at.z, at.xy, vec2(0.0), at.z);
    Proof proof = Proof(true, WHOLE_RAY_M, 0.0);
    for (uint i = 0u; i < list_count[list]; ++i) {
        const vec4 n = list_nodes[list][i];
        const CascadeNode node = CascadeNode(n.x, n.y, n.zw);
        const uint packed = list_places[list][i];
        float distance_m;
        const bool excluded =
            is_excluded(s, point, node, ivec2(packed & 0xffffu, packed >> 16), distance_m);
        proof.lit = proof.lit && excluded;
        // A caster at that distance is met no sooner than where the cone has become as wide.
        const float from = s.tangent > 0.0 ? distance_m / s.tangent - s.slack : 0.0;
        proof.nearest_m = excluded ? proof.nearest_m : min(proof.nearest_m, from);
        proof.farthest_m = excluded ? proof.farthest_m : max(proof.farthest_m, at.z - node.least + s.slack);
    }
    return proof;
}

// The least depth of the list's texels.
float list_top(uint list) {
    float top = NO_SURFACE;
    for (uint i = 0u; i < list_count[list]; ++i) top = min(top, list_nodes[list][i].x);
    return top;
}
