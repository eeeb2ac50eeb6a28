// SPDX-License-Identifier: MIT
// What the previous frame knew of the surface that a pixel shows, by the nearest texel: enough to allot rays by, not to shade by.
//
// Includer has camera.glsl and shadow_state.glsl and declares the images history, view_depth and, where things move, motion and
// view_depth_prev.
#include "common/past_places.glsl"

const float SURE_BELOW = 0.01;       // of 0 or of 1: no penumbra
const float SAME_DEPTH = 0.03;       // relative
const float WHOLE_TEXEL = 0.02;      // px

struct PixelPast {
    bool known;       // else the other members mean nothing
    float visibility, count, residual;
    bool resampled;   // lay between texels
};

PixelPast nearest_past(ivec2 p) {
    ivec2 q = p;
    bool known = HAS_MOTION ? (frame.flags & FRAME_RESET) == 0u : pixels_have_pasts(), resampled = false;
    if (HAS_MOTION) {
        const Reprojection before = reproject(p, surface_motion(p));
        const vec2 at = before.uv * vec2(frame.prev_size) - 0.5, nearest = floor(at + 0.5);
        resampled = any(greaterThan(abs(at - nearest), vec2(WHOLE_TEXEL)));
        q = clamp(ivec2(nearest), ivec2(0), ivec2(frame.prev_size) - 1);
        const float z = imageLoad(view_depth, p).x, was = imageLoad(view_depth_prev, q).x;
        const vec2 expected = past_depths(p, z, position(p, z));
        known = known && before.on_screen && any(lessThan(abs(was - expected), SAME_DEPTH * expected));
    }
    const uint word = imageLoad(history, q).x;
    return PixelPast(known && has_count(word), visibility_in(word), count_in(word), residual_in(word), resampled);
}
