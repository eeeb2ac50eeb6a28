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

vec3 history_tap(vec2 texel) { return textureLod(history, history_coordinate(texel, textureSize(history, 0)), 0.0).xyz; }

// Catmull-Rom over 4x4 texels from nine bilinear taps: the two inner weights of an axis share one tap between them.
vec3 history_at(vec2 texel) {
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
    return sum;
}

// Luma and chroma vary independently of each other more often than red, green and blue do: a box along these axes is the
// tighter one. Malvar and Sullivan 2003, YCoCg.
vec3 to_box_axes(vec3 c) {
    if (BOX == BOX_RGB) return c;
    return vec3(0.25 * c.x + 0.5 * c.y + 0.25 * c.z, 0.5 * (c.x - c.z), 0.5 * c.y - 0.25 * (c.x + c.z));
}
vec3 from_box_axes(vec3 c) {
    if (BOX == BOX_RGB) return c;
    return vec3(c.x + c.y - c.z, c.x + c.z, c.x - c.y - c.z);
}

// History limited to mean +- scale deviations of the 3x3 neighbourhood, weights exp(-3 r^2 / 4). In the robust form the
// pixel's own colour is inside too, however far off its neighbours are (a lone bright pixel would fade otherwise), and
// what is inside stays as it is to the bit.
vec3 clamp_to_neighbours(ivec2 p, vec3 past, float scale) {
    vec3 sum = vec3(0.0), squares = vec3(0.0);
    float weights = 0.0;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            const float weight = exp(-0.75 * float(x * x + y * y));
            const vec3 c = to_box_axes(current(p + ivec2(x, y)));
            sum += weight * c;
            squares += weight * c * c;
            weights += weight;
        }
    const vec3 mean = sum / weights;
    const vec3 half_box = scale * sqrt(max(squares / weights - mean * mean, 0.0));
    vec3 low = mean - half_box, high = mean + half_box;
    if (FORM == FORM_ROBUST) {
        const vec3 c = to_box_axes(current(p));
        low = min(low, c);
        high = max(high, c);
    }
    const vec3 before = to_box_axes(past), inside = clamp(before, low, high);
    return BOX != BOX_RGB && inside == before ? past : from_box_axes(inside);
}

// The history at a position, and for how many frames it stands; 0: there is none.
struct Past {
    vec3 color;
    float frames;
    bool thin;  // it may have shown something thinner than a pixel that is not seen now
};

float frames_of(float alpha) { return floor(alpha * float(MAX_FRAMES) + 0.5); }

// The plane of what a pixel shows: a point that the previous frame saw at `uv` (without jitter), z in front of the camera,
// is off it by (z - depth_change) * (slope.z + slope.xy . uv) + offset.z + offset.xy . uv metres. Moved back by the surface's
// own motion the point is one of the current view, where positions are linear in uv and bilinear with z.
struct Plane {
    vec3 slope, offset;
    vec2 depth_change;  // previous - current view depth: of a still surface, and as the host's motion says (0 if it does not)
    float tolerance_m;
};

Plane plane_at(ivec2 p, float z) {
    const vec3 point = position(p, z), moved = texelFetch(motion, p, 0).xyz;
    const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
    const vec3 corner0 = position_at(vec2(0.0), 0.0), corner1 = position_at(vec2(0.0), 1.0);
    const vec3 offset = vec3(dot(n, position_at(vec2(1.0, 0.0), 0.0) - corner0),
                             dot(n, position_at(vec2(0.0, 1.0), 0.0) - corner0), dot(n, corner0 - point));
    const vec3 both = vec3(dot(n, position_at(vec2(1.0, 0.0), 1.0) - corner1),
                           dot(n, position_at(vec2(0.0, 1.0), 1.0) - corner1), dot(n, corner1 - point));
    const vec3 slope = both - offset;
    return Plane(slope - vec3(0.0, 0.0, dot(slope.xy, moved.xy)), offset - vec3(0.0, 0.0, dot(offset.xy, moved.xy)),
                 vec2(previous_depth(point) - z, moved.z), params.plane_tolerance * pixel_span_m(z));
}

// Comparisons that a NaN fails.
bool was_seen(Plane plane, vec2 uv, float z) {
    const float slope = plane.slope.z + dot(plane.slope.xy, uv), offset = plane.offset.z + dot(plane.offset.xy, uv);
    const vec2 off = abs((z - plane.depth_change) * slope + offset);
    return off.x <= plane.tolerance_m || off.y <= plane.tolerance_m;
}

// What is seen around the pixel now: two surfaces and perhaps the sky.
struct Seen {
    Plane front, back;
    bool solid, sky;
};

// Whether a texel of the previous frame showed any of it.
bool showed(Seen seen, ivec2 t) {
    const float z = imageLoad(view_depth_prev, t).x;
    const vec2 uv = (vec2(t) + 0.5) / vec2(frame.prev_size) - frame.prev_jitter;
    const bool surface = seen.solid && (was_seen(seen.front, uv, z) || was_seen(seen.back, uv, z));
    return z > 0.0 ? surface : seen.sky;
}

// What is thinner than a pixel comes and goes with the jitter: gone from all nine pixels, it is still no surface that went
// away if what is seen now was seen on both sides of it. Should it have gone all the same, its colour must not stay: what
// lies between the mean around the pixel and the pixel's own colour does.
bool was_thin(Seen seen, ivec2 t, ivec2 last) {
    bool thin = false;
    for (int axis = 0; axis < 2; ++axis) {
        const ivec2 side = axis == 0 ? ivec2(1, 0) : ivec2(0, 1);
        const bool both = showed(seen, clamp(t - side, ivec2(0), last)) && showed(seen, clamp(t + side, ivec2(0), last));
        thin = thin || both;
    }
    return thin;
}

// An edge of the picture alternates with the jitter between what is in front and what is behind, so a texel may have shown
// either. Where one of the four around the position showed something else, the largest share of the others stands for all.
Past past_among(vec2 texel, Around around) {
    const Seen seen = Seen(plane_at(around.nearest, around.nearest_depth), plane_at(around.farthest, around.farthest_depth),
                           around.farthest_depth > 0.0, around.sky);
    const ivec2 last = ivec2(frame.prev_size) - 1, base = ivec2(floor(texel - 0.5));
    // Rounding must not turn "exactly there" into a neighbour's tiny share.
    const float SUBTEXELS = 256.0;
    const vec2 f = floor((texel - 0.5 - vec2(base)) * SUBTEXELS + 0.5) / SUBTEXELS;
    ivec2 best = ivec2(0);
    float best_share = 0.0, shares = 0.0;
    for (int i = 0; i < 4; ++i) {
        const ivec2 offset = ivec2(i & 1, i >> 1);
        const vec2 axes = mix(1.0 - f, f, vec2(offset));
        const ivec2 t = clamp(base + offset, ivec2(0), last);
        const float share = showed(seen, t) ? axes.x * axes.y : 0.0;
        best = share > best_share ? t : best;
        best_share = max(best_share, share);
        shares += share;
    }
    const ivec2 nearest = clamp(ivec2(floor(texel)), ivec2(0), last);
    const bool none = best_share < 0.05, thin = none && was_thin(seen, nearest, last);
    const vec4 value = texelFetch(history, none ? nearest : best, 0);
    // The shares of four that count are 1, exactly: they are multiples of 2^-16.
    const bool between = best_share < 1.0 && shares == 1.0;
    return Past(between ? history_at(texel) : value.xyz, none && !thin ? 0.0 : frames_of(value.w), thin);
}

// Where nothing moves, the texel's own is all that is asked.
Past past_at(vec2 texel, Around around) {
    if (HAS_VIEW_DEPTH_PREV) return past_among(texel, around);
    const vec4 value = texelFetch(history, ivec2(texel), 0);
    return Past(value.xyz, frames_of(value.w), false);
}

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
