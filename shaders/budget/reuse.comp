// SPDX-License-Identifier: MIT
// What need not be found anew while the camera stands still. The mask of a tile follows from its receivers, the sun, and what casts
// shadows on them. So a tile is as it was in the frame that last had this jitter, where
// - camera, sun, jitter and all of its undecided pixels' depths are the same bits as then, of which a key of 64 bits is kept; and
// - since then no box of what has moved met the way to the sun of any receiver that the tile has shown, of which bounds are kept.
// What comes into view or leaves it changes depths; what moves out of sight and casts a shadow has a box.
// One lane per tile. docs/coverage.md.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/ray_offset.glsl"
#include "common/tiles.glsl"
#include "common/reuse_words.glsl"

// Of a tile in `tiles_seen`: a key of the camera and the sun; the least and the greatest corner of what it has shown, camera-relative;
// and of each turn a key of what it showed then.
const uint CORNERS = 2u, KEYS = 8u, WORDS = 40u;

// Bijective in `word`, so that no change of one word alone is missed.
uvec2 with_word(uvec2 key, uint word) {
    const uvec2 mixed = (key ^ word) * uvec2(0x9E3779B1u, 0x85EBCA77u);
    return mixed ^ mixed >> 15u;
}
uvec2 with_words(uvec2 key, vec4 values) {
    const uvec4 words = floatBitsToUint(values);
    return with_word(with_word(with_word(with_word(key, words.x), words.y), words.z), words.w);
}

// Of all that a mask follows from but the tile's own pixels and the jitter.
uvec2 key_of_view() {
    uvec2 key = uvec2(frame.size);
    for (int i = 0; i < 4; ++i) key = with_words(key, frame.clip_from_view[i]);
    for (int i = 0; i < 3; ++i) key = with_words(key, vec4(frame.world_from_view[i], 0.0));
    key = with_words(key, vec4(sun.to_sun, sun.angular_radius));
    return with_words(key, vec4(scene.camera_from_origin, frame.grid_px));
}

struct Bounds {
    vec3 lo, hi;
};

const Bounds NOTHING = Bounds(vec3(3e38), vec3(-3e38));

Bounds bounds_kept(uint at) {
    vec3 lo, hi;
    for (uint i = 0u; i < 3u; ++i) {
        lo[i] = uintBitsToFloat(tiles_seen[at + CORNERS + i]);
        hi[i] = uintBitsToFloat(tiles_seen[at + CORNERS + 3u + i]);
    }
    return Bounds(lo, hi);
}

void keep_bounds(uint at, Bounds bounds) {
    for (uint i = 0u; i < 3u; ++i) {
        tiles_seen[at + CORNERS + i] = floatBitsToUint(bounds.lo[i]);
        tiles_seen[at + CORNERS + 3u + i] = floatBitsToUint(bounds.hi[i]);
    }
}

// Nothing that was kept of the tile is true any more.
void forget(uint at) {
    for (uint i = 0u; i < JITTERS; ++i) {
        tiles_seen[at + KEYS + 2u * i] = 0u;
        tiles_seen[at + KEYS + 2u * i + 1u] = 0u;
    }
}

// What the tile's undecided pixels show, with where their rays may start.
Bounds look(ivec2 tile, uint undecided, inout uvec2 key) {
    Bounds bounds = NOTHING;
    float farthest = 0.0;
    for (int i = 0; i < 32; ++i)
        if ((undecided >> i & 1u) != 0u) {
            const ivec2 p = tile * TILE + ivec2(i & 7, i >> 3);
            const float z = imageLoad(view_depth, p).x;
            key = with_word(key, floatBitsToUint(z));
            const vec3 at = position(p, z);
            bounds.lo = min(bounds.lo, at);
            bounds.hi = max(bounds.hi, at);
            farthest = max(farthest, z);
        }
    const vec3 largest = max(abs(bounds.lo), abs(bounds.hi));
    const float start = most_offset_m(farthest, largest, largest + abs(scene.camera_from_origin));
    bounds.lo -= start;
    bounds.hi += start;
    return bounds;
}

// Whether anything on the way from the bounds to the sun's disc can lie in the box. At h metres along the sun's axis, the bounds moved
// by h * slope, of every slope that the disc has.
bool on_the_way(Bounds bounds, vec3 box_lo, vec3 box_hi) {
    const vec3 tilt = sqrt(max(1.0 - sun.to_sun * sun.to_sun, vec3(0.0)));
    const vec3 across = (tan(sun.angular_radius) * 1.0001 + 1e-6) * tilt;
    float near = 0.0, far = 3e38;
    for (int i = 0; i < 3; ++i) {
        // h * slope <= room, twice.
        const vec2 slope = vec2(sun.to_sun[i] - across[i], -sun.to_sun[i] - across[i]);
        const vec2 room = vec2(box_hi[i] - bounds.lo[i], bounds.hi[i] - box_lo[i]);
        for (int k = 0; k < 2; ++k) {
            if (slope[k] > 0.0) far = min(far, room[k] / slope[k]);
            if (slope[k] < 0.0) near = max(near, room[k] / slope[k]);
            if (slope[k] == 0.0 && room[k] < 0.0) far = -1.0;
        }
    }
    return near <= far * 1.00001;
}

bool touched(Bounds bounds) {
    if (bounds.lo.x > bounds.hi.x) return false;
    for (uint i = 0u; i < min(moved_boxes.count, MOST_MOVED_BOXES); ++i)
        if (on_the_way(bounds, moved_boxes.boxes[i].lo.xyz, moved_boxes.boxes[i].hi.xyz)) return true;
    return false;
}

void main() {
    const ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, tile_grid()))) return;
    const uint i = tile_index(tile), at = i * WORDS;
    const uvec2 view = key_of_view();
    const uint undecided = receiver_words[i] & ~decided_hits[i];
    uint word = NOT_KEPT;
    // A smaller frame in between has overwritten some tiles and left others as they were.
    if (frame.size != frame.prev_size || tiles_seen[at] != view.x || tiles_seen[at + 1u] != view.y) {
        tiles_seen[at] = view.x;
        tiles_seen[at + 1u] = view.y;
        keep_bounds(at, NOTHING);
        forget(at);  // what another view has left
        count_asked(undecided != 0u ? 1u : 0u);
    } else {
        uvec2 key = with_word(with_words(view, vec4(frame.jitter, 0.0, 0.0)), undecided);
        Bounds now = NOTHING;
        if (undecided != 0u) now = look(tile, undecided, key);
        key.x |= 1u;  // 0: nothing
        Bounds seen = bounds_kept(at);
        seen = Bounds(min(seen.lo, now.lo), max(seen.hi, now.hi));
        const bool changed = touched(seen);
        const uint turn = kept_turn(), own = at + KEYS + 2u * turn;
        const bool same = tiles_seen[own] == key.x && tiles_seen[own + 1u] == key.y && (whole_masks_prev[i] >> turn & 1u) != 0u;
        if (changed) forget(at);
        if (changed) seen = now;
        keep_bounds(at, seen);
        tiles_seen[own] = key.x;
        tiles_seen[own + 1u] = key.y;
        if (undecided != 0u) word = same && !changed ? REUSED : TO_KEEP;
        count_reused(word == REUSED ? 1u : 0u);
        count_asked(word == TO_KEEP ? 1u : 0u);
        count_touched(changed ? 1u : 0u);
    }
    reuse_words[i] = word;
}
