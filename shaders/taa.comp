// SPDX-License-Identifier: MIT
// Temporal anti-aliasing in the published form: the history, moved with the nearest surface and sampled with
// Catmull-Rom, is clamped to the colours around the pixel and receives 1/16 of the new one. Averages are taken after
// c / (1 + c), so that a bright sample cannot flicker. Karis, High-quality temporal supersampling (2014); variance box
// after Salvi, An excursion in temporal supersampling (2016). No disocclusion test: the box alone rejects history.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/finite.glsl"
#include "common/pixels.glsl"

const float BLEND = 1.0 / 16.0;

vec3 compress(vec3 c) { return c / (1.0 + c); }
vec3 expand(vec3 c) { return storable(c / max(1.0 - c, 1e-5)); }

vec3 current(ivec2 p) { return compress(storable(imageLoad(lit, clamp(p, ivec2(0), ivec2(frame.size) - 1)).xyz)); }

// Motion of the nearest surface in 3x3: an edge takes its history from what is in front.
vec2 nearest_motion(ivec2 p) {
    ivec2 nearest = p;
    float z = 1e30;
    for (int i = 0; i < 9; ++i) {
        const ivec2 q = p + ivec2(i % 3, i / 3) - 1;
        const float z_q = inside_frame(q) ? imageLoad(view_depth, q).x : 0.0;
        if (z_q > 0.0 && z_q < z) {
            z = z_q;
            nearest = q;
        }
    }
    return texelFetch(motion, nearest, 0).xy;
}

vec3 history_tap(vec2 texel) { return textureLod(history, history_coordinate(texel, textureSize(history, 0)), 0.0).xyz; }

// Catmull-Rom over 4x4 texels from nine bilinear taps: the two inner weights of an axis share one tap between them.
vec3 history_at(vec2 uv) {
    const vec2 texel = uv * vec2(frame.prev_size);
    const vec2 base = floor(texel - 0.5) + 0.5;
    const vec2 f = texel - base;
    const vec2 w0 = f * (-0.5 + f * (1.0 - 0.5 * f));
    const vec2 w1 = 1.0 + f * f * (-2.5 + 1.5 * f);
    const vec2 w2 = f * (0.5 + f * (2.0 - 1.5 * f));
    const vec2 w3 = f * f * (-0.5 + 0.5 * f);
    const vec2 at[3] = vec2[](base - 1.0, base + w2 / (w1 + w2), base + 2.0);
    const vec2 w[3] = vec2[](w0, w1 + w2, w3);
    vec3 sum = vec3(0.0);
    for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 3; ++x) sum += w[x].x * w[y].y * history_tap(vec2(at[x].x, at[y].y));
    return compress(storable(sum));
}

// History limited to mean +- scale deviations of the 3x3 neighbourhood, weights exp(-3 r^2 / 4).
vec3 clamp_to_neighbours(ivec2 p, vec3 past, float scale) {
    vec3 sum = vec3(0.0), squares = vec3(0.0);
    float weights = 0.0;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            const float weight = exp(-0.75 * float(x * x + y * y));
            const vec3 c = current(p + ivec2(x, y));
            sum += weight * c;
            squares += weight * c * c;
            weights += weight;
        }
    const vec3 mean = sum / weights;
    const vec3 half_box = scale * sqrt(max(squares / weights - mean * mean, 0.0));
    return clamp(past, mean - half_box, mean + half_box);
}

void for_pixel(ivec2 p) {
    vec3 c = current(p);
    const vec2 v = nearest_motion(p);
    const Reprojection there = reproject(p, v);
    if (there.on_screen && (frame.flags & FRAME_RESET) == 0u) {
        // What stands still may keep more of its history: nothing there can be a ghost for long.
        const float scale = mix(0.5, 2.5, 1.0 - smoothstep(0.0, 0.02, length(v)));
        c = mix(clamp_to_neighbours(p, history_at(there.uv), scale), c, BLEND);
    }
    imageStore(color, p, vec4(expand(c), 1.0));
}

void main() { for_each_pixel(); }
