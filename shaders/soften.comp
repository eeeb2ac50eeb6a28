// SPDX-License-Identifier: MIT
// Third pass of the denoiser, not fed back: 3x3 taps a quarter of the penumbra's radius apart, which is too near
// to blur it much, and fading as the past grows, which needs it less and less. Per image axis, because a penumbra on a
// surface that is seen at a grazing angle is much narrower on one. Below a pixel, where there is nothing to blur and no
// neighbour's ray to count, what 3x3 bits say together (common/edge_pattern.glsl). An invocation owns a cell of 4x4 pixels.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/guide_normal.glsl"
#include "common/pixels.glsl"
#include "common/previous_surface.glsl"
#include "common/edge_pattern.glsl"
#include "common/rounded.glsl"
#include "common/dithered.glsl"
#include "common/own_rays.glsl"
#include "common/shadow_state.glsl"
#include "common/sun_sample.glsl"
#include "common/light_space.glsl"
#include "common/tiles.glsl"
#include "common/working_cells.glsl"

const int R = 1;  // a pattern's
#include "common/bit_rows.glsl"

const float SIDE = 0.75;             // kernel: .75, 1, .75 per axis
const float NEIGHBOURS = 0.9;        // weight of the neighbours on the first frame,
const float FADING = 0.3;            // and how fast it falls with the count
// Radius of a penumbra in pixels, up to which the bits around are asked as a pattern; beyond it they fade out. From
// OWN_RAY_PX on gather asks them, too, and what it says is worth as many rays as test the pixel's disc, but for some.
const float NARROW = 1.5, WIDEST = 2.0, RAYS_LOST = 3.0;
// Rays in the pixel's disc from which on the past is worth as much as the own ray where the edge is hard: where most of the
// pixels at its sides say the same, and where they do not. Frames that the own rays have gone undoubted for, from which on
// nothing moves there, by what the past is (shadow_state.glsl). All of them minimise the shots' error (docs/denoiser.md).
const float TESTS_WORTH_A_RAY = 0.19, TESTS_WORTH_AN_ODD_RAY = 0.04, UNMOVED[3] = float[3](1.0, 2.0, 9.0);
const uint SIDES = 0x0aau;
const float OWN_PLANE_PX = 0.5;

// What the past says of an edge is as good as the number of rays that have tested the pixel's own disc. Where that is much
// smaller than a pixel hardly any has, and what is there was resampled from pixels on either side of the edge. The own ray
// has: it is wrong only inside the penumbra, where such a pixel seldom lies, the less so if its sides agree with it.
// `frames`: that the past stands for; it gains less than they are, because what has been resampled goes on being resampled.
float trust_of_past(float tests, float frames, float unmoved, uint pattern) {
    const int lit = bitCount(pattern & SIDES), unlike = (pattern & PATTERN_CENTRE) != 0u ? 4 - lit : lit;
    const float tested = tests * sqrt(frames) * (1.0 + unmoved * unmoved * unmoved * unmoved);
    return tested / (tested + (unlike < 2 ? TESTS_WORTH_A_RAY : TESTS_WORTH_AN_ODD_RAY));
}

float softened(ivec2 p, ivec2 steps, ShadowState own, ViewRays rays) {
    const float z = imageLoad(view_depth, p).x;
    const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
    const OffPlane plane = off_plane(rays, n, rays.o + z * rays.r);
    const float tolerance_m = params.plane_tolerance * pixel_span_m(z);
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
            const bool same =
                has_count(word) && abs(metres_off(plane, vec2(offset), imageLoad(view_depth, q).x)) <= tolerance_m;
            const float w = same ? weight * (x == 0 ? 1.0 : SIDE) * (y == 0 ? 1.0 : SIDE) : 0.0;
            sum += w * visibility_in(word);
            weights += w;
        }
    return sum / weights;
}

// Which of 3x3 pixels show the pixel's surface: the diagonal neighbours are asked, and stand for the sides next to them.
uint surface_seen(ivec2 p, ViewRays rays) {
    const uint CORNERS[4] = uint[4](0x00bu, 0x026u, 0x0c8u, 0x1a0u);
    const float z = imageLoad(view_depth, p).x, tolerance_m = OWN_PLANE_PX * pixel_span_m(z);
    const OffPlane plane = off_plane(rays, decode_normal(imageLoad(guide_normal, p)), rays.o + z * rays.r);
    const ivec2 last = ivec2(frame.size) - 1;
    uint surface = WHOLE_PATTERN;
    for (int i = 0; i < 4; ++i) {
        const ivec2 q = clamp(p + 2 * ivec2(i & 1, i >> 1) - 1, ivec2(0), last);
        if (!(abs(metres_off(plane, vec2(q - p), imageLoad(view_depth, q).x)) <= tolerance_m)) surface &= ~CORNERS[i];
    }
    return surface;
}

// The nine bits of a pixel of the cell, and which of them are of receivers.
uvec2 bits_of(ivec2 offset) {
    uvec2 nine = uvec2(0u);
    for (int i = 0; i < 3; ++i) nine |= (uvec2(rows[offset.y + i], rows[offset.y + i] >> 16) >> uint(offset.x) & 7u) << 3 * i;
    return nine;
}

// What there is to do in a cell.
struct Softening {
    ivec2 steps;
    float bias;
    float tests;       // rays per frame in a pixel's disc
    float by_unmoved;  // per frame that the own rays have gone undoubted
    float rays;        // that a frame's word is worth beside a pattern's
    float fade;        // of the patterns, 0: they are not asked
};

Softening softening_of(ivec2 cell) {
    const vec2 size = cells[2u * cell_index(cell) + 1u].zw;
    const uint word = floatBitsToUint(size.y);
    // Where all bits agree, so do the patterns.
    const float fade = unlike_in(word) ? clamp((WIDEST - size.x) / (WIDEST - NARROW), 0.0, 1.0) : 0.0;
    const float tests = tests_of(word);
    const bool asked = size.x > 0.0 && tests >= 3.1415927 * size.x * OWN_RAY_PX;  // by the disc's larger radius
    return Softening(steps_of(word), bias_of(word), tests, 1.0 / UNMOVED[past_kind_of(word)],
                     asked ? max(tests - RAYS_LOST, 1.0) : 1.0, fade);
}

bool is_settled(ivec2 cell, bool) {
    const uint idle = idle_cells[cell_index(cell)];
    const Softening s = softening_of(cell);
    const bool settled = is_idle(idle) || (s.steps.x | s.steps.y) == 0 && s.fade <= 0.0 && s.bias <= 0.0;
    for (int i = 0; i < (settled ? CELL * CELL : 0); ++i) {
        const ivec2 p = cell * CELL + ivec2(i & 3, i >> 2);
        float v = float(idle >> uint(i) & 1u);
        if (!is_idle(idle)) v = visibility_in(imageLoad(state, p).x);
        imageStore(visibility, p, vec4(v));
    }
    return settled;
}

void work_on(ivec2 cell) {
    const ivec2 first = cell * CELL;
    const Softening s = softening_of(cell);
    const ivec2 steps = s.steps;
    const float bias = s.bias, fade = s.fade, tests = s.tests;
    for (int i = 0; i < (fade > 0.0 ? 1 : 0); ++i) load_rows(cell);
    const ViewRays corner = view_rays(first, mat3(1.0));
    for (int i = 0; i < CELL * CELL; ++i) {
        const ivec2 offset = ivec2(i & 3, i >> 2), p = first + offset;
        const ShadowState own = unpack_state(imageLoad(state, p).x);
        const ViewRays rays = moved(corner, vec2(offset));
        float v = own.visibility;
        const bool softens = own.count > 0.0 && (steps.x | steps.y) != 0;
        for (int k = 0; k < (softens ? 1 : 0); ++k) v = softened(p, steps, own, rays);
        for (int k = 0; k < (bias > 0.0 ? 1 : 0); ++k)
            v += trust(own.count) * bias / (bias + mean_variance(own.own) + 1e-9) * (own.own.visibility - own.visibility);
        float share = own.count > 0.0 ? fade * share_of_pattern(max(own.count, 1.0), s.rays, params.pattern_samples) : 0.0;
        if (share <= LEAST_SHARE) share = 0.0;
        const uvec2 nine = bits_of(offset);
        const bool mixed = (nine.x & nine.y) != 0u && (~nine.x & nine.y) != 0u;  // else the surface does not matter
        const bool doubts = own.count > 0.0 && fade > 0.0 && tests < ALWAYS_TESTED;
        uint known = nine.y;
        for (int k = 0; k < (mixed && (share > 0.0 || doubts) ? 1 : 0); ++k) known &= surface_seen(p, rays);
        const uint pattern = edge_pattern(nine.x, known);
        if (share > 0.0) v = mix(v, visibility_by_pattern(pattern), share);
        for (int k = 0; k < (doubts ? 1 : 0); ++k) {
            const float unmoved = own.own.count * s.by_unmoved;
            const float bit = (pattern & PATTERN_CENTRE) != 0u ? 1.0 : 0.0;
            v += fade * (1.0 - trust_of_past(tests, max(own.count, 1.0), unmoved, pattern)) * (bit - v);
        }
        imageStore(visibility, p, vec4(v));
    }
}

void main() {
    settle_cells();
    for (uint i = gl_LocalInvocationIndex; i < left_count; i += lanes_in_workgroup()) work_on(cell_of(left_cells[i]));
}
