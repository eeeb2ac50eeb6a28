// SPDX-License-Identifier: MIT
// Whether the viewer looks through a triangle at the start of a pixel's way to a light: then the pixel's centre is past the end of its own
// triangle (ray_offset.glsl), whose plane goes on below this one that rises there. docs/coverage.md#the-receivers-own-surface.
//
// Includer has common/camera.glsl and declares: block scene; SHARED_VIEWER, where it calls see_viewer() before the first question, with a barrier on a GPU.
#ifndef LOOKED_THROUGH_GLSL
#define LOOKED_THROUGH_GLSL

// Where the viewer is, and half a step of the rasteriser's grid per metre of the way to it; of an orthographic view the way, and less that in metres.
vec4 viewer_now() {
    const float grid = frame.grid_px * frame.pixel_angle;
    return (frame.flags & FRAME_ORTHOGRAPHIC) != 0u ? vec4(frame.world_from_view[2], -grid) : vec4(scene.camera_from_origin, grid);
}

#ifndef SHARED_VIEWER
vec4 seen_from() { return viewer_now(); }
#else
#if CLASS_CPU
vec4 viewer;
#else
shared vec4 viewer;  // of scalar registers a GPU has few
#endif

void see_viewer() {
    if (CLASS_CPU == 1 || gl_LocalInvocationIndex == 0u) viewer = viewer_now();
}
vec4 seen_from() { return viewer; }
#endif

// How far inside of an edge the viewer sees what lies at 0, metres; the edge's ends in the order of a triangle that faces the viewer.
float inside_m(vec3 from, vec3 to, vec3 to_viewer) {
    const vec3 outwards = cross(to - from, to_viewer);
    return dot(from, outwards) * inversesqrt(max(dot(outwards, outwards), 1e-37));
}

// What rises little is looked through by all of the grid, since it may not be the triangle that a ray meets.
const float GRIDS = 1.5, RISES_LITTLE = 0.25, LEAST_GRIDS = 0.1;

// Deeper inside an outline than that can have moved lies what is behind a triangle that is not drawn, as of a wall that is seen from its back:
// it is in that one's shadow. Seen along the surface, what rounding lifts a start by (ray_offset.glsl) is as deep. Where depth is of a moved
// triangle, a surface shows also where it is behind one that pierces it, however deep.
const float LIFT = 1.5 * 3.0 * 1.1920929e-7, ANY = 1e6;
float most_inside_m(vec3 start, vec3 to_viewer, float grid_m, bool orthographic) {
    const float grids = frame.snap_px > 0.0 || orthographic ? ANY : GRIDS;
    return grids * grid_m + LIFT * (dot(abs(start) + abs(to_viewer), vec3(1.0)) + length(to_viewer));
}

// `beyond_edge_m`: how far the start may lie past the end of what it is on.
bool is_looked_through(vec3 start, float beyond_edge_m, vec3 a, vec3 b, vec3 c) {
    const vec3 n = cross(b - a, c - a), to_a = a - start, to_b = b - start, to_c = c - start;
    const float above = dot(n, to_a), depth = abs(above) * inversesqrt(max(dot(n, n), 1e-37));
    if (!(depth <= beyond_edge_m)) return false;
    const vec4 viewed = seen_from();
    const vec3 to_viewer = viewed.xyz - (viewed.w < 0.0 ? vec3(0.0) : start);
    const float grid_m = viewed.w < 0.0 ? -viewed.w : viewed.w * length(to_viewer), side = above < 0.0 ? -1.0 : 1.0;
    const float rise = depth / max(RISES_LITTLE * beyond_edge_m, 1e-30);
    const float inside = min(min(side * inside_m(to_a, to_b, to_viewer), side * inside_m(to_b, to_c, to_viewer)), side * inside_m(to_c, to_a, to_viewer));
    return side * dot(n, to_viewer) > 0.0 && inside >= -grid_m * max(GRIDS * (1.0 - rise), LEAST_GRIDS) &&
           inside <= most_inside_m(start, to_viewer, grid_m, viewed.w < 0.0);
}
#endif
