// SPDX-License-Identifier: MIT
// Which of the history showed what is seen around a pixel now.
//
// Includer has camera.glsl, guide_normal.glsl, lanes_in_a_row.glsl, rounded.glsl and taa_history.glsl, and
// declares the images history and view_depth and, where things move, motion, guide_normal and view_depth_prev.
#include "common/corners.glsl"
#include "common/view_rays.glsl"
#include "lighting/taa_memory.glsl"

// Of three pixels side by side: the nearest and the farthest surface, and whether there is sky. Pixels outside the image
// are none.
struct DepthRow {
    float nearest, farthest;
    int nearest_x, farthest_x;
    bool sky;
};

float depth_within(ivec2 p) { return imageLoad(view_depth, clamp(p, ivec2(0), ivec2(frame.size) - 1)).x; }

// `row` and `sides` as color_row() has them.
DepthRow depth_row(int x, int y, int row, inout float sides) {
    DepthRow found = DepthRow(1e30, 0.0, x, x, false);
    const bool in_image = y >= 0 && y < int(frame.size.y);
    if (!IN_A_ROW && !in_image) return found;
    const float own = depth_within(ivec2(x, y));
    float l, r;
    if (IN_A_ROW) {
        if (sides_are_due(row)) sides = depth_within(beside_row(x, y));
        l = left_of(own, sides, row);
        r = right_of(own, sides, row);
    } else {
        l = depth_within(ivec2(x - 1, y));
        r = depth_within(ivec2(x + 1, y));
    }
    const vec3 depths = vec3(l, own, r);
    for (int i = 0; i < 3; ++i) {
        const int at = x + i - 1;
        const float z = depths[i];
        const bool there = in_image && at >= 0 && at < int(frame.size.x);
        const bool nearer = there && z > 0.0 && z < found.nearest, farther = there && z > found.farthest;
        found.nearest_x = nearer ? at : found.nearest_x;
        found.nearest = nearer ? z : found.nearest;
        found.farthest_x = farther ? at : found.farthest_x;
        found.farthest = farther ? z : found.farthest;
        found.sky = found.sky || there && !(z > 0.0);
    }
    return found;
}

// Of 3x3 pixels: an edge takes its history from what is in front. Depths are 0 and the pixel p where all is sky.
struct Around {
    ivec2 nearest, farthest;
    float nearest_depth, farthest_depth;
    bool sky;
};

Around with_row(Around a, DepthRow row, int y) {
    if (row.nearest < a.nearest_depth) {
        a.nearest_depth = row.nearest;
        a.nearest = ivec2(row.nearest_x, y);
    }
    if (row.farthest > a.farthest_depth) {
        a.farthest_depth = row.farthest;
        a.farthest = ivec2(row.farthest_x, y);
    }
    a.sky = a.sky || row.sky;
    return a;
}

Around around_of(ivec2 p, DepthRow above, DepthRow here, DepthRow below) {
    const Around none = Around(p, p, 1e30, 0.0, false);
    return with_row(with_row(with_row(none, above, p.y - 1), here, p.y), below, p.y + 1);
}

// The history at a position. 0 frames: there is none.
struct Past {
    vec3 color;
    Memory memory;
};

// What all pixels need of the two cameras, in units of the image instead of pixels: points of the current one, what depth a
// still point had in the previous frame, uv (without jitter) of pixels and of the previous frame's texels.
struct Cameras {
    ViewRays rays;
    OffPlane depth_prev;  // by metres_off()
    bool orthographic;
    vec2 by_size, first_uv, by_size_prev, first_uv_prev;
    float tolerance_m, tolerance_per_m;  // of a surface: of its view depth
};

Cameras cameras() {
    const vec3 o = position_at(vec2(0.0), 0.0), r = position_at(vec2(0.0), 1.0) - o;
    const vec3 ox = position_at(vec2(1.0, 0.0), 0.0), oy = position_at(vec2(0.0, 1.0), 0.0);
    const ViewRays rays = ViewRays(o, ox - o, oy - o, r, position_at(vec2(1.0, 0.0), 1.0) - ox - r,
                                   position_at(vec2(0.0, 1.0), 1.0) - oy - r);
    const float depth = previous_depth(vec3(0.0));
    const vec3 slope = vec3(previous_depth(vec3(1.0, 0.0, 0.0)), previous_depth(vec3(0.0, 1.0, 0.0)),
                            previous_depth(vec3(0.0, 0.0, 1.0))) - depth;
    OffPlane depth_prev = off_plane(rays, slope, vec3(0.0));
    depth_prev.o += depth;
    const vec2 by_size = 1.0 / vec2(frame.size), by_size_prev = 1.0 / vec2(frame.prev_size);
    const float tolerance_m = params.plane_tolerance * pixel_span_m(0.0);
    return Cameras(rays, depth_prev, (frame.flags & FRAME_ORTHOGRAPHIC) != 0u, by_size, 0.5 * by_size - frame.jitter, by_size_prev,
                   0.5 * by_size_prev - frame.prev_jitter, tolerance_m, params.plane_tolerance * pixel_span_m(1.0) - tolerance_m);
}

// Whether the previous frame had a still point within so many pixels of a place. `depth_then`: its view depth there. A NaN was not
// near, nor what was behind the camera.
bool was_near(Cameras cameras, vec2 uv, float z, float depth_then, vec2 there, float px) {
    const float w = cameras.orthographic ? 1.0 : depth_then;
    const vec2 clip = (frame.prev_clip_from_rel * vec4(seen_at(cameras.rays, uv, z), 1.0)).xy;
    const vec2 off = (0.5 * clip + (0.5 - there) * w) * vec2(frame.prev_size);
    const float limit = px * w;
    return w > 0.0 && dot(off, off) < limit * limit;
}

// What a pixel shows, among points that the previous frame saw at some uv (without jitter), depth_change less in front of the
// camera. Moved back by the surface's own motion such a point is one of the current view, where positions are linear in uv and
// bilinear with depth.
struct Plane {
    Surface surface;
    vec2 depth_change;  // previous - current view depth: of a still surface, and as the host's motion says (0 if it does not)
};

Plane plane_at(Cameras cameras, ivec2 p, float z, vec3 moved) {
    const vec2 uv = vec2(p) * cameras.by_size + cameras.first_uv;
    const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
    OffPlane off = off_plane(cameras.rays, n, vec3(0.0));
    off.o -= metres_off(off, uv, z) + off.ox * moved.x + off.oy * moved.y;
    off.r -= off.rx * moved.x + off.ry * moved.y;
    return Plane(Surface(off, cameras.tolerance_m + cameras.tolerance_per_m * z),
                 vec2(metres_off(cameras.depth_prev, uv, z) - z, moved.z));
}

// How far off a plane a point of the previous frame lies, in metres. A comparison that a NaN fails.
float off_by(Plane plane, vec2 uv, float z) {
    return min(abs(metres_off(plane.surface.plane, uv, z - plane.depth_change.x)),
               abs(metres_off(plane.surface.plane, uv, z - plane.depth_change.y)));
}

vec2 previous_uv(Cameras cameras, ivec2 t) { return vec2(t) * cameras.by_size_prev + cameras.first_uv_prev; }

// What moves by less goes on being seen by the pixels around, so that its history is as good as that of what is still. It is also
// more than halves' rounding makes of a still point's motion.
const float OWN_MOTION_PX = 0.5;
const float SAME = 0.5;  // of the tolerance: nearer to a plane than that is the surface itself, farther a ledge of it
const float FAR_M = 1e30;
const float SKY_M = 1e6;  // as good as infinitely far away, for what a camera's steps move

// What is thinner than a pixel comes and goes with the jitter, and so do the gaps of a fence: what a texel of the previous frame
// showed, and no pixel around shows now, has not gone away if the cameras alone have moved it by less than a pixel against what
// is seen now, whose past lies at `texel`. `z`: its depth then; 0 is the sky.
bool stays(Cameras cameras, ivec2 p, vec2 texel, float z) {
    const vec2 uv = (vec2(p) + 0.5) * cameras.by_size;
    const float then = z > 0.0 ? z : SKY_M, now = 2.0 * then - metres_off(cameras.depth_prev, uv, then);
    return now > 0.0 && was_near(cameras, uv, now, then, texel * cameras.by_size_prev, 1.0);
}

// An edge of the picture alternates with the jitter between what is in front and what is behind, so a texel may have shown
// either, or what is thinner than a pixel. Where some of the four around the position showed something else, the others' mean
// stands for all. `moved`: the motion of what is in front.
Past past_among(ivec2 p, vec2 texel, Around around, Cameras cameras, vec3 moved) {
    const bool solid = around.farthest_depth > 0.0;
    const Plane front = plane_at(cameras, around.nearest, around.nearest_depth, moved);
    // At the pixel instead of at what is nearest: a still surface's motion is the same there, but for what zooming does to it.
    const vec2 here = vec2(p) * cameras.by_size + cameras.first_uv;
    const bool moves_itself = solid && !was_near(cameras, here, around.nearest_depth, around.nearest_depth + front.depth_change.x,
                                                 here + moved.xy, OWN_MOTION_PX);
    const ivec2 last = history_last(), base = history_base(texel);
    // Rounding must not turn "exactly there" into a neighbour's tiny share.
    const float SUBTEXELS = 256.0;
    const vec2 within = texel - 0.5 - vec2(base), f = floor(within * SUBTEXELS + 0.5) / SUBTEXELS;
    const vec4 share = vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    ivec2 t[4];
    for (int i = 0; i < 4; ++i) t[i] = clamp(base + corner(i), ivec2(0), last);
    vec4 z = vec4(imageLoad(view_depth_prev, t[0]).x);
    if (f != vec2(0.0)) {  // what moves by whole pixels asks one texel
        z.y = imageLoad(view_depth_prev, t[1]).x;
        z.z = imageLoad(view_depth_prev, t[2]).x;
        z.w = imageLoad(view_depth_prev, t[3]).x;
    }
    const float tolerance_m = front.surface.tolerance_m, same_m = SAME * tolerance_m;
    vec4 off_m;  // 0 as well where the sky was seen and is
    for (int i = 0; i < 4; ++i) {
        off_m[i] = !(z[i] > 0.0) && around.sky ? 0.0 : FAR_M;
        if (z[i] > 0.0 && solid) off_m[i] = off_by(front, previous_uv(cameras, t[i]), z[i]);
    }
    const ivec2 nearest = clamp(base + ivec2(greaterThanEqual(within, vec2(0.5))), ivec2(0), last);
    bool none = false, thin = false;
    if (dot(share, vec4(lessThanEqual(off_m, vec4(same_m)))) < 1.0) {  // exactly: shares are multiples of 2^-16
        const vec3 moved_back = texelFetch(motion, around.farthest, 0).xyz;
        const Plane back = plane_at(cameras, around.farthest, around.farthest_depth, moved_back);
        const float scale = tolerance_m / back.surface.tolerance_m;
        for (int i = 0; i < 4; ++i)
            if (z[i] > 0.0 && solid) off_m[i] = min(off_m[i], scale * off_by(back, previous_uv(cameras, t[i]), z[i]));
        if (dot(share, vec4(lessThanEqual(off_m, vec4(same_m)))) < 1.0) {
            // What moves is still in front: it has not left. A bar of the same gate, or what is behind its gaps, need not be
            // among the two surfaces that are asked.
            const bool may_stay = moves_itself || !memory_of(imageLoad(history, nearest).w).moves_itself;
            for (int i = 0; i < 4; ++i) {
                const bool other = !(off_m[i] <= same_m) && may_stay && stays(cameras, p, texel, z[i]);
                thin = thin || other && share[i] > 0.0;
                off_m[i] = other ? 0.0 : off_m[i];
            }
        }
        const vec4 left = share * vec4(lessThanEqual(off_m, vec4(tolerance_m)));
        if (max(max(left.x, left.y), max(left.z, left.w)) < 0.05) none = true;
    }
    const bvec4 seen = lessThanEqual(off_m, vec4(tolerance_m));
    const vec4 left = share * vec4(seen);
    const float best_share = max(max(left.x, left.y), max(left.z, left.w));
    const ivec2 best = left.x == best_share ? t[0] : left.y == best_share ? t[1] : left.z == best_share ? t[2] : t[3];
    const vec4 value = imageLoad(history, none ? nearest : best);
    vec3 past_color = value.xyz;
    const float counted = dot(left, vec4(1.0));
    if (best_share < counted && counted < 1.0)
        past_color = (left.x * imageLoad(history, t[0]).xyz + left.y * imageLoad(history, t[1]).xyz +
                      left.z * imageLoad(history, t[2]).xyz + left.w * imageLoad(history, t[3]).xyz) / counted;
    if (best_share < 1.0 && counted == 1.0) past_color = history_at(texel);
    Memory memory = memory_of(value.w);
    memory.frames = none ? 0.0 : memory.frames;
    memory.moves_itself = moves_itself;
    memory.thin = thin ? THIN_LONGEST : a_frame_later(memory.thin);
    return Past(past_color, memory);
}

// Where nothing moves, the texel's own is all that is asked.
Past past_at(ivec2 p, vec2 texel, Around around, Cameras cameras, vec3 moved) {
    if (HAS_VIEW_DEPTH_PREV) return past_among(p, texel, around, cameras, moved);
    const vec4 value = imageLoad(history, clamp(history_base(texel + 0.5), ivec2(0), history_last()));
    return Past(value.xyz, memory_of(value.w));
}
