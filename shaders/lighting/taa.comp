// SPDX-License-Identifier: MIT
// Temporal anti-aliasing: the history, moved with the nearest surface and sampled with Catmull-Rom, is limited to the
// colours around the pixel and receives the new one. Averages are taken after c / (1 + c), so that a bright sample cannot
// flicker. Karis, High-quality temporal supersampling (2014); variance box after Salvi, An excursion in temporal
// supersampling (2016).
//
// published: the new colour counts 1/16, and the box alone rejects history.
// robust: a history texel counts where it showed a surface that is seen around the pixel now (distance to its plane), or
// something that cannot have gone from there; and the new colour counts 1/n of n frames: an edge under 16 jitter positions is
// their mean after 16 frames, and what has just come into view starts anew. n is smaller where the history is interpolated, which
// blurs it every time. Where nothing moves, a pixel's history is its own.
//
// Where IN_A_ROW (lanes_in_a_row.glsl: a software device) an invocation goes down a column: of the 3x3 pixels around each only the
// lower three are new. Elsewhere it has one pixel, and no loop over rows.
#extension GL_KHR_shader_subgroup_shuffle : require
#include "node.glsl"
#include "common/camera.glsl"
#include "common/finite.glsl"
#include "common/guide_normal.glsl"
#include "lighting/lanes_in_a_row.glsl"
#include "common/rounded.glsl"

const float BLEND = 1.0 / 16.0;  // published

vec3 compress(vec3 c) { return WEIGHTING == WEIGHTING_LINEAR ? c : c / (1.0 + c); }
vec3 expand(vec3 c) { return storable(WEIGHTING == WEIGHTING_LINEAR ? c : c / max(1.0 - c, 1e-5)); }

#include "lighting/taa_history.glsl"
#include "lighting/taa_box.glsl"
#include "lighting/taa_surfaces.glsl"

// What was seen of a thing thinner than a pixel is in few pixels' colours, or in none, of any one frame. So it leaves the box by
// this share in a frame; a shadow that moves across a fence is gone after sixteen.
const float THIN_SHARE = 0.25;

// Interpolation takes f (1 - f) along each axis from the history's sharpness. So many frames' worth of it may be gone.
const float FRAMES_OF_BLUR = 2.0;

float longest(vec2 texel) {
    if (!HAS_VIEW_DEPTH_PREV) return float(MAX_FRAMES);
    const vec2 f = fract(texel - 0.5);
    return min(floor(1.0 + FRAMES_OF_BLUR / max(dot(f, 1.0 - f), 1e-3)), float(MAX_FRAMES));
}

// What the history says of a pixel, with this frame counted. 0 frames: nothing. What has no past may move: there is no motion to
// tell by.
Past past_of(ivec2 p, Around around, Cameras cameras, vec3 moved) {
    Past past = Past(vec3(0.0), Memory(0.0, 0.0, HAS_VIEW_DEPTH_PREV));
    const Reprojection there = reproject(p, moved.xy);
    if (there.on_screen && (frame.flags & FRAME_RESET) == 0u) {
        if (!HAS_GUIDE_NORMAL) return Past(history_at(there.uv * vec2(frame.prev_size)), Memory(1.0, 0.0, false));
        // Not by way of uv, whose rounding would move a still pixel.
        const vec2 texel = (vec2(p) + 0.5) * (vec2(frame.prev_size) / vec2(frame.size)) + moved.xy * vec2(frame.prev_size);
        past = past_at(p, texel, around, cameras, moved);
        if (past.memory.frames >= 1.0) past.memory.frames = min(past.memory.frames + 1.0, longest(texel));
    }
    return past;
}

vec4 robust(Box box, Past past) {
    vec3 c = box.shown;
    Memory memory = Memory(1.0, 0.0, past.memory.moves_itself);
    if (past.memory.frames >= 1.0) {
        const vec3 remembered = compress(storable(past.color)), inside = clamp_to_box(box, remembered, params.clamp_sigma);
        const vec3 before = past.memory.thin > 0.0 ? mix(remembered, inside, THIN_SHARE) : inside;
        memory = past.memory;
        c = before + (c - before) / memory.frames;
    }
    return vec4(expand(c), alpha_of(memory));
}

vec4 published(Box box, Past past, vec2 v) {
    vec3 c = box.shown;
    if (past.memory.frames >= 1.0) {
        // What stands still may keep more of its history: nothing there can be a ghost for long.
        const float scale = mix(0.5, 2.5, 1.0 - smoothstep(0.0, 0.02, length(v)));
        c = mix(clamp_to_box(box, compress(storable(past.color)), scale), c, BLEND);
    }
    return vec4(expand(c), 1.0);
}

void main() {
    const int x = column(), first = int(gl_GlobalInvocationID.y * PER_THREAD_Y);
    const bool inside = x < int(frame.size.x);
    if (!IN_A_ROW && !(inside && first < int(frame.size.y))) return;
    const int rows = IN_A_ROW ? min(int(PER_THREAD_Y), int(frame.size.y) - first) : 1;
    const Cameras cameras = cameras();
    vec3 color_sides = vec3(0.0);
    float depth_sides = 0.0;
    DepthRow depth_above = depth_row(x, first - 1, 0, depth_sides), depth_here = depth_row(x, first, 1, depth_sides);
    ColorRow color_above, color_here;
    if (IN_A_ROW) {
        color_above = color_row(x, first - 1, 0, color_sides);
        color_here = color_row(x, first, 1, color_sides);
    }
#if CLASS_CPU
    for (int row = 0; row < rows; ++row)
#else
    const int row = 0;  // docs/gpu.md: a compiler that the loop is too much for
#endif
    {
        const ivec2 p = ivec2(x, first + row);
        ColorRow color_below;
        if (IN_A_ROW) color_below = color_row(x, p.y + 1, row + 2, color_sides);
        const DepthRow depth_below = depth_row(x, p.y + 1, row + 2, depth_sides);
        Past past;
        vec3 v = vec3(0.0);
        if (!IN_A_ROW || inside) {  // who stands beside the image has rows to load
            const Around around = around_of(p, depth_above, depth_here, depth_below);
            if (HAS_MOTION) v = texelFetch(motion, around.nearest, 0).xyz;
            past = past_of(p, around, cameras, v);
        }
        // Not before, where a lane has one pixel: registers are what a GPU has few of.
        if (!IN_A_ROW) {
            color_above = color_row(x, first - 1, 0, color_sides);
            color_here = color_row(x, first, 1, color_sides);
            color_below = color_row(x, first + 1, 2, color_sides);
        }
        if (!IN_A_ROW || inside) {
            const Box box = box_of(color_above, color_here, color_below);
            store_color(p, HAS_GUIDE_NORMAL ? robust(box, past) : published(box, past, v.xy));
        }
        color_above = color_here;
        color_here = color_below;
        depth_above = depth_here;
        depth_here = depth_below;
    }
}
