// SPDX-License-Identifier: MIT
// The state blurred by less than the penumbra is wide: 3x3 taps of the same surface, fading as the past grows.
//
// Includer has view_rays.glsl, guide_normal.glsl and shadow_state.glsl, and declares the images state, view_depth and
// guide_normal and params.plane_tolerance.

const float SIDE = 0.75;             // kernel: .75, 1, .75 per axis
const float NEAR_SIDE = 0.4;         // instead of .75 at NEAR_STEP
const float NEIGHBOURS = 0.9;        // weight of the neighbours on the first frame,
const float FADING = 0.3;            // and how fast it falls with the count
const float UNLIKE = 2.0;            // how fast with the difference squared, over what one ray's would be after as many frames

float softened(ivec2 p, ivec2 apart, ShadowState own, ViewRays rays) {
    const bvec2 near = equal(apart, ivec2(NEAR_STEP));
    const ivec2 steps = mix(apart, ivec2(1), near);
    const vec2 side = mix(vec2(SIDE), vec2(NEAR_SIDE), near);
    const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
    const Surface surface = surface_at(rays, n, imageLoad(view_depth, p).x, params.plane_tolerance);
    const float weight = NEIGHBOURS / (1.0 + FADING * max(own.count - 1.0, 0.0));
    const ivec2 last = ivec2(frame.size) - 1;
    const int reach = (steps.x | steps.y) != 0 ? 1 : -1;
    float sum = own.visibility, weights = 1.0;
    for (int y = -reach; y <= reach; ++y)
        for (int x = -reach; x <= reach; ++x) {
            const ivec2 offset = steps * ivec2(x, y), q = p + offset;
            const bool elsewhere = (x == 0 || steps.x > 0) && (y == 0 || steps.y > 0) && (x != 0 || y != 0);
            if (!elsewhere || any(lessThan(q, ivec2(0))) || any(greaterThan(q, last))) continue;
            const uint word = imageLoad(state, q).x;
            const bool same = has_count(word) && shows(surface, vec2(offset), imageLoad(view_depth, q).x);
            const float d = visibility_in(word) - own.visibility, alike = 1.0 / (1.0 + UNLIKE * d * d * own.count);
            const float w = same ? weight * alike * (x == 0 ? 1.0 : side.x) * (y == 0 ? 1.0 : side.y) : 0.0;
            sum += w * visibility_in(word);
            weights += w;
        }
    return sum / weights;
}
