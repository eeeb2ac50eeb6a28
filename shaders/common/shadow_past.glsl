// SPDX-License-Identifier: MIT
// What the previous frame knew about a pixel's surface: the state that drift left there, and what the pixel's own rays had
// said, taken from the texels that show the same plane and the same face of it.
//
// Includer has previous_surface.glsl, shadow_state.glsl and light_space.glsl, and declares the images history
// and, where things move, motion, view_depth_prev and guide_normal_prev.
#include "common/cubic.glsl"
#include "common/sun_change.glsl"

const float SAME_FACE = 0.9;  // cosine, as near as 10 bits are to a unit vector: beyond a crease the sun stands differently

struct Past {
    float visibility, count, residual;
    float variance;  // between the texels that it is resampled from; 0: it is one of them
    OwnRays own;
    bool resampled;
};
const Past NO_PAST = Past(0.0, 0.0, 0.0, 0.0, NO_RAYS, false);

// What the previous frame's texels showed, from its first one on, in light space: previous_position() is linear in a texel's
// place and depth. Taken over the whole image, differences do not round away.
ViewRays previous_rays(mat3 light) {
    const ivec2 size = ivec2(frame.prev_size);
    const ivec2 right = ivec2(size.x, 0), below = ivec2(0, size.y);
    const vec3 o = light * previous_position(ivec2(0), 0.0), r = light * previous_position(ivec2(0), 1.0) - o;
    const vec3 right_o = light * previous_position(right, 0.0), right_r = light * previous_position(right, 1.0) - right_o;
    const vec3 below_o = light * previous_position(below, 0.0), below_r = light * previous_position(below, 1.0) - below_o;
    const vec2 by_size = 1.0 / vec2(size);
    return ViewRays(o, (right_o - o) * by_size.x, (below_o - o) * by_size.y, r, (right_r - r) * by_size.x,
                    (below_r - r) * by_size.y);
}

// The history between its texels without bilinear's blur; none of it where `rows` is 0 instead of 4.
float sharper(ivec2 corner, vec2 t, int rows) {
    const vec4 wx = cubic_weights(t.x), wy = cubic_weights(t.y);
    const ivec2 last = ivec2(frame.prev_size) - 1;
    float sum = 0.0;
    for (int y = 0; y < rows; ++y) {
        float row = 0.0;
        [[unroll]] for (int x = 0; x < 4; ++x) {
            const ivec2 q = clamp(corner + ivec2(x, y) - 1, ivec2(0), last);
            row += wx[x] * visibility_in(imageLoad(history, q).x);
        }
        sum += wy[y] * row;
    }
    return sum;
}

// `plane`: the pixel's, among what previous_rays() sees.
Past past_of(ivec2 p, vec3 n, OffPlane plane, float tolerance_m) {
    const Reprojection there = reproject(p, texelFetch(motion, p, 0).xy);
    const bool asks = there.on_screen && (frame.flags & FRAME_RESET) == 0u;
    const vec2 at = there.uv * vec2(frame.prev_size) - 0.5;
    const ivec2 corner = ivec2(floor(at + 1e-3)), last = ivec2(frame.prev_size) - 1;
    const vec2 t = clamp(at - vec2(corner), 0.0, 1.0);
    float weights = 0.0, nearest = 0.0, low = 1.0, high = 0.0;
    uint nearest_word = 0u;
    Past past = NO_PAST;
    for (int i = 0; i < 4; ++i) {
        const float share = ((i & 1) != 0 ? t.x : 1.0 - t.x) * ((i >> 1) != 0 ? t.y : 1.0 - t.y);
        if (asks && share > 1e-3) {
            const ivec2 q = corner + ivec2(i & 1, i >> 1), inside = clamp(q, ivec2(0), last);
            const float z = imageLoad(view_depth_prev, inside).x;
            const vec3 n_prev = decode_normal(imageLoad(guide_normal_prev, inside));
            const uint word = imageLoad(history, inside).x;
            const float v = visibility_in(word);
            const bool same = q == inside && z > 0.0 && has_count(word) && dot(n, n_prev) > SAME_FACE &&
                              abs(metres_off(plane, vec2(inside), z)) <= tolerance_m;
            const float weight = same ? share : 0.0;
            weights += weight;
            past.visibility += weight * v;
            past.variance += weight * v * v;
            low = same ? min(low, v) : low;
            high = same ? max(high, v) : high;
            if (weight > nearest) {
                nearest = weight;
                nearest_word = word;
            }
        }
    }
    past.resampled = nearest < 0.999;
    const float by_weights = 1.0 / max(weights, 1e-3);  // none is less, but where there is none
    past.visibility *= by_weights;
    const ShadowState of_nearest = unpack_state(nearest_word);  // how far that is off, limits counts
    past.count = of_nearest.count;
    past.residual = of_nearest.residual;
    past.own = of_nearest.own;
    past.variance = max(past.variance * by_weights - past.visibility * past.visibility, 0.0);
    const float between = sharper(corner, t, weights > 0.99 && high > low ? 4 : 0);
    if (weights > 0.99 && high > low) past.visibility = clamp(between, low, high);
    if (weights <= 0.0) past = NO_PAST;
    return past;
}

// Nothing moves: the pixel's past is its own.
Past past_of(ivec2 p) {
    const ShadowState s = unpack_state(imageLoad(history, p).x);
    if (s.count <= 0.0 || (frame.flags & FRAME_RESET) != 0u) return NO_PAST;
    return Past(s.visibility, s.count, s.residual, 0.0, s.own, false);
}

// A past that saw another sun.
Past under_this_sun(Past past) {
    if (!HAS_SUN_PREV) return past;
    const float share = sun_share(sun, sun_prev);
    past.count = samples_left(past.count, share);
    past.own.count = samples_left(past.own.count, share);
    if (past.count <= 0.0) return NO_PAST;
    return past;
}
