// SPDX-License-Identifier: MIT
// RELAX, temporal accumulation: two pasts, of up to 63 frames and of six, each found at the surface's own place and at that of
// what it mirrors, and believed as far as the view and the surface have stayed the same.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/corners.glsl"
#include "common/cubic.glsl"
#include "common/past_places.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/rounded.glsl"
#include "common/same_surface.glsl"
#include "relax/light.glsl"
#include "relax/relax.glsl"
#include "relax/frames.glsl"
#include "relax/footprint.glsl"

const float DEPTH_TOLERANCE = 0.01;  // of the frustum's height, over the cosine of view
const float ANOTHER_SIDE = 0.44;      // sine of the angle between normals of two sides of a thing
const float FREE_PARALLAX_PX = 30.0; // a surface that moves so far may be seen at another angle

// Towards the previous camera.
vec3 to_viewer_before(vec3 x, vec3 now) {
    if ((frame.flags & FRAME_ORTHOGRAPHIC) == 0u) return normalize(frame.camera_delta - x);
    const mat4 m = frame.prev_clip_from_rel;
    const vec3 axis = normalize(vec3(m[0].z, m[1].z, m[2].z));
    return dot(axis, now) < 0.0 ? -axis : axis;
}

// A past with the frame mixed in. `confidence`: in it, of 0 to 1; the short past has one of its own.
struct Mixed {
    vec4 slow, fast;
    float frames;
};

Mixed mix_in(Past past, vec4 now, float confidence, float fast_confidence) {
    const float light = luminance(now.rgb);
    if (!(past.frames > 0.0)) return Mixed(vec4(now.rgb, light), now, 1.0);
    const float frames = past.frames + 1.0;
    const float share = max(max(1.0 / (MOST_FRAMES + 1.0), 1.0 / frames), 1.0 - confidence);
    const float fast_share = max(max(1.0 / (MOST_FAST_FRAMES + 1.0), 1.0 / frames), 1.0 - fast_confidence);
    // Squares of what a half float holds are none: the published second moment asks for radiance below 250, its root does not.
    const float square = mix(past.slow.w * past.slow.w, light * light, share);
    const float distance_m = 1.0 / mix(1.0 / max(past.fast.w, 1e-4), 1.0 / max(now.w, 1e-4), fast_share);
    return Mixed(vec4(mix(past.slow.rgb, now.rgb, share), sqrt(square)), vec4(mix(past.fast.rgb, now.rgb, fast_share), distance_m),
                 frames);
}

void store(ivec2 p, Mixed m, float trusted) {
    store_slow_now(p, m.slow);
    store_fast_now(p, m.fast);
    store_frames(p, vec4(encode_frames(m.frames)));
#if HAS_CONFIDENCE
    store_confidence(p, vec4(trusted));
#endif
}

// The past of the surface itself, shortened where its footprint is stretched or partly hidden.
Past surface_past(Shown here, vec2 uv, float facing, float facing_before, ivec2 p) {
    const float parallax_px = length((uv - pixel_uv(p)) * vec2(frame.size));
    const float slope = mix(max(facing, 0.05), 1.0, clamp(parallax_px / FREE_PARALLAX_PX, 0.0, 1.0));
    const float allowed = frustum_m(here.z) * min((DEPTH_TOLERANCE + 1.0 / float(frame.size.y)) / slope, 1.0);
    const Footprint f = footprint_at(here, Expected(past_depths(p, here.z, here.x), allowed, ANOTHER_SIDE), uv);
    Past past = past_at(f);
    const float stretched = facing_before / max(facing, 1e-3);
    past.frames *= sqrt(f.seen) * mix(0.1, 1.0, min(stretched * stretched * stretched * stretched, 1.0));
    return past;
}

#if HAS_CONFIDENCE
// Normals are geometric: each pixel's mirror is plane as far as they know, so that the published estimate of a curvature has nothing
// to find. Where the view ray to the image passes through that plane is what the previous frame must have shown.
Expected expected_mirror(Shown here, vec3 image) {
    const float sine = min(lobe_tangent(here.roughness) + 2.0 * NORMAL_ERROR, ANOTHER_SIDE);
    if ((frame.flags & FRAME_ORTHOGRAPHIC) != 0u) return Expected(vec2(previous_depth(here.x)), 1e30, sine);
    const vec3 origin = frame.camera_delta, along = image - origin;
    const float across = dot(here.n, along), t = dot(here.n, here.x - origin) / across;
    const float depth = previous_depth(origin + t * along), tolerance = DEPTH_TOLERANCE * frustum_m(here.z) / max(abs(across) / length(along), 0.05);
    return t > 0.0 && t < 1e6 ? Expected(vec2(depth), tolerance, sine) : Expected(vec2(0.0), -1.0, 0.0);
}

// How alike what was at a place of the previous frame mirrors: of its normal and roughness.
float same_mirror(Shown here, vec2 uv, float tangent) {
    if (!in_image(uv)) return 1.0;
    const ivec2 q = previous_texel(uv);
    const uvec2 then = imageLoad(surface_prev, q).xy;
    if (!(surface_depth(then) > 0.0)) return 1.0;
    const vec3 n = surface_normal(then);
    const float rough = (surface_roughness(then) - here.roughness) / (0.01 + 0.15 * here.roughness);
    return lasting_weight(angle_between(here.n, n) / max(tangent, 1e-3)) * smooth_weight(rough);
}

// Lagarde and de Rousiers 2014, "Moving Frostbite to Physically Based Rendering": how far a lobe is a mirror's.
float dominance(float roughness) {
    const float smoothness = 1.0 - roughness;
    return smoothness * (sqrt(smoothness) + roughness);
}
#endif

void for_pixel(ivec2 p) {
    const Shown here = shown(p);
    if (!(here.z > 0.0)) {
        store(p, Mixed(vec4(0.0), vec4(0.0), 0.0), 0.0);
        return;
    }
    const vec4 now = imageLoad(blurred, p);
    const vec3 viewer = to_viewer(p), viewer_before = to_viewer_before(here.x, viewer);
    const vec2 of_surface = past_of_surface(p);
    const Past surface = surface_past(here, of_surface, abs(dot(here.n, viewer)), abs(dot(here.n, viewer_before)), p);
#if !HAS_CONFIDENCE
    store(p, mix_in(surface, now, 1.0, 1.0), 1.0);
#else
    // A lobe turns with the view; its past is of as many frames as it takes to turn by its own width.
    const float tangent = lobe_tangent(here.roughness);
    const float turned = length(cross(viewer, viewer_before));
    const float still = clamp(1.0 - turned / max(tangent, 1e-4), 0.0, 1.0);
    Mixed result = mix_in(surface, now, still, still);
    float trusted = surface.frames > 0.0 ? still : 0.0;

    const vec2 of_image = past_of_image(p, here.z, now.w);
    const Footprint f = footprint_at(here, expected_mirror(here, here.x * (1.0 + now.w / max(length(here.x), 1e-6))), of_image);
    Past mirrored = past_at(f);
    if (mirrored.frames > 0.0) {
        mirrored.frames *= sqrt(f.seen);
        const vec2 back = of_image - pixel_uv(p);
        const float mirror = same_mirror(here, of_image, tangent);
        const float held = mirror * (0.33 + 0.67 * same_mirror(here, of_image + back, tangent)) *
                           (0.33 + 0.67 * same_mirror(here, of_image + 2.0 * back, tangent));
        // Where the image would have been, had it been as far away as the past says.
        const vec2 elsewhere = (past_of_image(p, here.z, mirrored.fast.w) - of_image) * vec2(frame.prev_size);
        const float near_px = 1.0 + tangent * now.w / max(pixel_span_m(here.z + now.w), 1e-6);
        const float agrees = smooth_weight(length(elsewhere) / near_px);
        const Mixed other = mix_in(mirrored, now, held, held * agrees);
        float amount = dominance(here.roughness) * mirror;
        amount = surface.frames > 0.0 ? min(amount, clamp(held / max(still, 1e-3), 0.0, 1.0)) : 1.0;
        result.slow = mix(result.slow, other.slow, amount);
        result.fast = mix(result.fast, other.fast, amount);
        result.frames = mix(result.frames, other.frames, amount);
        trusted = mix(trusted, held, amount);
    }
    store(p, result, trusted);
#endif
}

void main() { for_each_pixel(); }
