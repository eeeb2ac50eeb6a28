// SPDX-License-Identifier: MIT
// The nearest triangle on a ray by its number in the scene, by whichever backend the node has.
//
// Includer declares: what common/bvh.glsl or common/ray_query.glsl asks for; uniform usamplerBuffer surfaces.
#if BACKEND == BACKEND_RAY_QUERY
#include "common/ray_query.glsl"
#else
#include "common/bvh.glsl"
#include "reflections/bvh_closest.glsl"
#endif

struct ClosestHit {
    bool found;
    float t;
    uint triangle;
};

uint word_of_surfaces(uint first_texel, uint word) { return texelFetch(surfaces, int(first_texel + (word >> 2)))[word & 3u]; }

// `direction` is finite and of any length but zero, the unit of t; 0 <= t_min.
ClosestHit closest_hit(vec3 origin, vec3 direction, float t_min, float t_max) {
    const uvec4 places = texelFetch(surfaces, 0);
#if BACKEND == BACKEND_RAY_QUERY
    if (!(t_min < t_max)) return ClosestHit(false, t_max, 0u);
    rayQueryEXT query;
    rayQueryInitializeEXT(query, scene_tlas, HAS_SCENE_ALPHA ? 0u : gl_RayFlagsOpaqueEXT, 0xFFu, origin, t_min, direction, t_max);
    while (rayQueryProceedEXT(query))
        if (HAS_SCENE_ALPHA && ray_query_alpha_blocks(query)) rayQueryConfirmIntersectionEXT(query);
    if (rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionNoneEXT) return ClosestHit(false, t_max, 0u);
    const uint instance = uint(rayQueryGetIntersectionInstanceIdEXT(query, true));
    return ClosestHit(true, rayQueryGetIntersectionTEXT(query, true),
                      word_of_surfaces(places.y, instance) + uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, true)));
#else
    const BvhHit hit = bvh_closest(origin, direction, t_min, t_max);
    return ClosestHit(hit.found, hit.t, hit.found ? word_of_surfaces(places.x, hit.leaf * 2u + hit.which) : 0u);
#endif
}
