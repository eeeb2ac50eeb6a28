// SPDX-License-Identifier: MIT
// What the previous frame knew of the surface that a pixel shows, by the nearest texel: enough to allot rays by, not to shade by. It is asked whether
// that showed the same plane and face, as gather asks: whose past gather does not believe has to have a ray.
//
// Includer has camera.glsl, guide_normal.glsl and shadow_state.glsl and declares the images history, view_depth and, where things move, motion, guide_normal
// and the previous two.
#include "common/view_rays.glsl"
#include "common/surface_before.glsl"

const float SURE_BELOW = 0.01;       // of 0 or of 1: no penumbra
const float SAME_PLANE_PX = 1.0;     // as gather's plane_tolerance is
const float STEP_PX = 0.2;           // above the plane: what rises so far may shade the point beside it
const float WHOLE_TEXEL = 0.02;      // px

struct PixelPast {
    bool known;       // else the other members mean nothing
    float visibility, count, residual;
    bool resampled;   // lay between texels
    bool beside_step; // and a texel around showed something above the surface, whose foot the point may be at
};

// `before`: previous_rays(), where things move.
PixelPast nearest_past(ivec2 p, ViewRays before) {
    ivec2 q = p;
    bool known = HAS_MOTION ? (frame.flags & FRAME_RESET) == 0u : pixels_have_pasts(), resampled = false, beside_step = false;
    if (HAS_MOTION) {
        const vec3 moved = texelFetch(motion, p, 0).xyz;
        const Reprojection there = reproject(p, moved.xy);
        const vec2 at = there.uv * vec2(frame.prev_size) - 0.5, nearest = floor(at + 0.5);
        resampled = any(greaterThan(abs(at - nearest), vec2(WHOLE_TEXEL)));
        q = clamp(ivec2(nearest), ivec2(0), ivec2(frame.prev_size) - 1);
        const float z = imageLoad(view_depth, p).x, was = imageLoad(view_depth_prev, q).x;
        const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
        Surface surface = Surface(off_plane(before, n, position(p, z)), SAME_PLANE_PX * pixel_span_m(z));
        follow(surface.plane, at, z + moved.z, q, was);
        const bool same_face = dot(n, decode_normal(imageLoad(guide_normal_prev, q))) > SAME_FACE;
        known = known && there.on_screen && was > 0.0 && same_face && shows(surface, vec2(q), was);
        const ivec2 beyond = q + ivec2(sign(at - nearest) * step(WHOLE_TEXEL, abs(at - nearest)));
        for (int i = 0; i < 2; ++i) {
            const ivec2 beside = clamp(i == 0 ? ivec2(beyond.x, q.y) : ivec2(q.x, beyond.y), ivec2(0), ivec2(frame.prev_size) - 1);
            const float z_beside = imageLoad(view_depth_prev, beside).x;
            beside_step = beside_step || z_beside > 0.0 && metres_off(surface.plane, vec2(beside), z_beside) > STEP_PX * pixel_span_m(z);
        }
    }
    const uint word = imageLoad(history, q).x;
    return PixelPast(known && has_count(word), visibility_in(word), count_in(word), residual_in(word), resampled, beside_step);
}
