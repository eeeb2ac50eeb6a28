// SPDX-License-Identifier: MIT
// Exact coverage: instead of rays, each pixel that nothing proves lit or shadowed walks the tree once with the cone to its light and
// unites what the triangles hide of it, as a mask of samples: none hidden is lit, all is shadowed, and between lies the visibility. No
// noise, so no denoiser and no past. One workgroup per listed tile. docs/coverage.md.
#extension GL_KHR_shader_subgroup_shuffle : require
#include "node.glsl"
#if HAS_GIVEN_UP
#define APPENDS_TILES
#endif
#define LISTED_TILES candidates
#define LISTED_ARGS candidate_args
#include "common/camera.glsl"
#include "common/receiver_normal.glsl"
#include "common/ray_origin.glsl"
#include "visibility/sun_point.glsl"
#include "common/light.glsl"
#include "common/tile_list.glsl"
#include "common/tiles.glsl"
#include "visibility/tile_share.glsl"
#define SHARED_STACK
#define ASKS_VIEWER
#define SHARED_VIEWER
#include "common/bvh.glsl"
#include "common/cone_slabs.glsl"
#include "visibility/light_mask.glsl"
#include "visibility/leaf_cover.glsl"
#include "visibility/seen_light.glsl"
#if HAS_GIVEN_UP
#define WALK_BUDGET BUDGET
#endif
#include "visibility/light_walk.glsl"

shared ConeSlabs sun_slabs;  // on a GPU, whose registers are few

ConeSlabs slabs_to(SeenLight seen) {
    if (ON_CPU || HAS_LIGHT) return seen.slabs;
    return sun_slabs;
}

#if HAS_GIVEN_UP
shared uint tile_rest;  // pixels left to rays

// A tile most of whose pixels had to be given up goes straight to rays, but in its turn is tried again.
const uint TURN = 16u;

bool hopeless(ivec2 tile) {
    const uint turn = uint(tile.x) + uint(tile.y) * 5u + frame.frame_index;
    const ivec2 before = tile_before(tile);
    return (frame.flags & FRAME_RESET) == 0u && turn % TURN != 0u &&
           (given_up_before[tile_word(before, frame.prev_size)] & tile_bit(before)) != 0u;
}
#endif

void main() {
    uvec4 record;
    if (!listed_tile(record)) return;  // the whole workgroup
    const ivec2 tile = tile_of(record);
    uint asked = record.y;
#if HAS_GIVEN_UP
    if (gl_LocalInvocationIndex == 0u) tile_rest = 0u;
    if (hopeless(tile)) asked = 0u;
    group_barrier();
#endif
    const uint turn_of_noise = CYCLE == 0u ? frame.frame_index : frame.frame_index % max(CYCLE, 1u);
    const TileShare share = tile_share(asked);
    const uint pixel_count = uint(bitCount(share.wanted));
    const mat3 axes = sun_frame(sun.to_sun);
    const LightShape sun_as_seen = sun_shape(sun.angular_radius);
    const ConeSlabs slabs = cone_slabs(axes[2], sun_as_seen.radius, 0.0);
    see_viewer();
    if (!ON_CPU) {
        if (!HAS_LIGHT && gl_LocalInvocationIndex == 0u) sun_slabs = slabs;
        group_barrier();
    }

    uint shadowed = 0u, partly = 0u, done = 0u, steps_taken = 0u;
    for (uint first = 0u; first < pixel_count; first += share.lanes) {
        const bool own = first + share.lane < pixel_count;
        const uint number = wanted_number(share, own ? first + share.lane : first);
        const ivec2 p = tile * TILE + pixel_of_lane(int(number));
        const vec2 noise = noise_unit(noise_fixed(p, turn_of_noise, params.seed));
        const vec3 n = decode_receiver_normal(imageLoad(receiver_normal, p).xy);
        SeenLight seen;
        if (HAS_LIGHT)
            seen = seen_light(ray_start(p, n), noise);
        else
            seen = seen_sun(ray_start(p, n), axes, sun_as_seen, slabs, noise);
        LightMask hidden = below_horizon(seen, n);
        const Walk walk = walk_to_light(seen, own, hidden);
        const bool finished = walk.ended;
        hidden = with_samples_by_ray(seen, HAS_LIGHT ? 1.0 : WHOLE_RAY_M, finished && last_samples(hidden), hidden);
        const uint count = mask_count(hidden);
        steps_taken += own ? walk.steps : 0u;
        if (finished) done |= 1u << number;
        const bool told = HAS_GIVEN_UP != 0 ? finished : own;
        if (told && count == LIGHT_SAMPLES) shadowed |= 1u << number;
        if (told && count != LIGHT_SAMPLES && count != 0u) {
            partly |= 1u << number;
            store_coverage(p, vec4(float((LIGHT_SAMPLES - count) * (256u / LIGHT_SAMPLES)) / 255.0));
        }
    }
    shadowed = subgroupOr(shadowed);
    if (subgroupElect() && shadowed != 0u) atomicOr(preloaded_hits[tile_index(tile)], lanes_of_pixels(shadowed));
    count_pixels(subgroupElect() ? pixel_count : 0u);
    count_shadowed(subgroupElect() ? uint(bitCount(shadowed)) : 0u);
    count_penumbra(uint(bitCount(partly)));
    count_steps(steps_taken);
    // Given up, or left undone where a driver ends loops (light_walk.glsl).
    const uint rest = share.wanted & ~subgroupOr(done);
#if HAS_UNEVEN
    const uint between = subgroupOr(partly) | rest;
    if (subgroupElect() && between != 0u) atomicOr(uneven[tile_index(tile)], lanes_of_pixels(between));
#endif
#if HAS_GIVEN_UP
    if (subgroupElect() && rest != 0u) atomicOr(tile_rest, lanes_of_pixels(rest));
    group_barrier();
    const bool leader = gl_LocalInvocationIndex == 0u;
    const uint left = tile_rest | record.y ^ asked;
    append_tile(leader && left != 0u, uvec4(record.x, left, record.zw));
    count_left(leader ? uint(bitCount(left)) : 0u);
#if HAS_UNEVEN
    if (leader && asked != record.y) atomicOr(uneven[tile_index(tile)], record.y);
#endif
    if (leader && 2 * bitCount(left) > bitCount(record.y)) atomicOr(given_up[tile_word(tile)], tile_bit(tile));
#else
    count_left(subgroupElect() ? uint(bitCount(rest)) : 0u);
#endif
}
