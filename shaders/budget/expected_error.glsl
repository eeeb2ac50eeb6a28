// SPDX-License-Identifier: MIT
// The squared error that one ray is expected to leave in a pixel beside unlike rays, by what the previous frame knew of it. Figures are means of v (1 - v)
// over pixels of the tuning shots; docs/constants.md says how far these agree.
//
// Includer has nearest_past.glsl, blockers.glsl, sun_change.glsl and light_change.glsl, and declares the blocks sun and light and, where
// these move, sun_prev and light_prev.

// [0]: next to unlike rays; [1]: two pixels away; [2]: farther. By how far the past was from 0 and from 1.
const float UNKNOWN[3] = float[3](0.077, 0.025, 0.0035), SURE[3] = float[3](0.01, 0.0028, 0.0003), NEARLY[3] = float[3](0.05, 0.031, 0.024),
            FAINT[3] = float[3](0.111, 0.08, 0.064), HALF[3] = float[3](0.2, 0.16, 0.14), CONTRADICTED[3] = float[3](0.088, 0.025, 0.028);
const float NEARLY_BELOW = 0.05, FAINT_BELOW = 0.2;

const float OF_RAYS = 20.0;        // of a past as good as so many rays a further ray is worth a quarter
const float RESAMPLED_WORTH = 3.0; // rays that the past is worth at most where it was resampled
// A past that frames have lately differed from by b is worth v (1 - v) / b^2 rays at most; what their noise would make of b^2, over the
// variance of a frame: a running mean of weight .2 has .2 / 1.8 of that, taken twice.
const float RESIDUAL_NOISE = 0.4 / 1.8;

// The neighbours' rays that test a pixel's disc of radius r pixels, in own ones; what gather makes of straight edges (docs/denoiser.md).
const float FEWEST_PX = 1.25, MOST_WORTH = 200.0;

float worth_of_neighbours(ivec2 tile, float view_depth) {
    vec3 sums = vec3(0.0);
    const ivec2 last = tile_grid() - 1;
    for (int i = 0; i < 5; ++i) {
        const ivec2 q = tile + ivec2(i == 1 ? -1 : i == 2 ? 1 : 0, i == 3 ? -1 : i == 4 ? 1 : 0);
        sums += blockers_of(tile_index(clamp(q, ivec2(0), last)));
    }
    if (sums.x <= 0.0) return 0.0;
    const float size = HAS_LIGHT ? light_radius_m() : tan(sun.angular_radius);  // behind a blocker, over the way to it
    const float r = exp2(sums.y / sums.x) * size / pixel_span_m(view_depth);
    return r < FEWEST_PX ? 0.0 : min(1.5 * r * r * r, MOST_WORTH);
}

// Whether the surface goes on to either side along an axis; along a plane the reciprocal of a perspective's depth is linear.
const int BENT_PX = 2;
const float BENT_OFF_PX = 2.0, BENT_WORTH = 0.3;  // of the neighbours, where it does not
bool goes_on(ivec2 p, ivec2 axis, float z) {
    const ivec2 last = ivec2(frame.size) - 1;
    const float before = imageLoad(view_depth, clamp(p - BENT_PX * axis, ivec2(0), last)).x,
                behind = imageLoad(view_depth, clamp(p + BENT_PX * axis, ivec2(0), last)).x;
    const float off = (frame.flags & FRAME_ORTHOGRAPHIC) != 0u ? before + behind - 2.0 * z : z * (2.0 - z / before - z / behind);
    return before > 0.0 && behind > 0.0 && abs(off) <= BENT_OFF_PX * pixel_span_m(z);
}

// `ring`: how near unlike rays are; `lit`: what its own says; `before`: as nearest_past() takes it.
float expected_error(ivec2 p, uint ring, bool lit, float neighbours, ViewRays before) {
    PixelPast past = nearest_past(p, before);
    float share = 1.0;  // of this frame's light where the last frame's was
    if (past.known) {
        if (HAS_LIGHT_PREV)
            share = light_share(light, light_prev, position(p, imageLoad(view_depth, p).x));
        else if (HAS_SUN_PREV && !HAS_LIGHT)
            share = sun_share(sun, sun_prev);
        past.known = share > 0.0;
    }
    float error = UNKNOWN[ring], known_rays = 0.0;
    if (past.known) {
        const float between = min(past.visibility, 1.0 - past.visibility);
        error = between < SURE_BELOW ? SURE[ring] : between < NEARLY_BELOW ? NEARLY[ring] : between < FAINT_BELOW ? FAINT[ring] : HALF[ring];
        known_rays = past.resampled ? min(past.count, RESAMPLED_WORTH) : past.count;
        if (HAS_MOTION) known_rays = min(known_rays, COUNT_CAP);
        if (HAS_MOTION || (HAS_LIGHT ? HAS_LIGHT_PREV : HAS_SUN_PREV)) {
            const float rays = max(neighbours, 1.0), v = past.visibility * (1.0 - past.visibility);
            const float bias = past.residual * past.residual - RESIDUAL_NOISE * v / rays;  // squared
            if (bias > 0.0) known_rays = min(known_rays, v / (bias * rays));
        }
        if (between < SURE_BELOW && lit == past.visibility < 0.5) {
            error = CONTRADICTED[ring];
            known_rays = 0.0;
        }
        known_rays = samples_left(known_rays, share);
    }
    const float left = 1.0 / (1.0 + known_rays / OF_RAYS);
    if (neighbours > 0.0) {
        const float z = imageLoad(view_depth, p).x;
        for (int i = 0; i < 2; ++i)
            if (!goes_on(p, ivec2(1 - i, i), z)) neighbours *= BENT_WORTH;
    }
    return error * left * left * min(1.0, 1.25 / max(neighbours, 1.25));
}
