// SPDX-License-Identifier: MIT
// Whole tiles at once: one lane follows the beam of all shadow rays of an 8x4 tile through the tree, once for up to 32
// pixels. Many tiles of a frame are lit or shadowed as a whole and done then; the others go on in a shorter list.
// A proof that fails costs as much as one that holds, and a tile's next frame is much as its last: where `proved_before` is
// bound, a tile gets a beam if it was decided then, and else in its turn. A proof changes no ray's
// answer, but for what stands nearer to it than beams start ahead (start_of()).
#define APPENDS_TILES
#include "node.glsl"
#include "common/camera.glsl"
#include "common/receiver_normal.glsl"
#include "common/ray_origin.glsl"
#include "common/sun_sample.glsl"
#include "common/tile_list.glsl"
#include "common/tiles.glsl"
#include "common/reuse_words.glsl"
#include "classification/beam_query.glsl"

ivec2 pixel_of_bit(ivec2 tile, uint bit) { return tile * TILE + ivec2(bit & 7u, bit >> 3); }

// Whether the surface at a pixel itself blocks none of the rays; what else does is the scene's to say.
bool surface_lets_rays_out(ivec2 p) {
    const vec3 n = decode_receiver_normal(imageLoad(receiver_normal, p).xy);
    return cap_leaves_surface(n, sun.to_sun, sun.angular_radius);
}

// Ahead of what may be looked through, about which rays ask: from the surface a beam, whose rounding is larger than a start's offset,
// met its own floor.
vec3 start_of(ivec2 p) { return ray_origin(p, decode_receiver_normal(imageLoad(receiver_normal, p).xy), sun.to_sun); }

// The beam of the pixels in `mask`, and where in it their rays start.
// `open`: no surface blocks its own rays.
void make_beam(ivec2 tile, uint mask, out Cone cone, out Starts starts, out bool open) {
    open = true;
    const mat3 frame = sun_frame(sun.to_sun);
    const vec3 origin = start_of(pixel_of_bit(tile, uint(findLSB(mask))));
    // A plane through three of the starts, far apart; where there are none the axes of the frame will do.
    const uint first_row = mask & (0xffu << (uint(findLSB(mask)) & 24u)), last_row = mask & (0xffu << (uint(findMSB(mask)) & 24u));
    const vec3 last = (start_of(pixel_of_bit(tile, uint(findMSB(mask)))) - origin) * frame;
    const vec3 right = (start_of(pixel_of_bit(tile, uint(findMSB(first_row)))) - origin) * frame;
    const vec3 left = (start_of(pixel_of_bit(tile, uint(findLSB(last_row)))) - origin) * frame;
    const vec3 by_right = cross(last, right), by_left = cross(left, last);
    const vec3 normal = dot(by_right, by_right) > dot(by_left, by_left) ? by_right : by_left;
    mat3 axes = mat3(1.0);
    if (dot(normal, normal) > 0.0) {
        axes[0] = normalize(last);
        axes[2] = normalize(normal);
        axes[1] = cross(axes[2], axes[0]);
    }
    vec3 lo = vec3(1e38), hi = vec3(-1e38), box_lo = vec3(1e38), box_hi = vec3(-1e38);
    for (uint i = 0u; i < 32u; ++i)
        if ((mask >> i & 1u) != 0u) {
            const vec3 p = (start_of(pixel_of_bit(tile, i)) - origin) * frame;
            lo = min(lo, p);
            hi = max(hi, p);
            box_lo = min(box_lo, p * axes);
            box_hi = max(box_hi, p * axes);
            open = open && surface_lets_rays_out(pixel_of_bit(tile, i));
        }
    const vec3 base = vec3(0.5 * (lo.xy + hi.xy), lo.z);
    const float rounding = CONE_ROUNDING * (taxicab(lo) + taxicab(hi));
    const vec3 half_box = 0.5 * (box_hi - box_lo) + rounding;
    cone = Cone(origin + frame * base, frame, tan(sun.angular_radius), 0.5 * length(hi.xy - lo.xy) + rounding);
    starts = Starts(axes * (0.5 * (box_lo + box_hi)) - base, axes[0] * half_box.x, axes[1] * half_box.y, axes[2] * half_box.z);
}

// Frames between two beams of a tile that was not decided: beside one that was, where what is proved grows, and elsewhere.
const uint NEAR_TURN = 8u, FAR_TURN = 64u;
const uint COMPANY = 4u;  // a walk is worth its while where one of so many tiles side by side was decided

bool was_proved(ivec2 tile) {
    const ivec2 before = tile_before(tile);
    return all(greaterThanEqual(tile, ivec2(0))) && all(lessThan(tile, tile_grid())) &&
           (proved_before[tile_word(before, frame.prev_size)] & tile_bit(before)) != 0u;
}

// Tiles of a row take their turns by eights: most often they are the lanes of a subgroup, which waits for the slowest of them.
// For that reason too one tile that was decided among many that were not is no good reason for a walk. Who shares a subgroup in
// fact, which is another matter in every run, must not show: a tile that is proved has no rays whose blockers could be known.
bool in_company(ivec2 tile) {
    const ivec2 before = tile_before(tile);
    const uint eight = proved_before[tile_word(before, frame.prev_size)] >> uint(before.x & 24) & 0xffu;
    return uint(bitCount(eight)) * COMPANY >= 8u;
}

bool worth_a_beam(ivec2 tile, bool listed) {
    if (!listed || !HAS_PROVED_BEFORE) return listed;
    const bool again = was_proved(tile) && in_company(tile);
    const uint turn = uint(tile.x >> 3) + uint(tile.y) * 5u + frame.frame_index;
    // Of another size, other tiles were proved.
    if ((frame.flags & FRAME_RESET) != 0u || frame.prev_size != frame.size || turn % FAR_TURN == 0u || again) return true;
    return turn % NEAR_TURN == 0u &&
           (was_proved(tile + ivec2(-1, 0)) || was_proved(tile + ivec2(1, 0)) || was_proved(tile + ivec2(0, -1)) ||
            was_proved(tile + ivec2(0, 1)));
}

// Of a tile that needs none now, for the frame in which it needs one again.
void hand_on_proof(ivec2 tile) {
#if HAS_PROVED
    if (HAS_PROVED_BEFORE && was_proved(tile)) atomicOr(proved[tile_word(tile)], tile_bit(tile));
#endif
}

void main() {
    const uint index = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    const bool listed = index < candidate_args[3];
    uvec4 record = uvec4(0u);
    if (listed) record = candidates[index];
    const ivec2 tile = tile_of(record);
    if (HAS_REUSE_WORDS && listed)
        if (reuse_words[tile_index(tile)] == REUSED) {
            record.y = 0u;
            hand_on_proof(tile);
        }
    const uint mask = record.y;

    bool lit = false, shadowed = false;
    const bool tried = worth_a_beam(tile, mask != 0u);
    if (tried) {
        Cone cone;
        Starts starts;
        bool open_surface;
        make_beam(tile, mask, cone, starts, open_surface);
        Walk walk = beam_walk(cone, starts);
        const bool finished = walk_tree(walk);
        shadowed = walk.covered;
        lit = finished && walk.clean && !walk.covered && open_surface;
        if (shadowed) preloaded_hits[tile_index(tile)] |= mask;
    }
#if HAS_PROVED
    if (lit || shadowed) atomicOr(proved[tile_word(tile)], tile_bit(tile));
#endif
    const bool open = mask != 0u && !lit && !shadowed;
    append_tile(open, record);
    count_lit(lit ? uint(bitCount(mask)) : 0u);
    count_shadowed(shadowed ? uint(bitCount(mask)) : 0u);
    count_unknown(open ? uint(bitCount(mask)) : 0u);
    count_tiles_tried(tried ? 1u : 0u);
    count_tiles_listed(open ? 1u : 0u);
}
