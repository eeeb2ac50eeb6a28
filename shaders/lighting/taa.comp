// SPDX-License-Identifier: MIT
// Temporal anti-aliasing: the history, moved with the nearest surface and sampled with Catmull-Rom, is limited to the
// colours around the pixel and receives the new one. Averages are taken after c / (1 + c), so that a bright sample cannot
// flicker. Karis, High-quality temporal supersampling (2014); variance box after Salvi, An excursion in temporal
// supersampling (2016).
//
// published: the new colour counts 1/16, and the box alone rejects history.
// robust: a history texel counts where it showed a surface that is seen around the pixel now (distance to its plane), or
// something thinner than a pixel before one; and
// the new colour counts 1/n of n frames: an edge under 16 jitter positions is their mean after 16 frames, and what has just
// come into view starts anew. Where nothing moves, a pixel's history is its own.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/finite.glsl"
#include "common/guide_normal.glsl"
#include "common/pixels.glsl"
#include "common/round_store.glsl"

const float BLEND = 1.0 / 16.0;  // published

vec3 compress(vec3 c) { return WEIGHTING == WEIGHTING_LINEAR ? c : c / (1.0 + c); }
vec3 expand(vec3 c) { return storable(WEIGHTING == WEIGHTING_LINEAR ? c : c / max(1.0 - c, 1e-5)); }

vec3 current(ivec2 p) { return compress(storable(imageLoad(lit, clamp(p, ivec2(0), ivec2(frame.size) - 1)).xyz)); }

// Of 3x3 pixels: an edge takes its history from what is in front. Depths are 0 and the pixel p where all is sky.
struct Around {
    ivec2 nearest, farthest;
    float nearest_depth, farthest_depth;
    bool sky;
};

Around look_around(ivec2 p) {
    Around a = Around(p, p, 1e30, 0.0, false);
    for (int i = 0; i < 9; ++i) {
        const ivec2 q = p + ivec2(i % 3, i / 3) - 1;
        if (!inside_frame(q)) continue;
        const float z = imageLoad(view_depth, q).x;
        if (z > 0.0 && z < a.nearest_depth) {
            a.nearest_depth = z;
            a.nearest = q;
        }
        if (z > a.farthest_depth) {
            a.farthest_depth = z;
            a.farthest = q;
        }
        if (!(z > 0.0)) a.sky = true;
    }
    return a;
}

#include "lighting/taa_history.glsl"
#include "lighting/taa_box.glsl"
#include "lighting/taa_surfaces.glsl"

vec4 robust(ivec2 p, vec3 c, Around around, Reprojection there, vec2 v) {
    float frames = 1.0;
    if (there.on_screen && (frame.flags & FRAME_RESET) == 0u) {
        // Not by way of uv, whose rounding would move a still pixel.
        const vec2 texel = (vec2(p) + 0.5) * (vec2(frame.prev_size) / vec2(frame.size)) + v * vec2(frame.prev_size);
        const Past past = past_at(texel, around);
        if (past.frames >= 1.0) {
            const float scale = past.thin ? 0.0 : params.clamp_sigma;
            const vec3 before = clamp_to_neighbours(p, compress(storable(past.color)), scale);
            frames = min(past.frames + 1.0, float(MAX_FRAMES));
            c = before + (c - before) / frames;
        }
    }
    const vec3 out_color = expand(c);
    return vec4(round_to(out_color.xy, HALF_BITS), round_to(out_color.z, HALF_BITS), frames / float(MAX_FRAMES));
}

vec4 published(ivec2 p, vec3 c, Reprojection there, vec2 v) {
    if (there.on_screen && (frame.flags & FRAME_RESET) == 0u) {
        // What stands still may keep more of its history: nothing there can be a ghost for long.
        const float scale = mix(0.5, 2.5, 1.0 - smoothstep(0.0, 0.02, length(v)));
        const vec3 past = compress(storable(history_at(there.uv * vec2(frame.prev_size))));
        c = mix(clamp_to_neighbours(p, past, scale), c, BLEND);
    }
    return vec4(expand(c), 1.0);
}

void for_pixel(ivec2 p) {
    const vec3 c = current(p);
    const Around around = look_around(p);
    const vec2 v = HAS_MOTION ? texelFetch(motion, around.nearest, 0).xy : vec2(0.0);
    const Reprojection there = reproject(p, v);
    if (HAS_GUIDE_NORMAL)
        imageStore(color, p, robust(p, c, around, there, v));
    else
        imageStore(color, p, published(p, c, there, v));
}

void main() { for_each_pixel(); }
