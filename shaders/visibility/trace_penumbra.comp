// SPDX-License-Identifier: MIT
// One shadow ray per undecided pixel, as trace casts it, whose nearest hit says how wide the penumbra is there: what SIGMA
// takes. One workgroup per listed tile; nothing is shared.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/receiver_normal.glsl"
#include "common/ray_origin.glsl"
#include "common/round_store.glsl"
#include "common/tile_list.glsl"
#include "common/tiles.glsl"
#include "visibility/nearest_hit.glsl"
#include "visibility/sun_point.glsl"
#include "visibility/tile_share.glsl"

// Published values: 0 = turned away or touched by what hides the sun, 65504 = lit, between them the penumbra's radius.
const float LIT = 65504.0, WIDEST = 32768.0;

vec3 ray_direction(ivec2 p) {
    if (!HAS_BLUE_NOISE) return sun.to_sun;
    return sun_direction_through(sun.to_sun, sun.angular_radius, sun_point(p, frame.frame_index, params.seed));
}

// Metres; half of what the sun's radius spans at the blocker's distance.
float radius_behind(float distance_m) { return min(0.5 * distance_m * tan(sun.angular_radius), WIDEST); }

float penumbra_at(ivec2 p, float t_min, float t_max) {
    const vec3 n = decode_receiver_normal(imageLoad(receiver_normal, p).xy), direction = ray_direction(p);
    if (points_into_surface(n, direction)) return 0.0;
    float t = 0.0;
    return nearest_hit(shadow_ray_origin(p, n), direction, t_min, t_max, t) ? radius_behind(t) : LIT;
}

void main() {
    uvec4 record;
    if (!listed_tile(record)) return;  // the whole workgroup
    const TileShare share = tile_share(record.y);
    const uint ray_count = uint(bitCount(share.wanted));
    for (uint first = 0u; first < ray_count; first += share.lanes) {
        const uint index = first + share.lane;
        if (index < ray_count) {
            const ivec2 p = tile_of(record) * TILE + pixel_of_lane(int(wanted_number(share, index)));
            const float radius = penumbra_at(p, uintBitsToFloat(record.z), uintBitsToFloat(record.w));
            imageStore(penumbra, p, vec4(round_to(radius, HALF_BITS)));
        }
    }
    count_rays(subgroupElect() ? ray_count : 0u);
}
