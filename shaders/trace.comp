// SPDX-License-Identifier: MIT
// Shadow rays of undecided pixels: one workgroup per listed tile. One ray: one lane per pixel. Several: the tile's rays are
// dealt out to the lanes without gaps, so that a tile of few undecided pixels costs no more than their rays.
// Sampling: points of the sun's disc per pixel and frame; see common/sun_sample.glsl and common/blue_noise.glsl. A sun
// that is a point takes no noise.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/receiver_normal.glsl"
#include "common/ray_origin.glsl"
#if HAS_BLUE_NOISE
#include "common/sun_point.glsl"
#endif
#include "common/tile_list.glsl"
#include "common/tiles.glsl"
#if HAS_BLOCKERS
#include "common/blockers.glsl"
#endif
#if BACKEND == BACKEND_RAY_QUERY
#include "common/ray_query.glsl"
#else
#include "common/bvh.glsl"
#endif

const float PUBLISHED_OFFSET_M = 1e-4;  // Hybrid Shadows sample: both constants are absolute lengths
const float PUBLISHED_T_MIN_M = 4e-2;

float offset_m(ivec2 p, float z, vec3 n, vec3 relative, vec3 in_scene) {
    if (ORIGIN == ORIGIN_PUBLISHED) return PUBLISHED_OFFSET_M;
    return robust_offset_m(p, z, n, relative, in_scene);
}

// For whoever counts this pixel's ray as a neighbour's.
void keep_point(ivec2 p) {
#if HAS_RAY_POINTS && HAS_BLUE_NOISE
    imageStore(ray_points, p, uvec4(packSnorm2x16(sun_point(p, frame.frame_index, params.seed)), 0u, 0u, 0u));
#elif HAS_RAY_POINTS
    imageStore(ray_points, p, uvec4(0u));  // the middle of a sun that is a point
#endif
}

// Of the k-th ray of a pixel. The first is the one that is cast where there is no other: who reads the hit words knows
// where it went.
vec3 ray_direction(ivec2 p, uint k) {
#if HAS_FRACTION
    if (SAMPLING == SAMPLING_PUBLISHED)
        return sun_direction_published(sun.to_sun, sun.angular_radius,
                                       fract(noise_published(p, frame.frame_index, params.seed) + noise_unit(noise_step(k, RAYS_PER_PIXEL))));
    return sun_direction_through(sun.to_sun, sun.angular_radius, sun_point(p, frame.frame_index, params.seed, k, RAYS_PER_PIXEL));
#elif HAS_BLUE_NOISE
    if (SAMPLING == SAMPLING_PUBLISHED)
        return sun_direction_published(sun.to_sun, sun.angular_radius,
                                       noise_published(p, frame.frame_index, params.seed));
    return sun_direction_through(sun.to_sun, sun.angular_radius, sun_point(p, frame.frame_index, params.seed));
#else
    return sun.to_sun;
#endif
}

// From the far end of a bounded ray to the surface: what stands near the sun's side is met first. The start and what the
// tree's boxes and triangles make of it round in the far end's digits, which moves the ray across; raised by as much, it
// still ends above the surface that it belongs to.
const float FAR_ULPS = 8.0 * 1.1920929e-7;  // 2^-23

bool hits_reversed(vec3 origin, vec3 n, vec3 direction, float t_min, float t_max, inout float t_hit) {
    const vec3 far = abs(origin) + t_max * abs(direction);
    const vec3 start = origin + n * (FAR_ULPS * (far.x + far.y + far.z)) + direction * t_max;
    float from_start = t_max - t_hit;
    const bool found = occluded_at(start, -direction, 0.0, t_max - t_min, from_start);
    t_hit = t_max - from_start;
    return found;
}

// `t_hit` stays where it is the surface itself that hides the sun.
bool hits_something(ivec2 p, uint k, float t_min, float t_max, inout float t_hit) {
    const float z = imageLoad(view_depth, p).x;
    const vec3 relative = position(p, z);
    const vec3 n = decode_receiver_normal(imageLoad(receiver_normal, p).xy);
    const vec3 in_scene = relative + scene.camera_from_origin;
    const vec3 origin = in_scene + n * offset_m(p, z, n, relative, in_scene);
    const vec3 direction = ray_direction(p, k);
    if (ORIGIN == ORIGIN_PUBLISHED) t_min = max(t_min, PUBLISHED_T_MIN_M);
    else if (points_into_surface(n, direction)) return true;
    if (REVERSE && t_max < WHOLE_RAY_M) return hits_reversed(origin, n, direction, t_min, t_max, t_hit);
    return occluded_at(origin, direction, t_min, t_max, t_hit);
}

#if HAS_FRACTION
shared uint lane_of[32];     // of the tile's undecided pixels, one after the other
shared uint reach_sun[32];   // rays of the pixel with this lane
shared uint first_rays_hit;  // pixels by their bits
#if HAS_BLOCKERS
shared float first_ray_t[32];
#endif

void main() {
    uvec4 record;
    if (!listed_tile(record)) return;  // the whole workgroup
    const ivec2 tile = tile_of(record);
    const uint lane = gl_LocalInvocationIndex;
    const uint wanted = lanes_of_pixels(record.y), ray_count = uint(bitCount(wanted)) * RAYS_PER_PIXEL;
    const bool mine = (wanted >> lane & 1u) != 0u;
    if (lane == 0u) first_rays_hit = 0u;
    if (mine) lane_of[bitCount(wanted & ((1u << lane) - 1u))] = lane;
    reach_sun[lane] = 0u;
#if HAS_BLOCKERS
    first_ray_t[lane] = 0.0;
#endif
    barrier();
    for (uint first = 0u; first < ray_count; first += 32u) {
        const uint index = first + lane;
        if (index < ray_count) {
            const uint k = index % RAYS_PER_PIXEL, owner = lane_of[index / RAYS_PER_PIXEL];
            const ivec2 in_tile = pixel_of_lane(int(owner));
            float t_hit = 0.0;
            if (k == 0u) keep_point(tile * TILE + in_tile);
            const bool hit = hits_something(tile * TILE + in_tile, k, uintBitsToFloat(record.z), uintBitsToFloat(record.w), t_hit);
            if (!hit) atomicAdd(reach_sun[owner], 1u);
            if (hit && k == 0u) {
                atomicOr(first_rays_hit, pixel_bit(in_tile));
#if HAS_BLOCKERS
                first_ray_t[owner] = t_hit;
#endif
            }
        }
    }
    barrier();
    if (lane == 0u && first_rays_hit != 0u) atomicOr(hits[tile_index(tile)], first_rays_hit);
    const uint reached = reach_sun[lane];
    const bool disagree = mine && reached != 0u && reached != RAYS_PER_PIXEL;
    if (disagree) imageStore(fraction, tile * TILE + pixel_of_lane(int(lane)), vec4(float(reached) / float(RAYS_PER_PIXEL)));
#if HAS_BLOCKERS
    add_blockers(tile_index(tile), first_ray_t[lane] > 0.0, first_ray_t[lane]);
#endif
    count_rays(lane == 0u ? ray_count : 0u);
}
#else
void main() {
    uvec4 record;
    if (!listed_tile(record)) return;  // the whole workgroup
    const int lane = int(gl_LocalInvocationIndex);
    const ivec2 in_tile = pixel_of_lane(lane);
    const ivec2 tile = tile_of(record);
    const uint bit = pixel_bit(in_tile);
    const bool wanted = (record.y & bit) != 0u;

    uint hit = 0u;
    float t_hit = 0.0;
    if (wanted) keep_point(tile * TILE + in_tile);
    if (wanted && hits_something(tile * TILE + in_tile, 0u, uintBitsToFloat(record.z), uintBitsToFloat(record.w), t_hit))
        hit = bit;
    const uint word = subgroupOr(hit);
    if (subgroupElect() && word != 0u) atomicOr(hits[tile_index(tile)], word);
#if HAS_BLOCKERS
    add_blockers(tile_index(tile), hit != 0u && t_hit > 0.0, t_hit);
#endif
    count_rays(wanted ? 1u : 0u);
}
#endif
