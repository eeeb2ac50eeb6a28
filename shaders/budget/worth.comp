// SPDX-License-Identifier: MIT
// What further rays are worth, pixel by pixel: where the first ones disagree runs the edge of a shadow, and the previous frame knows
// which of the pixels beside it lie in penumbra. Sorts pixels into classes by the error to be expected of them, and counts what further
// rays would gain over the whole image. An invocation owns a tile; the pixels to be looked at are dealt out among all.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/guide_normal.glsl"
#include "common/rounded.glsl"
#include "common/tiles.glsl"
#include "common/tile_rows.glsl"
#define READS_BLOCKERS
#include "common/blockers.glsl"
#include "common/sun_sample.glsl"
const bool MANY_RAYS = true;
#include "common/dithered.glsl"
#include "common/own_rays.glsl"
#include "common/shadow_state.glsl"
#include "common/sun_change.glsl"
#include "common/light.glsl"
#include "common/light_axes.glsl"
#include "common/light_change.glsl"
#include "budget/nearest_place.glsl"
#include "budget/nearest_past.glsl"
#include "budget/ray_worth.glsl"
#include "budget/expected_error.glsl"
#include "budget/proved_tile.glsl"

const uint TILES = gl_WorkGroupSize.x * gl_WorkGroupSize.y;
shared uint class_masks[TILES * CLASSES];
shared float neighbours_worth[TILES];
shared uint asked_count;
// In 16 bits each, so that many groups fit onto a GPU: 32 tile + pixel, and above whether unlike rays are next to it, or two pixels away.
shared uint asked[TILES * 16u];

const int RING = 2, ROWS = TILE.y + 2 * RING;

uint wider(uint row) { return row | row << 1 | row >> 1; }

// Which of a tile's pixels have unlike rays next to them, and which two pixels away.
uvec2 near_an_edge(ivec2 tile) {
    const ivec2 grid = tile_grid();
    uint lit[ROWS], dark[ROWS];
    [[unroll]] for (int ty = -1; ty <= 1; ++ty) {
        uvec3 l, d;
        [[unroll]] for (int tx = 0; tx < 3; ++tx) {
            const ivec2 at = tile + ivec2(tx - 1, ty), inside = clamp(at, ivec2(0), grid - 1);
            const uint traced = at == inside ? ray_words[tile_index(inside)] : 0u, hit = hits[tile_index(inside)];
            l[tx] = traced & ~hit;
            d[tx] = traced & hit;
        }
        [[unroll]] for (int y = max(0, -RING - TILE.y * ty); y < min(TILE.y, TILE.y + RING - TILE.y * ty); ++y) {
            lit[TILE.y * ty + y + RING] = row_of(l, y);
            dark[TILE.y * ty + y + RING] = row_of(d, y);
        }
    }
    uvec2 masks = uvec2(0u);
    [[unroll]] for (int y = 0; y < TILE.y; ++y) {
        uint l = lit[y + 1] | lit[y + 2] | lit[y + 3], d = dark[y + 1] | dark[y + 2] | dark[y + 3];
        masks.x |= (wider(l) & wider(d) & 0xff00u) >> 8 << 8 * y;
        l |= lit[y] | lit[y + 4];
        d |= dark[y] | dark[y + 4];
        masks.y |= (wider(wider(l)) & wider(wider(d)) & 0xff00u) >> 8 << 8 * y;
    }
    return masks;
}

ivec2 tile_of_lane(uint lane) {
    return ivec2(gl_WorkGroupID.xy * gl_WorkGroupSize.xy) + ivec2(lane % gl_WorkGroupSize.x, lane / gl_WorkGroupSize.x);
}

// Whether any of a workgroup's tiles has a ray. Each subgroup asks for itself, so that none waits for another.
bool anything_traced() {
    uint words = 0u;
    for (uint i = gl_SubgroupInvocationID; i < TILES; i += TILES / gl_NumSubgroups)
        words |= ray_words[tile_index(min(tile_of_lane(i), tile_grid() - 1))];
    return subgroupOr(words) != 0u;
}

// What further rays of so many pixels of a tile would gain. Tiles under one light alone are counted together.
void count_gains(uint c, uint pixels, uint steps_less) {
    if (!HAS_LIGHT_SHARES) {
        const uint all = subgroupAdd(pixels);
        pixels = subgroupElect() ? all : 0u;
    }
    if (pixels != 0u)
        for (uint level = 0u; level + 1u < LEVELS; ++level)
            atomicAdd(gains[gain_bin(EXPECTED[c], level, steps_less)], pixels * (RAYS_AT[level + 1u] - RAYS_AT[level]));
}

void main() {
    const uint lane = gl_LocalInvocationIndex;
    const ivec2 tile = tile_of_lane(lane), grid = tile_grid();
    const bool in_grid = all(lessThan(tile, grid));
    if (!anything_traced()) {
        if (in_grid) classes[tile_index(tile)] = uvec4(0u);
        return;
    }
    const uint traced = in_grid ? ray_words[tile_index(tile)] : 0u;
    if (lane == 0u) asked_count = 0u;
    for (uint c = 0u; c < CLASSES; ++c) class_masks[CLASSES * lane + c] = 0u;
    for (uint i = 0u; i < 16u; ++i) asked[TILES * i + lane] = 0u;
    group_barrier();
    if (traced != 0u && !is_proved(tile)) {
        const uvec2 edges = near_an_edge(tile) & traced;
        const uvec4 past = known[tile_index(tile)];
        const uint contradicted = ~past.x & (past.z ^ ~hits[tile_index(tile)]);
        uint left = (edges.y | past.x | contradicted) & traced;
        uint at = atomicAdd(asked_count, uint(bitCount(left)));
        for (; left != 0u; left &= left - 1u) {
            const uint i = uint(findLSB(left));
            const uint entry = 32u * lane + i | (edges.x >> i & 1u) << 15 | (edges.y >> i & 1u) << 14;
            atomicOr(asked[at >> 1], entry << 16 * (at & 1u));
            ++at;
        }
        neighbours_worth[lane] = 0.0;
        if (edges.x != 0u) {
            const int i = findLSB(edges.x);
            neighbours_worth[lane] = worth_of_neighbours(tile, imageLoad(view_depth, tile * TILE + ivec2(i & 7, i >> 3)).x);
        }
    }
    group_barrier();
    ViewRays before;
    if (HAS_MOTION) before = previous_rays(mat3(1.0));
    for (uint i = lane; i < asked_count; i += TILES) {
        const uint entry = asked[i >> 1] >> 16 * (i & 1u) & 0xffffu, of = (entry & 0x3fffu) >> 5, number = entry & 31u;
        const ivec2 p = tile_of_lane(of) * TILE + ivec2(number & 7u, number >> 3);
        const bool lit = (hits[tile_index(p / TILE)] >> number & 1u) == 0u;
        const float error = expected_error(p, 2u - (entry >> 15) - (entry >> 14 & 1u), lit, neighbours_worth[of], before);
        uint c = 0u;
        while (c < CLASSES && error < LEAST_OF[c]) ++c;
        if (c < CLASSES) atomicOr(class_masks[CLASSES * of + c], 1u << number);
    }
    group_barrier();
    uvec4 masks;
    const uint steps_less = HAS_LIGHT_SHARES && in_grid ? light_shares[tile_index(tile)] : 0u;
    [[unroll]] for (uint c = 0u; c < CLASSES; ++c) {
        masks[c] = class_masks[CLASSES * lane + c];
        count_gains(c, uint(bitCount(masks[c])), steps_less);
    }
    if (in_grid) classes[tile_index(tile)] = masks;
}
