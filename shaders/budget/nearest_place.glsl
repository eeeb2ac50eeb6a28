// SPDX-License-Identifier: MIT
// The texel in which the previous frame showed the surface that a pixel shows. It is asked whether that was the same plane and face, as gather asks:
// whose past gather does not believe has to have a ray.
//
// Includer has camera.glsl and guide_normal.glsl and declares, where things move, the images motion, view_depth, guide_normal and the previous two.
#include "common/view_rays.glsl"
#include "common/surface_before.glsl"

const float SAME_PLANE_PX = 1.0;     // as gather's plane_tolerance is
const float STEP_PX = 0.2;           // above the plane: what rises so far may shade the point beside it
const float WHOLE_TEXEL = 0.02;      // px

struct NearestPlace {
    ivec2 texel;
    bool known, resampled, beside_step;  // PixelPast says what these are
};

// `before`: previous_rays(), where things move.
NearestPlace nearest_place(ivec2 p, ViewRays before) {
    if (!HAS_MOTION) return NearestPlace(p, pixels_have_pasts(), false, false);
    const vec3 moved = texelFetch(motion, p, 0).xyz;
    const Reprojection there = reproject(p, moved.xy);
    const vec2 at = there.uv * vec2(frame.prev_size) - 0.5, nearest = floor(at + 0.5);
    const bvec2 between = greaterThan(abs(at - nearest), vec2(WHOLE_TEXEL));
    const ivec2 q = clamp(ivec2(nearest), ivec2(0), ivec2(frame.prev_size) - 1);
    const float z = imageLoad(view_depth, p).x, was = imageLoad(view_depth_prev, q).x;
    const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
    Surface surface = Surface(off_plane(before, n, position(p, z)), SAME_PLANE_PX * pixel_span_m(z));
    follow(surface.plane, at, z + moved.z, q, was);
    const bool same_face = dot(n, decode_normal(imageLoad(guide_normal_prev, q))) > SAME_FACE;
    const bool known = (frame.flags & FRAME_RESET) == 0u && there.on_screen && was > 0.0 && same_face && shows(surface, vec2(q), was);
    const ivec2 beyond = q + ivec2(sign(at - nearest) * step(WHOLE_TEXEL, abs(at - nearest)));
    bool beside_step = false;
    for (int i = 0; i < 2; ++i) {
        const ivec2 beside = clamp(i == 0 ? ivec2(beyond.x, q.y) : ivec2(q.x, beyond.y), ivec2(0), ivec2(frame.prev_size) - 1);
        const float z_beside = imageLoad(view_depth_prev, beside).x;
        beside_step = beside_step || z_beside > 0.0 && metres_off(surface.plane, vec2(beside), z_beside) > STEP_PX * pixel_span_m(z);
    }
    return NearestPlace(q, known, any(between), beside_step);
}

// As a word: 14 bits for the way along each axis. Whoever came farther is not known.
const int FARTHEST_PX = 8191;
uint pack_place(ivec2 p, NearestPlace place) {
    const ivec2 way = place.texel - p;
    if (!place.known || any(greaterThan(abs(way), ivec2(FARTHEST_PX)))) return 0u;
    return 1u | (place.resampled ? 2u : 0u) | (place.beside_step ? 4u : 0u) | uint(way.x + FARTHEST_PX) << 3 | uint(way.y + FARTHEST_PX) << 17;
}
NearestPlace unpack_place(ivec2 p, uint word) {
    const bool known = word != 0u;
    const ivec2 way = ivec2(word >> 3 & 0x3fffu, word >> 17) - FARTHEST_PX;
    return NearestPlace(known ? p + way : p, known, (word & 2u) != 0u, (word & 4u) != 0u);
}
