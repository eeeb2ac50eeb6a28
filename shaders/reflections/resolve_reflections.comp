// SPDX-License-Identifier: MIT
// Published form, third pass: the past, limited to the radiance around, receives what was filtered.
#include "node.glsl"
#define TILE_RADIANCE(q) imageLoad(prefiltered, q)
#include "reflections/published_tile.glsl"
#include "common/bilinear.glsl"
#include "reflections/published_average.glsl"

const float STABILITY = 0.7 * 1.4;

bool usable(vec3 c) { return !any(isnan(c)) && !any(isinf(c)); }

void main() {
    ivec2 first, p;
    if (!listed_reflection_tile(first, p)) return;
    load_tile_radiance(first);
    if (!inside_frame(p)) return;
    const vec4 c = around_lane(ivec2(0));
    // Published defect: what is dark has no variance and never gathers a history.
    if (c.r + c.g + c.b < 1e-4) {
        store_specular(p, vec4(0.0));
        store_variance(p, vec4(0.0));
        return;
    }
    const LocalStatistics around = local_statistics();
    const float samples = imageLoad(samples_now, p).x, variance_filtered = imageLoad(variance_second, p).x;
    const vec3 average = average_at(p);
    const vec3 deviation = (sqrt(around.variance) + length(around.mean - average)) * STABILITY;
    const vec3 mean = mix(around.mean, average, 0.2);
    const vec3 past = clip_to_box(mean - deviation, mean + deviation, imageLoad(reprojected, p).rgb);
    vec3 now = mix(c.rgb, average, 1.0 / max(samples + 1.0, 1.0));
    now = clip_to_box(average - deviation, average + deviation, now);
    const float weight = 1.0 - 1.0 / max(samples, 1.0);
    const vec3 result = mix(now, past, weight);
    const float variance_now = mix(temporal_variance(result, past), variance_filtered, weight);
    store_specular(p, vec4(usable(result) ? max(result, vec3(0.0)) : vec3(0.0), c.w));
    store_variance(p, vec4(usable(vec3(variance_now)) ? variance_now : 0.0));
}
