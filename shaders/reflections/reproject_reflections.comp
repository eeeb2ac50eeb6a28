// SPDX-License-Identifier: MIT
// Published form, first pass: the past of the surface or of what it mirrors, how many frames it stands for, its variance; and
// the mean radiance of 8x8 pixels.
#include "node.glsl"
#define TILE_RADIANCE(q) texelFetch(radiance, q, 0)
#include "common/bilinear.glsl"
#include "common/camera.glsl"
#include "common/guide_normal.glsl"
#include "common/past_places.glsl"
#include "reflections/published_tile.glsl"

const float SAMPLES = 32.0;

shared vec4 tile_sums[64];

struct Past {
    vec2 uv;
    vec3 normal;
    float depth, roughness;
};

bool on_screen(vec2 uv) { return all(greaterThan(uv, vec2(0.0))) && all(lessThan(uv, vec2(1.0))); }

Past past_at(vec2 uv) {
    const ivec2 q = previous_texel(clamp(uv, vec2(0.0), vec2(1.0)));
    return Past(uv, unit_or_zero(decode_normal(imageLoad(guide_normal_prev, q))), imageLoad(view_depth_prev, q).x,
                texelFetch(roughness_prev, q, 0).x);
}

// How little a past texel is disoccluded.
float similarity(vec3 n, float z, Past past) {
    return exp(-1.4 * abs(1.0 - max(0.0, dot(n, past.normal)))) * exp(-abs(past.depth - z) / z);
}

#define HISTORY(q) imageLoad(history, q).rgb
#define SAMPLES_THEN(q) imageLoad(samples_prev, q).x
#define VARIANCE_THEN(q) imageLoad(variance_prev, q).x
BILINEAR(vec3, history_between, HISTORY)
BILINEAR(float, samples_between, SAMPLES_THEN)
BILINEAR(float, variance_between, VARIANCE_THEN)
vec3 history_at(vec2 uv) { return history_between(uv * vec2(frame.prev_size), ivec2(frame.prev_size)); }

struct Reprojected {
    vec3 history;
    float factor;
    vec2 uv;
};

Reprojected reprojected_history(ivec2 p, float z, vec3 n, float roughness, float ray_m, LocalStatistics around) {
    const Past surface = past_at(reproject(p, surface_motion(p)).uv), hit = past_at(past_of_image(position(p, z), ray_m));
    const float of_surface = dot(surface.normal, n), of_hit = dot(hit.normal, n);
    Past chosen = surface;
    vec3 value = history_at(surface.uv);
    if (on_screen(hit.uv) && of_hit > 0.9999 && of_hit + 1e-3 >= of_surface &&
        abs(hit.roughness - roughness) <= abs(surface.roughness - roughness) + 1e-3) {
        chosen = hit;
        value = history_at(hit.uv);
    } else {
        const vec3 off = value - around.mean;
        // The published form samples a coordinate that it has not set here; this is the surface's.
        if (!(dot(off, off) < 1.5 * length(around.variance))) return Reprojected(value, 0.0, surface.uv);
    }
    if (!on_screen(chosen.uv)) return Reprojected(value, 0.0, chosen.uv);
    float factor = similarity(n, z, chosen);
    if (factor > 0.9) return Reprojected(value, factor, chosen.uv);
    Past best = chosen;
    for (int i = 0; i < 9; ++i) {
        const Past other = past_at(chosen.uv + vec2(i % 3 - 1, i / 3 - 1) / vec2(frame.prev_size));
        const float its = similarity(n, z, other);
        if (its > factor) {
            factor = its;
            best = other;
        }
    }
    if (factor > 0.9) return Reprojected(history_at(best.uv), factor, best.uv);
    // Its four texels, those alone that are somewhat alike.
    const vec2 at = chosen.uv * vec2(frame.prev_size) - 0.5, within = fract(at);
    vec3 sum = vec3(0.0), normal = vec3(0.0);
    float depth = 0.0, weights = 0.0;
    for (int i = 0; i < 4; ++i) {
        const ivec2 step = ivec2(i & 1, i >> 1);
        const Past tap = past_at((floor(at) + vec2(step) + 0.5) / vec2(frame.prev_size));
        const vec2 share = mix(1.0 - within, within, vec2(step));
        const float weight = similarity(n, z, tap) > 0.45 ? share.x * share.y : 0.0;
        sum += weight * HISTORY(previous_texel(clamp(tap.uv, vec2(0.0), vec2(1.0))));
        normal += weight * tap.normal;
        depth += weight * tap.depth;
        weights += weight;
    }
    if (!(weights > 0.0)) return Reprojected(value, 0.0, chosen.uv);
    factor = similarity(n, z, Past(chosen.uv, unit_or_zero(normal), depth / weights, 0.0));
    return Reprojected(sum / weights, factor < 0.9 ? 0.0 : factor, chosen.uv);
}

void store_average(ivec2 first, ivec2 p) {
    vec3 c = around_lane(ivec2(0)).rgb;
    const bool counts = inside_frame(p) && !any(isnan(c)) && !any(isinf(c));
    c = counts ? c : vec3(0.0);
    // Published defect: bright pixels weigh little, so energy is lost where there are fireflies.
    const float weight = counts ? max(exp(-0.3 * published_luminance(c)), 0.01) : 0.0;
    tile_sums[gl_LocalInvocationIndex] = vec4(c * weight, weight);
    for (uint half_count = 32u; half_count > 0u; half_count >>= 1) {
        barrier();
        if (gl_LocalInvocationIndex < half_count)
            tile_sums[gl_LocalInvocationIndex] += tile_sums[gl_LocalInvocationIndex + half_count];
    }
    if (gl_LocalInvocationIndex == 0u)
        store_average_radiance(first / 8, vec4(tile_sums[0].rgb / max(tile_sums[0].w, 1e-3), 0.0));
}

void main() {
    ivec2 first, p;
    if (!listed_reflection_tile(first, p)) return;
    load_tile_radiance(first);
    store_average(first, p);
    const float z = inside_frame(p) ? imageLoad(view_depth, p).x : 0.0;
    if (!(z > 0.0)) return;
    const vec4 c = around_lane(ivec2(0));
    const float roughness = imageLoad(extracted_roughness, p).x;
    const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
    Reprojected past = Reprojected(vec3(0.0), 0.0, pixel_uv(p));
    if ((frame.flags & FRAME_RESET) == 0u) past = reprojected_history(p, z, n, roughness, c.w, local_statistics());
    float samples = 1.0, variance_now = 1.0;
    vec3 kept = vec3(0.0);
    if (past.factor >= 0.9) {
        const vec2 texel = past.uv * vec2(frame.prev_size);
        const float most = max(8.0, SAMPLES * (1.0 - exp(-100.0 * roughness)));
        samples = min(most, samples_between(texel, ivec2(frame.prev_size)) * past.factor + 1.0);
        kept = past.history;
        // Published defect, inverted: at first the old variance has all the weight.
        variance_now = mix(temporal_variance(c.rgb, kept), variance_between(texel, ivec2(frame.prev_size)), 1.0 / samples);
    }
    store_reprojected(p, vec4(kept, 0.0));
    store_samples_now(p, vec4(samples));
    store_variance_first(p, vec4(variance_now));
}
