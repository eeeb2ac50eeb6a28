// SPDX-License-Identifier: MIT
// Shadow rays against an acceleration structure of the driver (VK_KHR_ray_query): the counterpart of common/bvh.glsl on
// the same triangles in the same frame. Which triangle is at an edge is the driver's to decide; nothing else differs.
//
// Includer declares: uniform accelerationStructureEXT scene_tlas; what common/scene_alpha.glsl needs.
#ifndef RAY_QUERY_GLSL
#define RAY_QUERY_GLSL
#include "common/scene_alpha.glsl"
// Runs of alpha-tested triangles are instances that are not opaque and carry the number of their first record.
#ifdef NEAREST_HIT
const uint ray_query_ends = gl_RayFlagsNoneEXT;
#else
const uint ray_query_ends = gl_RayFlagsTerminateOnFirstHitEXT;
#endif
const uint ray_query_flags = ray_query_ends | (HAS_SCENE_ALPHA ? 0u : gl_RayFlagsOpaqueEXT);

// Whether the candidate that a query has come to, which is not opaque, is there where the ray meets it. A macro: a query is
// no parameter.
#define ray_query_alpha_blocks(query)                                                                        \
    alpha_blocks(uint(rayQueryGetIntersectionInstanceCustomIndexEXT(query, false) +                          \
                      rayQueryGetIntersectionPrimitiveIndexEXT(query, false)),                               \
                 vec3(1.0 - rayQueryGetIntersectionBarycentricsEXT(query, false).x -                         \
                          rayQueryGetIntersectionBarycentricsEXT(query, false).y,                            \
                      rayQueryGetIntersectionBarycentricsEXT(query, false)))

// Whether anything lies on the ray between t_min and t_max; both sides of a triangle block. `direction` is finite and of
// any length but zero, the unit of t; 0 <= t_min. `t_hit` becomes where some such thing lies; without one it stays.
bool occluded_at(vec3 origin, vec3 direction, float t_min, float t_max, inout float t_hit) {
    if (!(t_min < t_max)) return false;  // an empty interval is not a valid ray
    rayQueryEXT query;
    rayQueryInitializeEXT(query, scene_tlas, ray_query_flags, 0xFFu, origin, t_min, direction, t_max);
    while (rayQueryProceedEXT(query))
        if (HAS_SCENE_ALPHA && ray_query_alpha_blocks(query)) rayQueryConfirmIntersectionEXT(query);
    const bool found = rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT;
    if (found) t_hit = rayQueryGetIntersectionTEXT(query, true);
    return found;
}

// .. of a pixel's ray, whose start has left the end of what it is on behind (visibility/shadow_origin.glsl).
bool occluded_from(vec3 start, float beyond_edge_m, vec3 direction, float t_min, float t_max, inout float t_hit) {
    return occluded_at(start, direction, t_min, t_max, t_hit);
}

bool occluded(vec3 origin, vec3 direction, float t_min, float t_max) {
    float unread = 0.0;
    return occluded_at(origin, direction, t_min, t_max, unread);
}
#endif
