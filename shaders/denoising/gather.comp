// SPDX-License-Identifier: MIT
// First pass of the denoiser: what this frame's rays say about each pixel (this_frame.glsl), beside what the
// previous frame knew about the same surface (shadow_past.glsl), and how the two differ, summed over cells of 4x4
// pixels for the drift test. Cells with nothing but equal bits in reach are what these say. The others are looked at
// (what blocks, which bits are around), then their pixels ask their neighbours, dealt out one by one because a cell has one
// that asks or sixteen, and then compare, row by row of a cell; those of a workgroup that do not run in step wait for each
// other in between.
#extension GL_KHR_shader_subgroup_shuffle : require
#include "node.glsl"
#include "common/tiles.glsl"
#include "common/rounded.glsl"
#include "common/camera.glsl"
#include "common/guide_normal.glsl"
#include "denoising/many_rays.glsl"
#include "common/dithered.glsl"
#include "common/own_rays.glsl"
#include "common/shadow_state.glsl"
#include "denoising/light_space.glsl"
#include "common/light.glsl"
#include "common/light_axes.glsl"
#include "denoising/lamp_space.glsl"
#include "common/corners.glsl"
#include "denoising/shadow_past.glsl"
#include "denoising/sheared_gather.glsl"
#include "denoising/working_cells.glsl"

const int R = RADIUS;
#include "denoising/bit_rows.glsl"
#include "denoising/further_rays.glsl"
#include "denoising/frame_worth.glsl"
#include "denoising/this_frame.glsl"
#include "denoising/penumbra_around.glsl"
#include "denoising/frame_residuals.glsl"

// 1 = pixels that are lit, whatever the rays around say: no receivers, or their own rays' word.
uint lit_or_sky(ivec2 cell) {
    const uint tile = tile_index(cell * CELL / TILE);
    return visibility_words[tile] | ~receiver_words[tile];
}

// What all of a workgroup see by: 45 numbers that every lane of a GPU would hold in registers of its own.
struct Views {
    mat3 towards_light;    // to the sun's light space; where the light is near, world axes (lamp_space.glsl)
    ViewRays now, before;  // around first_pixel(), and of the previous frame
};
Views own_views;
shared Views shared_views;
Views views() {
    if (ON_CPU) return own_views;
    return shared_views;
}

// Every 32 pixels, whatever a workgroup's share: what is computed from here is then rounded alike on every device.
ivec2 first_pixel() { return cell_of(0u) * CELL & ~31; }
ViewRays rays_of(ivec2 p) { return moved(views().now, vec2(p - first_pixel())); }
vec3 normal_at(ivec2 p) { return unit_or_zero(decode_normal(imageLoad(guide_normal, p))); }

// What is found out about the cells of the list, `at` their places in it: 200 bytes of a cell at most, on a GPU with row_sums 500, of whose
// 16 cells that is half of what every device has.
const uint PIXELS = uint(CELL * CELL), MOST_PIXELS = MOST_CELLS * PIXELS;
shared vec3 cell_penumbrae[MOST_CELLS];
shared uint cell_rows[MOST_CELLS * uint(ROWS)];
const uint UNLIKE = 0x10000u;         // unlike pixels are among a cell's own and those next to it
shared uint cell_asking[MOST_CELLS];  // that, and in the lower half the pixels that ask their neighbours, and what they are told:
shared uint estimates[MOST_PIXELS];
shared uint wide_count, narrow_count;
shared uint asking_pixels[MOST_PIXELS];  // 16 cell + pixel; in wide penumbrae from the front, in narrow ones from the back

Penumbra penumbra_of(uint at) {
    const vec3 p = cell_penumbrae[at];
    return Penumbra(p.x, p.y, p.z);
}

void recall_rows(uint at) {
    [[unroll]] for (int i = 0; i < ROWS; ++i) rows[i] = cell_rows[at * uint(ROWS) + uint(i)];
}

// Of a cell, by one of its pixels.
Penumbra penumbra_of_cell(ivec2 cell, out Footprint foot) {
    const ivec2 p = min(cell * CELL + CELL / 2, ivec2(frame.size) - 1);
    const ViewRays rays = rays_of(p);
    const float z = imageLoad(view_depth, p).x;
    const vec3 n = views().towards_light * normal_at(p);
    const LampSpace lamp = lamp_space_at(rays.o + z * rays.r, n);
    foot = footprint_of(lamp, tangents(rays, z, n));
    Penumbra penumbra = penumbra_at(cell, foot);
    if (HAS_RAY_POINTS && penumbra.distance_m <= 0.0 && (sunward_words[tile_index(p / TILE)] & pixel_bit(p)) != 0u) {
        const float above = (HAS_LIGHT ? horizon_of(lamp.horizon, 1.0) : horizon_of(n, tan(sun.angular_radius))).above;
        if (above > 0.0 && above < 1.0) penumbra.spread = CUT;
    }
    return penumbra;
}

void look_around(uint at, ivec2 cell) {
    load_rows(cell);
    [[unroll]] for (int i = 0; i < ROWS; ++i) cell_rows[at * uint(ROWS) + uint(i)] = rows[i];
    Footprint foot;
    const Penumbra penumbra = penumbra_of_cell(cell, foot);
    cell_penumbrae[at] = vec3(penumbra.distance_m, penumbra.tangent, penumbra.spread);
    uint asking = pixels_with_both() & pixels_of_cell(sunward_words[tile_index(cell * CELL / TILE)], cell);
    cell_asking[at] = asking | (has_both(said_within(1)) ? UNLIKE : 0u);
    const uint n = uint(bitCount(asking));
    const bool wide = radius_m(penumbra) >= OWN_RAY_PX * foot.s.s2;  // it takes many rays; only who works beside whom depends on it
    uint next = wide ? atomicAdd(wide_count, n) : MOST_PIXELS - n - atomicAdd(narrow_count, n);
    for (; asking != 0u; asking &= asking - 1u) asking_pixels[next++] = PIXELS * at + uint(findLSB(asking));
}

void ask_around(uint asking) {
    const uint at = asking / PIXELS, pixel = asking % PIXELS;
    const ivec2 offset = in_cell(int(pixel)), p = cell_of(left_cells[at]) * CELL + offset;
    [[unroll]] for (int i = 0; i <= 2 * R; ++i) rows[i] = cell_rows[at * uint(ROWS) + uint(offset.y + i)];
    const Receiver r = receiver_at(p, ivec2(offset.x, 0), imageLoad(view_depth, p).x, views().towards_light * normal_at(p), rays_of(p));
    const Estimate e = this_frame(r, penumbra_of(at));
    estimates[asking] = MANY_RAYS ? pack_estimate_of_many(e) : pack_estimate(e);
}

#include "denoising/settled_cell.glsl"
#include "denoising/compared_cell.glsl"

void main() {
    if (!anything_looks()) {
        settle_unasked_cells();
        return;
    }
    own_views.towards_light = HAS_LIGHT ? mat3(1.0) : transpose(sun_frame(sun.to_sun));
    own_views.now = view_rays(first_pixel(), own_views.towards_light);
    if (HAS_MOTION) own_views.before = previous_rays(own_views.towards_light);
    if (gl_LocalInvocationIndex == 0u) {
        if (!ON_CPU) shared_views = own_views;
        wide_count = narrow_count = 0u;
    }
    settle_cells();
    const uint lane = gl_LocalInvocationIndex, lanes = lanes_in_workgroup();
    for (uint i = lane; i < left_count; i += lanes) look_around(i, cell_of(left_cells[i]));
    group_barrier();
    const uint wide = wide_count, n = wide + narrow_count;
    for (uint i = lane; i < n; i += lanes) ask_around(asking_pixels[i < wide ? i : i + MOST_PIXELS - n]);
    group_barrier();
    compare_cells();
}
