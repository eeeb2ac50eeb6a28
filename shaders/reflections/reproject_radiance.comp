// SPDX-License-Identifier: MIT
// Two pasts for each pixel, the surface's and the mirrored image's, and how many frames either stands for: 0, none. Which one
// is believed, and how far, is accumulate_radiance's to say.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/cubic.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/rounded.glsl"
#include "common/dithered.glsl"
#include "reflections/radiance_word.glsl"
#include "reflections/gathered_texel.glsl"
#include "reflections/kept_surface.glsl"
#include "reflections/past_texel.glsl"
#include "common/past_places.glsl"
#include "common/same_surface.glsl"

// How far the surface's depth may be off where it was, of the depth, over the cosine of view.
const float DEPTH_TOLERANCE = 0.02;
const float IMAGELESS = 0.5;  // roughness from which on a lobe mirrors no image that is seen to move otherwise than its surface

// `depths`: any of which the surface may have had.
bool past_is(Shown here, ivec2 q, vec2 depths, float tolerance) {
    if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, ivec2(frame.prev_size)))) return false;
    const KeptSurface then = decode_kept(imageLoad(surface_prev, q).x);
    if (!(then.z > 0.0) || !any(lessThanEqual(abs(then.z - depths), vec2(tolerance)))) return false;
    return dot(here.n, then.n) > 0.9 && (LOBE == LOBE_DIFFUSE || alike(here.roughness, then.roughness));
}

vec4 history_texel(ivec2 q) {
    const Past past = decode_past(imageLoad(history, q).x, texel_byte(imageLoad(frames_prev, q).x));
    return vec4(past.radiance, past.frames);
}

// Catmull-Rom where all that it reads has a past; limited to the four texels around, which keeps bright points from ringing.
vec3 sharp_history(ivec2 first, vec2 within, vec3 smooth_value) {
    const vec4 wx = cubic_weights(within.x), wy = cubic_weights(within.y);
    vec3 sum = vec3(0.0), low = vec3(1e30), high = vec3(0.0);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) {
            const ivec2 q = clamp(first + ivec2(x, y) - 1, ivec2(0), ivec2(frame.prev_size) - 1);
            const vec4 texel = history_texel(q);
            if (!(texel.w > 0.0)) return smooth_value;
            sum += wx[x] * wy[y] * texel.rgb;
            if (x % 3 != 0 && y % 3 != 0) {
                low = min(low, texel.rgb);
                high = max(high, texel.rgb);
            }
        }
    return clamp(sum, low, high);
}

// `depths`: of the surface, as the previous frame may have seen it, within `tolerance`.
vec4 past_at(Shown here, vec2 uv, vec2 depths, float tolerance) {
    if (any(lessThan(uv, vec2(0.0))) || any(greaterThanEqual(uv, vec2(1.0)))) return vec4(0.0);
    const vec2 at = uv * vec2(frame.prev_size) - 0.5;
    const ivec2 nearest = ivec2(round(at));
    if (all(lessThan(abs(at - round(at)), vec2(1.0 / 256.0))))
        return past_is(here, nearest, depths, tolerance) ? history_texel(nearest) : vec4(0.0);
    const ivec2 first = ivec2(floor(at));
    const vec2 within = at - floor(at);
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    bool whole = true;
    for (int i = 0; i < 4; ++i) {
        const ivec2 step = ivec2(i & 1, i >> 1), q = first + step;
        if (!past_is(here, q, depths, tolerance)) {
            whole = false;
            continue;
        }
        const vec2 share = mix(1.0 - within, within, vec2(step));
        sum += share.x * share.y * history_texel(q);
        weights += share.x * share.y;
    }
    if (!(weights > 0.05)) return vec4(0.0);
    sum /= weights;
    if (whole) sum.rgb = sharp_history(first, within, sum.rgb);
    return sum;
}

void for_pixel(ivec2 p) {
    const Shown here = shown(p);
    vec4 of_surface = vec4(0.0), of_image = vec4(0.0);  // the second of a specular lobe alone
    if (here.z > 0.0 && (frame.flags & FRAME_RESET) == 0u) {
        const float cosine = max(dot(here.n, to_viewer(p)), 0.1);
        of_surface = past_at(here, past_of_surface(p), past_depths(p, here.z, here.x), DEPTH_TOLERANCE * here.z / cosine);
#if HAS_PAST_IMAGE
        if (here.roughness < IMAGELESS) of_image = past_at(here, past_of_image(p, here.z, decode_gathered(imageLoad(gathered, p).xy).distance_m), vec2(here.z), 1e30);
#endif
    }
    const uint thresholds = thresholds_at(p);
    const uvec2 surface = encode_past(Past(of_surface.rgb, of_surface.w), thresholds);
    const uvec2 image = encode_past(Past(of_image.rgb, of_image.w), thresholds);
    store_past_surface(p, uvec4(surface.x));
#if HAS_PAST_IMAGE
    store_past_image(p, uvec4(image.x));
#endif
    store_past_frames(p, vec4(byte_texel(surface.y), byte_texel(image.y), 0.0, 0.0));
}

void main() { for_each_pixel(); }
