// SPDX-License-Identifier: MIT
// Pixels that the cascades' bounds prove lit need no ray. One workgroup per listed tile, one lane per pixel; the list of
// texels is the tile's, so that a load serves 32 pixels. See cascade_proof.glsl. Wherever the proof cannot be led
// (no cascade holds the search area, numbers that are none, the sun's rim near the surface's own horizon), rays decide.
#define APPENDS_TILES
#define LISTED_TILES candidates
#define LISTED_ARGS candidate_args
#include "node.glsl"
#include "common/camera.glsl"
#include "classification/cascade_node.glsl"
#include "common/cascade_place.glsl"
#include "common/ray_offset.glsl"
#include "common/receiver_normal.glsl"
#include "classification/tile_interval.glsl"
#include "common/tile_list.glsl"
#include "common/tiles.glsl"
#include "classification/cascade_proof.glsl"

// What fp32 rounds away of a depth z: a few ulps, and a bound for small scenes' positions.
const float ROUNDING_OF_DEPTH = 2e-6;
const float ROUNDING_M = 1e-5;
const float OFFSET_SHARE = 64.0;  // rays start off the surface by less than this part of a pixel, or of a texel

vec2 sides_m(Cascade c) { return vec2(textureSize(cascade_bounds, 0).xy) * c.texel_m; }

// Texel-scale metres across the light and along it. Depth 0 is above every caster.
vec3 metres_in(Cascade c, vec3 relative) {
    return in_cascade(c, relative) * vec3(sides_m(c), c.depth_m);
}

// Rays decide everything where the host does not say that the bounds hold all casters.
uint usable_cascades() {
    return (cascades.flags & BOUNDS_HOLD_ALL) != 0u ? cascade_count(textureSize(cascade_bounds, 0).z) : 0u;
}

struct Area {
    bool found;
    Search search;
    Tile bounds;
    vec3 at;          // this lane's pixel
    vec2 low, high;   // the tile, grown by the search radius
};

// In cascade k, for casters no farther along the light than `reach_m`. All invocations call it.
Area area_in(uint k, float reach_m, bool wanted, vec3 relative, bool speaks, vec3 n) {
    Area area;
    area.found = false;
    const Cascade c = cascades.c[k];
    if (!is_usable(c)) return area;
    area.at = metres_in(c, relative);
    area.bounds = tile_about(wanted, area.at, speaks, receiver_slope(c, n));
    area.search.cascade = k;
    area.search.tangent = tan(sun.angular_radius);
    area.search.texel_m = c.texel_m;
    area.search.slack =
        CONTACT_TEXELS * c.texel_m + ROUNDING_OF_DEPTH * (abs(area.bounds.deepest) + c.depth_m) + ROUNDING_M;
    area.search.blur = c.texel_m / OFFSET_SHARE;
    const float radius = area.search.tangent * min(reach_m, area.bounds.deepest) + c.texel_m / OFFSET_SHARE;
    area.low = area.bounds.low - radius;
    area.high = area.bounds.high + radius;
    area.found = all(greaterThan(area.low, vec2(0.0))) && all(lessThan(area.high, sides_m(c))) &&
                 all(lessThanEqual(area.low, area.high)) && all(lessThan(area.high - area.low, vec2(float(SPAN) * c.texel_m)));
    return area;
}

void main() {
    uvec4 record;
    if (!listed_tile(record)) return;  // the whole workgroup
    open_tile();
    const int lane = int(gl_LocalInvocationIndex);
    const ivec2 in_tile = pixel_of_lane(lane);
    const ivec2 tile = tile_of(record), p = tile * TILE + in_tile;
    const uint bit = pixel_bit(in_tile);
    const bool wanted = (record.y & bit) != 0u;
    const bool speaks = bit == 1u << uint(findLSB(record.y));  // its normal stands for the tile's

    const float view_z = wanted ? imageLoad(view_depth, p).x : 0.0;
    const vec3 n = wanted ? decode_receiver_normal(imageLoad(receiver_normal, p).xy) : vec3(0.0);
    // The proof is of the rays, which start off the surface by what may be wrong about the point: so the surface itself is
    // below them, whatever its slope. Where the triangles' frame is farther away, rays start a little higher still.
    const vec3 seen = wanted ? position(p, view_z) : vec3(0.0);
    const vec3 relative = seen + n * (wanted ? robust_offset_m(p, view_z, n, seen, seen) : 0.0);
    const bool may_be_lit = cap_leaves_surface(n, sun.to_sun, sun.angular_radius);  // else it shades itself

    // From the coarsest cascade on: what it shows is often lower than the topmost caster; then a smaller area suffices, of which
    // a finer cascade may show more.
    Search search;
    vec3 at = vec3(0.0);
    bool proving = false;
    uint list = 0u;
    float reach_m = WHOLE_RAY_M;  // along the light, to the topmost caster that may matter
    for (int k = int(usable_cascades()) - 1; k >= 0; --k) {
        const Area area = area_in(uint(k), reach_m, wanted, relative, speaks, n);
        if (!area.found || !fill_list(1u - list, area.search, area.bounds, area.low, area.high)) continue;
        proving = true;
        list = 1u - list;
        search = area.search;
        at = area.at;
        if (list_count[list] == 0u) break;
        reach_m = area.bounds.deepest - list_top(list);
    }
    Proof proof = Proof(false, 0.0, WHOLE_RAY_M);
    if (proving) proof = test_list(search, list, at);
    const bool lit = proof.lit && may_be_lit;
    // Rays of a driver's queries start ahead, too (ray_offset.glsl).
    const float margin_m = proving ? pixel_span_m(view_z) / OFFSET_SHARE + beyond_edge_m(p, view_z, n) : 0.0;
    const bool whole = !proving || !may_be_lit;  // the interval speaks of the proof's rays
    close_tile(wanted && !lit, bit, whole ? 0.0 : proof.nearest_m - margin_m,
               whole ? WHOLE_RAY_M : (proof.farthest_m + margin_m) / cos(sun.angular_radius));

    const bool first = lane == 0;
    const uvec4 left = closed_record(record, USE_INTERVAL);
    append_tile(first && left.y != 0u, left);
#if HAS_UNDECIDED_WORDS
    if (first) undecided_words[tile_index(tile_of(record))] = left.y;
#endif
    count_lit(first ? uint(bitCount(record.y & ~left.y)) : 0u);
    count_unknown(first ? uint(bitCount(left.y)) : 0u);
    count_tiles_listed(first && left.y != 0u ? 1u : 0u);
}
