// SPDX-License-Identifier: MIT
// Shadow rays of undecided pixels: one workgroup per listed tile. Its rays are dealt out to the lanes without gaps, so that a
// tile of few undecided pixels costs no more than their rays. Where a tile remembers what blocked it, rays try that first.
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
#include "common/rounded.glsl"
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

#if HAS_FRACTION
const uint RAYS = RAYS_PER_PIXEL;
shared uint reach_sun[32];  // rays of the pixel with this number
#else
const uint RAYS = 1u;
#endif

// For whoever counts this pixel's ray as a neighbour's.
void keep_point(ivec2 p, uint point) {
#if HAS_RAY_POINTS
    ray_points[uint(p.y) * frame.size.x + uint(p.x)] = point;
#endif
}

// Of the k-th ray of a pixel. The first, whose point is kept, is the one that is cast where there is no other: who reads the
// hit words knows where it went.
vec3 ray_direction(ivec2 p, uint k) {
#if HAS_BLUE_NOISE
    if (SAMPLING == SAMPLING_PUBLISHED) {
        const vec2 u = fract(noise_published(p, frame.frame_index, params.seed) + noise_unit(noise_step(k, RAYS)));
        if (k == 0u) keep_point(p, pack_point(concentric_disc(u)));
        return sun_direction_published(sun.to_sun, sun.angular_radius, u);
    }
    const vec2 point = sun_point(p, frame.frame_index, params.seed, k, RAYS);
    if (k == 0u) keep_point(p, pack_point(point));
    return sun_direction_through(sun.to_sun, sun.angular_radius, point);
#else
    keep_point(p, 0u);  // the middle of a sun that is a point
    return sun.to_sun;
#endif
}

// From the far end of a bounded ray to the surface: what stands near the sun's side is met first. The start and what the
// tree's boxes and triangles make of it round in the far end's digits, which moves the ray across; raised by as much, it
// still ends above the surface that it belongs to.
const float FAR_ULPS = 8.0 * 1.1920929e-7;  // 2^-23

struct ShadowRay {
    vec3 origin, direction;
    float t_min, t_max;
    bool reversed;
    float far;           // of a reversed ray: where it starts, along the ray that it stands for
    bool into_surface;   // the surface itself hides the sun
};

ShadowRay shadow_ray(ivec2 p, uint k, float t_min, float t_max) {
    const float z = imageLoad(view_depth, p).x;
    const vec3 relative = position(p, z);
    const vec3 n = decode_receiver_normal(imageLoad(receiver_normal, p).xy);
    const vec3 in_scene = relative + scene.camera_from_origin;
    const vec3 origin = in_scene + n * offset_m(p, z, n, relative, in_scene);
    const vec3 direction = ray_direction(p, k);
    if (ORIGIN == ORIGIN_PUBLISHED) t_min = max(t_min, PUBLISHED_T_MIN_M);
    const bool into_surface = ORIGIN != ORIGIN_PUBLISHED && points_into_surface(n, direction);
    if (!REVERSE || t_max >= WHOLE_RAY_M) return ShadowRay(origin, direction, t_min, t_max, false, 0.0, into_surface);
    const vec3 reach = abs(origin) + t_max * abs(direction);
    const vec3 start = origin + n * (FAR_ULPS * (reach.x + reach.y + reach.z)) + direction * t_max;
    return ShadowRay(start, -direction, 0.0, t_max - t_min, true, t_max, into_surface);
}

float metres_along(ShadowRay ray, float t) { return ray.reversed ? ray.far - t : t; }

#if HAS_BLOCKING_LEAVES && BACKEND != BACKEND_RAY_QUERY
#define REMEMBERS 1
#include "common/blocking_leaves.glsl"
#else
#define REMEMBERS 0
#endif

// A tile's pixels are numbered as pixel_of_lane() has them. A subgroup takes a share of them, and no other looks at it, so
// that nothing here waits for a workgroup; on a software device, where waiting costs as much as several rays, a subgroup is one.
void main() {
    uvec4 record;
    if (!listed_tile(record)) return;  // the whole workgroup
    const ivec2 tile = tile_of(record);
    const float t_min = uintBitsToFloat(record.z), t_max = uintBitsToFloat(record.w);
    const uint lanes = gl_WorkGroupSize.x / gl_NumSubgroups, lane = gl_SubgroupInvocationID;
    const uint share = 32u / gl_NumSubgroups, share_first = gl_SubgroupID * share, share_end = share_first + share;
    const uint wanted = lanes_of_pixels(record.y) & (share == 32u ? ~0u : (1u << share) - 1u << share_first);

    uint ended = 0u;  // pixels whose first ray hits
#if HAS_BLOCKERS
    BlockerSums sums = BlockerSums(0u, 0u, 0u), early = sums;  // of rays that walked, and of those that did not
#endif
#if REMEMBERS
    const uint slots = leaf_slots(share_first, share);
    const bool known = leaves_known(tile_index(tile), slots);
    uint useful = 0u, newest = NO_LEAF;
    if (known)
        for (uint first = share_first; first < share_end; first += lanes) {
            const uint number = first + lane;
            bool hit = false;
            float t = 0.0;
            if ((wanted >> number & 1u) != 0u) {
                const ShadowRay ray = shadow_ray(tile * TILE + pixel_of_lane(int(number)), 0u, t_min, t_max);
                hit = ray.into_surface;
                const BvhRay test = bvh_ray(ray.origin, ray.direction, ray.t_min, ray.t_max);
                if (!hit && blocked_by_known(tile_index(tile), slots, first >> 3, test, t, useful)) {
                    hit = true;
#if HAS_BLOCKERS
                    add_blocker(early, metres_along(ray, t));
#endif
                }
            }
            ended |= subgroupBallot(hit).x << first;
        }
    useful = subgroupOr(useful);
    const uint ended_early = uint(bitCount(ended));
#endif
#if HAS_FRACTION
    for (uint number = share_first + lane; number < share_end; number += lanes) reach_sun[number] = 0u;
    subgroupBarrier();
#endif

    // The rays that are left, a pixel's side by side, are dealt out to the lanes without gaps: a tile with few of them costs
    // no more than they do.
    const uint left = wanted & ~ended, ray_count = uint(bitCount(left)) * RAYS;
    uint walked = 0u;
    for (uint first = 0u; first < ray_count; first += lanes) {
        const uint index = first + lane;
        if (index < ray_count) {
            const uint number = bit_number(left, index / RAYS), k = index % RAYS;
            const ShadowRay ray = shadow_ray(tile * TILE + pixel_of_lane(int(number)), k, t_min, t_max);
            bool hit = ray.into_surface;
            if (!hit) {
                float t = 0.0;
#if REMEMBERS
                hit = occluded_by(ray.origin, ray.direction, ray.t_min, ray.t_max, t, newest);
#else
                hit = occluded_at(ray.origin, ray.direction, ray.t_min, ray.t_max, t);
#endif
#if HAS_BLOCKERS
                if (hit && k == 0u) add_blocker(sums, metres_along(ray, t));
#endif
            }
            if (hit && k == 0u) walked |= 1u << number;
#if HAS_FRACTION
            if (!hit) atomicAdd(reach_sun[number], 1u);
#endif
        }
    }
    walked = subgroupOr(walked);
#if REMEMBERS
    remember_leaves(tile_index(tile), slots, known, useful, ended_early, uint(bitCount(walked)), newest);
    count_ended_early(subgroupElect() ? ended_early : 0u);
#endif
    ended |= walked;
    if (subgroupElect() && ended != 0u) atomicOr(hits[tile_index(tile)], lanes_of_pixels(ended));
#if HAS_FRACTION
    subgroupBarrier();
    for (uint number = share_first + lane; number < share_end; number += lanes) {
        const uint reached = reach_sun[number];
        const bool disagree = (wanted >> number & 1u) != 0u && reached != 0u && reached != RAYS;
        if (disagree) imageStore(fraction, tile * TILE + pixel_of_lane(int(number)), vec4(float(reached) / float(RAYS)));
    }
#endif
#if HAS_BLOCKERS
    if (subgroupMax(sums.n) == 0u) sums = early;  // a walk looks near the light first: its distances are of one kind
    store_blockers(tile_index(tile), sums);
#endif
    count_rays(subgroupElect() ? uint(bitCount(wanted)) * RAYS : 0u);
}
