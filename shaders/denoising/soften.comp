// SPDX-License-Identifier: MIT
// Third pass of the denoiser, not fed back: 3x3 taps a quarter of the penumbra's radius apart, which is too near
// to blur it much, and fading as the past grows, which needs it less and less. Per image axis, because a penumbra on a
// surface that is seen at a grazing angle is much narrower on one. Where it is narrow, and no neighbour's ray or few to count,
// what 3x3 bits say together (edge_pattern.glsl). An invocation owns a cell of 4x4 pixels.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/guide_normal.glsl"
#include "common/rounded.glsl"
#include "denoising/many_rays.glsl"
#include "common/dithered.glsl"
#include "common/own_rays.glsl"
#include "common/shadow_state.glsl"
#include "common/view_rays.glsl"
#include "common/corners.glsl"
#include "common/tiles.glsl"
#include "denoising/working_cells.glsl"

const int R = 1;  // a pattern's
#include "denoising/bit_rows.glsl"
#include "denoising/further_bits.glsl"
#include "denoising/edge_pattern.glsl"
#include "denoising/soft_taps.glsl"

// Radius of a penumbra in pixels, up to which the bits around are asked as a pattern; beyond it they fade out. From
// OWN_RAY_PX on gather asks them, too, and what it says is worth as many rays as test the pixel's disc, but for some.
const float NARROW = 1.5, WIDEST = 2.0, RAYS_LOST = 3.0;

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
    const uint idle = idle_word(idle_cells[cell_index(cell)]);
    bool settled = is_idle(idle);
    if (!settled) {  // else there is nothing in cells
        const Softening s = softening_of(cell);
        settled = (s.steps.x | s.steps.y) == 0 && s.fade <= 0.0 && s.bias <= 0.0;
    }
    if (!settled) return false;
    for (int y = 0; y < CELL; ++y) {
        const ivec2 p = cell * CELL + ivec2(0, y);
        vec4 row = vec4(uvec4(idle) >> uvec4(0u, 1u, 2u, 3u) + uint(CELL * y) & 1u);
        if (!is_idle(idle))
            for (int x = 0; x < CELL; ++x) row[x] = visibility_in(imageLoad(state, p + ivec2(x, 0)).x);
        store4_visibility(p, row);
    }
    return true;
}

void work_on(ivec2 cell) {
    const ivec2 first = cell * CELL;
    const Softening s = softening_of(cell);
    const ivec2 steps = s.steps;
    const float bias = s.bias, fade = s.fade, tests = s.tests;
    if (fade > 0.0) load_rows(cell);
    const ViewRays corner = view_rays(first, mat3(1.0));
    vec4 row = vec4(0.0);
    for (int i = 0; i < CELL * CELL; ++i) {
        const ivec2 offset = in_cell(i), p = first + offset;
        const ShadowState own = unpack_state(imageLoad(state, p).x);
        const ViewRays rays = moved(corner, vec2(offset));
        float v = own.visibility;
        const bool softens = own.count > 0.0 && (steps.x | steps.y) != 0;
        if (softens) v = softened(p, steps, own, rays);
        if (bias > 0.0)
            v = clamp(v + trust(own.count) * bias / (bias + mean_variance(own.own) + 1e-9) * (own.own.visibility - own.visibility), 0.0, 1.0);
        const bool tested = has_ray(p);
        const uint further = tested && fade > 0.0 ? further_at(p) : 0u;
        const float said = further == 0u ? s.rays : s.rays * even_worth(further);  // by this frame
        const bool asks = own.count > 0.0 && (!HAS_RAY_WORDS || tested);
        float share = asks ? fade * share_of_pattern(max(own.count, 1.0), said, params.pattern_samples) : 0.0;
        if (share <= LEAST_SHARE) share = 0.0;
        const uvec2 nine = bits_of(offset);
        const bool mixed = (nine.x & nine.y) != 0u && (~nine.x & nine.y) != 0u;  // else the surface does not matter
        const bool doubts = asks && fade > 0.0 && tests < ALWAYS_TESTED && !(MANY_RAYS && (further != 0u || s.by_unmoved > 0.9));
        uint known = nine.y;
        if (mixed && (share > 0.0 || doubts)) known &= surface_seen(p, rays);
        const uint pattern = edge_pattern(nine.x, known);
        if (share > 0.0) v = mix(v, visibility_by_pattern(pattern), share);
        if (doubts) {
            const float unmoved = own.own.count * s.by_unmoved;
            float bit = (pattern & PATTERN_CENTRE) != 0u ? 1.0 : 0.0;
            if (further != 0u) bit = lit_share(further, bit > 0.5);
            v += fade * (1.0 - trust_of_past(tests, max(own.count, 1.0), unmoved, pattern)) * (bit - v);
        }
        row[offset.x] = v;
        if (offset.x == CELL - 1) store4_visibility(first + ivec2(0, offset.y), row);
    }
}

void main() {
    settle_cells();
    for (uint i = gl_LocalInvocationIndex; i < left_count; i += lanes_in_workgroup()) work_on(cell_of(left_cells[i]));
}
