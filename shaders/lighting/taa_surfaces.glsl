// SPDX-License-Identifier: MIT
// Which of the history showed what is seen around a pixel now.
//
// Includer has camera.glsl, guide_normal.glsl and taa_history.glsl, and declares the image history and, where things move, motion,
// guide_normal and view_depth_prev.
#include "common/corners.glsl"
#include "common/view_rays.glsl"

// The history at a position, and for how many frames it stands; 0: there is none.
struct Past {
    vec3 color;
    float frames;
    bool thin;  // it may have shown something thinner than a pixel that is not seen now
};

float frames_of(float alpha) { return floor(alpha * float(MAX_FRAMES) + 0.5); }

// What a pixel shows, among points that the previous frame saw at some uv (without jitter), depth_change less in front of the
// camera. Moved back by the surface's own motion such a point is one of the current view, where positions are linear in uv and
// bilinear with depth.
struct Plane {
    Surface surface;
    vec2 depth_change;  // previous - current view depth: of a still surface, and as the host's motion says (0 if it does not)
};

Plane plane_at(ivec2 p, float z) {
    const vec3 point = position(p, z), moved = texelFetch(motion, p, 0).xyz;
    const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
    const vec3 corner0 = position_at(vec2(0.0), 0.0), corner1 = position_at(vec2(0.0), 1.0);
    const vec3 offset = vec3(dot(n, position_at(vec2(1.0, 0.0), 0.0) - corner0),
                             dot(n, position_at(vec2(0.0, 1.0), 0.0) - corner0), dot(n, corner0 - point));
    const vec3 both = vec3(dot(n, position_at(vec2(1.0, 0.0), 1.0) - corner1),
                           dot(n, position_at(vec2(0.0, 1.0), 1.0) - corner1), dot(n, corner1 - point));
    const vec3 slope = both - offset;
    const OffPlane off = OffPlane(offset.z - dot(offset.xy, moved.xy), offset.x, offset.y,
                                  slope.z - dot(slope.xy, moved.xy), slope.x, slope.y);
    return Plane(Surface(off, params.plane_tolerance * pixel_span_m(z)), vec2(previous_depth(point) - z, moved.z));
}

bool was_seen(Plane plane, vec2 uv, float z) {
    return shows(plane.surface, uv, z - plane.depth_change.x) || shows(plane.surface, uv, z - plane.depth_change.y);
}

// What is seen around the pixel now: two surfaces and perhaps the sky.
struct Seen {
    Plane front, back;
    bool solid, sky;
};

// Whether a texel of the previous frame showed any of it.
bool showed(Seen seen, ivec2 t) {
    const float z = imageLoad(view_depth_prev, t).x;
    const vec2 uv = (vec2(t) + 0.5) / vec2(frame.prev_size) - frame.prev_jitter;
    const bool surface = seen.solid && (was_seen(seen.front, uv, z) || was_seen(seen.back, uv, z));
    return z > 0.0 ? surface : seen.sky;
}

// What is thinner than a pixel comes and goes with the jitter: gone from all nine pixels, it is still no surface that went
// away if what is seen now was seen on both sides of it. Should it have gone all the same, its colour must not stay: what
// lies between the mean around the pixel and the pixel's own colour does.
bool was_thin(Seen seen, ivec2 t, ivec2 last) {
    bool thin = false;
    for (int axis = 0; axis < 2; ++axis) {
        const ivec2 side = axis == 0 ? ivec2(1, 0) : ivec2(0, 1);
        const bool both = showed(seen, clamp(t - side, ivec2(0), last)) && showed(seen, clamp(t + side, ivec2(0), last));
        thin = thin || both;
    }
    return thin;
}

// An edge of the picture alternates with the jitter between what is in front and what is behind, so a texel may have shown
// either. Where one of the four around the position showed something else, the largest share of the others stands for all.
Past past_among(vec2 texel, Around around) {
    const Seen seen = Seen(plane_at(around.nearest, around.nearest_depth), plane_at(around.farthest, around.farthest_depth),
                           around.farthest_depth > 0.0, around.sky);
    const ivec2 last = ivec2(frame.prev_size) - 1, base = ivec2(floor(texel - 0.5));
    // Rounding must not turn "exactly there" into a neighbour's tiny share.
    const float SUBTEXELS = 256.0;
    const vec2 f = floor((texel - 0.5 - vec2(base)) * SUBTEXELS + 0.5) / SUBTEXELS;
    ivec2 best = ivec2(0);
    float best_share = 0.0, shares = 0.0;
    for (int i = 0; i < 4; ++i) {
        const ivec2 offset = corner(i);
        const vec2 axes = mix(1.0 - f, f, vec2(offset));
        const ivec2 t = clamp(base + offset, ivec2(0), last);
        const float share = showed(seen, t) ? axes.x * axes.y : 0.0;
        best = share > best_share ? t : best;
        best_share = max(best_share, share);
        shares += share;
    }
    const ivec2 nearest = clamp(ivec2(floor(texel)), ivec2(0), last);
    const bool none = best_share < 0.05, thin = none && was_thin(seen, nearest, last);
    const vec4 value = texelFetch(history, none ? nearest : best, 0);
    // The shares of four that count are 1, exactly: they are multiples of 2^-16.
    const bool between = best_share < 1.0 && shares == 1.0;
    return Past(between ? history_at(texel) : value.xyz, none && !thin ? 0.0 : frames_of(value.w), thin);
}

// Where nothing moves, the texel's own is all that is asked.
Past past_at(vec2 texel, Around around) {
    if (HAS_VIEW_DEPTH_PREV) return past_among(texel, around);
    const vec4 value = texelFetch(history, ivec2(texel), 0);
    return Past(value.xyz, frames_of(value.w), false);
}
