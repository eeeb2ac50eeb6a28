// SPDX-License-Identifier: MIT
// Proof that nothing reaches into the cones of a tile's shadow rays, from lower bounds of all casters (cascade_node.glsl).
// The whole workgroup, one tile, descends the mip chain together: a list of nodes starts with the few that span the
// tile's search area and is replaced by their children, of which only those stay that matter to some pixel.
//
// A node matters to a point at depth z (metres from the cascade's depth 0, growing away from the sun) only if
//   it may be above it:                    least < z - slack
//   the cone reaches its square:           d <= t (z - least), with t the tangent of the sun's angular radius and d the
//                                          distance across the light from the point to the square
//   its plane is not the point's own:      e = z - plane at the point > slack and, where q = 1 - t |slope| > 0,
//                                          d <= t e / q: at distance r across the light a ray has risen by r / t at
//                                          least, the geometry by e + |slope| r at most.
// `slack` keeps the point's own surface from blocking it: a share of a texel, plus what fp32 rounds away. Casters lower
// than that above the surface are lost; there is no other bias. Every test is written so that a NaN does not exclude.

const int LIST = 128;         // nodes; a longer list is not refined: still a proof, only looser
const int FIRST_SPAN = 4;     // nodes along a side of the first list
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
    int level;         // 0: the bounds; l: level l - 1 of the pyramid
    float node_m;      // side of a node at that level
};

shared vec4 slots[32];
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

CascadeNode load_node(Search s, ivec2 place) {
    const ivec3 at = ivec3(place, int(s.cascade));
    return cascade_node(s.level == 0 ? texelFetch(cascade_bounds, at, 0) : texelFetch(cascade_pyramid, at, s.level - 1));
}

float outside(float low, float high, float node_low, float node_high) {
    return max(max(node_low - high, low - node_high), 0.0);
}

// Whether a node matters to no point of a box below a plane. A pixel is a box of no size.
bool is_excluded(Search s, Tile t, CascadeNode node, ivec2 place, out float distance_m) {
    const vec2 low = vec2(place) * s.node_m, high = low + s.node_m;
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

void append_node(uint list, CascadeNode node, ivec2 place) {
    const uint at = atomicAdd(list_count[list], 1u);
    list_nodes[list][at] = vec4(node.least, node.level, node.slope);
    list_places[list][at] = uint(place.x) | uint(place.y) << 16;
}

// The nodes that span a box, those that matter: at most FIRST_SPAN a side, at the finest level where so few suffice.
// False where the chain has no such level.
bool first_list(inout Search s, Tile t, vec2 low, vec2 high) {
    s.level = 0;
    s.node_m = s.texel_m;
    ivec2 begin = ivec2(floor(low / s.node_m)), end = ivec2(floor(high / s.node_m)) + 1;
    const int levels = textureQueryLevels(cascade_pyramid);
    while (any(greaterThan(end - begin, ivec2(FIRST_SPAN)))) {
        if (++s.level > levels) return false;
        s.node_m *= 2.0;
        begin >>= 1;
        end = (end + 1) >> 1;
    }
    barrier();  // nobody reads the lists of a search before
    if (gl_LocalInvocationIndex == 0u) list_count[0] = list_count[1] = 0u;
    barrier();
    const int lane = int(gl_LocalInvocationIndex);
    const ivec2 place = begin + ivec2(lane % FIRST_SPAN, lane / FIRST_SPAN);
    if (lane < FIRST_SPAN * FIRST_SPAN && all(lessThan(place, end))) {
        const CascadeNode node = load_node(s, place);
        float distance_m;
        if (!is_excluded(s, t, node, place, distance_m)) append_node(0u, node, place);
    }
    barrier();
    return true;
}

// Children for parents, as deep as the list's length allows; returns which of the two lists holds the result.
uint refine(inout Search s, Tile t) {
    uint from = 0u;
    while (s.level > 0 && list_count[from] > 0u && 4u * list_count[from] <= uint(LIST)) {
        const uint to = 1u - from;
        s.level -= 1;
        s.node_m *= 0.5;
        for (uint i = gl_LocalInvocationIndex; i < 4u * list_count[from]; i += 32u) {
            const uint parent = list_places[from][i >> 2];
            const ivec2 place = 2 * ivec2(parent & 0xffffu, parent >> 16) + ivec2(i & 1u, i >> 1 & 1u);
            const CascadeNode node = load_node(s, place);
            float distance_m;
            if (!is_excluded(s, t, node, place, distance_m)) append_node(to, node, place);
        }
        barrier();
        if (gl_LocalInvocationIndex == 0u) list_count[from] = 0u;
        from = to;
        barrier();
    }
    return from;
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

// The least depth of the list's nodes, over the workgroup.
float list_top(uint list) {
    float top = NO_SURFACE;
    for (uint i = 0u; i < list_count[list]; ++i) top = min(top, list_nodes[list][i].x);
    return top;
}
