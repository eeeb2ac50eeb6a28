// SPDX-License-Identifier: MIT
// What the previous frame knew about a pixel's surface: the state that drift left there, and what the pixel's own rays had
// said, taken from the texels that show the same plane and the same face of it.
//
// Includer has shadow_state.glsl, view_rays.glsl, corners.glsl and common/light_axes.glsl, and declares the images history
// and, where things move, motion, view_depth_prev and guide_normal_prev.
#include "common/cubic.glsl"
#include "common/surface_before.glsl"
#include "common/sun_change.glsl"
#include "common/light_change.glsl"

struct Past {
    float visibility, count, residual;
    float variance;  // between the texels that it is resampled from; 0: it is one of them
    OwnRays own;
    bool resampled, elsewhere;  // between texels; not the pixel's own
};
const Past NO_PAST = Past(0.0, 0.0, 0.0, 0.0, NO_RAYS, false, false);

// The history between its texels without bilinear's blur; none of it where `rows` is 0 instead of 4.
float sharper(ivec2 first, vec2 t, int rows) {
    const vec4 wx = cubic_weights(t.x), wy = cubic_weights(t.y);
    const ivec2 last = ivec2(frame.prev_size) - 1;
    float sum = 0.0;
    for (int y = 0; y < rows; ++y) {
        float row = 0.0;
        [[unroll]] for (int x = 0; x < 4; ++x) {
            const ivec2 q = clamp(first + ivec2(x, y) - 1, ivec2(0), last);
            row += wx[x] * visibility_in(imageLoad(history, q).x);
        }
        sum += wy[y] * row;
    }
    return sum;
}

// `surface`: the pixel's at depth z, among what previous_rays() sees.
Past past_of(ivec2 p, vec3 n, float z, Surface surface) {
    const vec3 moved = texelFetch(motion, p, 0).xyz;
    const Reprojection there = reproject(p, moved.xy);
    const bool asks = there.on_screen && (frame.flags & FRAME_RESET) == 0u;
    const vec2 at = there.uv * vec2(frame.prev_size) - 0.5;
    const ivec2 first = ivec2(floor(at + 1e-3)), last = ivec2(frame.prev_size) - 1;
    const vec2 t = clamp(at - vec2(first), 0.0, 1.0);
    const ivec2 around = clamp(ivec2(floor(at + 0.5)), ivec2(0), last);
    follow(surface.plane, at, z + moved.z, around, imageLoad(view_depth_prev, around).x);
    float weights = 0.0, nearest = 0.0, low = 1.0, high = 0.0, own_visibility = 0.0;
    uint nearest_word = 0u;
    Past past = NO_PAST;
    for (int i = 0; i < 4; ++i) {
        const float share = bilinear_share(i, t);
        if (asks && share > 1e-3) {
            const ivec2 q = first + corner(i), inside = clamp(q, ivec2(0), last);
            const float z_prev = imageLoad(view_depth_prev, inside).x;
            const vec3 n_prev = decode_normal(imageLoad(guide_normal_prev, inside));
            const uint word = imageLoad(history, inside).x;
            const float v = visibility_in(word);
            const bool same = q == inside && z_prev > 0.0 && has_count(word) && dot(n, n_prev) > SAME_FACE &&
                              shows(surface, vec2(inside), z_prev);
            const float weight = same ? share : 0.0;
            weights += weight;
            past.visibility += weight * v;
            past.variance += weight * v * v;
            own_visibility += weight * own_visibility_in(word);
            low = same ? min(low, v) : low;
            high = same ? max(high, v) : high;
            if (weight > nearest) {
                nearest = weight;
                nearest_word = word;
            }
        }
    }
    past.resampled = nearest < 0.999;
    past.elsewhere = past.resampled || any(greaterThan(abs(at - vec2(p)), vec2(0.5)));
    const float by_weights = 1.0 / max(weights, 1e-3);  // none is less, but where there is none
    past.visibility *= by_weights;
    const ShadowState of_nearest = unpack_state(nearest_word);  // how far that is off, limits counts
    past.count = of_nearest.count;
    past.residual = of_nearest.residual;
    past.own = of_nearest.own;
    past.own.visibility = own_visibility * by_weights;  // the nearest one's would stay behind in a slow pan, by half a pixel per frame
    past.variance = max(past.variance * by_weights - past.visibility * past.visibility, 0.0);
    const float between = sharper(first, t, weights > 0.99 && high > low ? 4 : 0);
    if (weights > 0.99 && high > low) past.visibility = clamp(between, low, high);
    if (weights <= 0.0) past = NO_PAST;
    return past;
}

// Nothing moves: the pixel's past is its own.
Past past_of(ivec2 p) {
    const ShadowState s = unpack_state(imageLoad(history, p).x);
    if (s.count <= 0.0 || !pixels_have_pasts()) return NO_PAST;
    return Past(s.visibility, s.count, s.residual, 0.0, s.own, false, false);
}

const bool LIGHT_MOVES = HAS_LIGHT ? HAS_LIGHT_PREV : HAS_SUN_PREV;
const bool MAY_CHANGE = HAS_MOTION || LIGHT_MOVES;

// A past that saw another light, or this one elsewhere. `p`: the receiver, along towards_light.
Past under_this_light(Past past, vec3 p) {
    if (!LIGHT_MOVES) return past;
    const float share = HAS_LIGHT ? light_share(light, light_prev, p) : sun_share(sun, sun_prev);
    past.count = samples_left(past.count, share);
    past.own.count = samples_left(past.own.count, share);
    if (past.count <= 0.0) return NO_PAST;
    return past;
}
