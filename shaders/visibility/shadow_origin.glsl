// SPDX-License-Identifier: MIT
// Where the shadow rays of a pixel start, by either backend. Our own tree asks whether the viewer looks through what a ray meets at its start
// (common/looked_through.glsl); a driver's asks nobody, and its rays start ahead of all that may be.
//
// Includer has common/ray_origin.glsl and what that needs, the parameter backend, and common/bvh.glsl or common/ray_query.glsl after this.
#if BACKEND == BACKEND_RAY_QUERY
vec3 shadow_origin(RayStart start, vec3 n, vec3 to_sun) { return ray_origin(start, n, to_sun); }
vec3 shadow_origin_to(RayStart start, vec3 n, vec3 target) { return ray_origin_to(start, n, target); }
#else
#define ASKS_VIEWER
vec3 shadow_origin(RayStart start, vec3 n, vec3 to_sun) { return start.off_surface; }
vec3 shadow_origin_to(RayStart start, vec3 n, vec3 target) { return start.off_surface; }
#endif
