// SPDX-License-Identifier: MIT
// First pass of the denoiser: what this frame's rays say about each pixel (common/this_frame.glsl), beside what the
// previous frame knew about the same surface (common/shadow_past.glsl), and how the two differ, summed over cells of 4x4
// pixels for the drift test. Cells with nothing but equal bits in reach are what these say. The others are looked at
// (what blocks, which bits are around), then their pixels ask their neighbours, dealt out one by one because a cell has one
// that asks or sixteen, and then their cells compare; an invocation owns a cell, and they wait for each other in between.
#include "node.glsl"
#include "common/tiles.glsl"
#include "common/rounded.glsl"
#include "common/camera.glsl"
#include "common/guide_normal.glsl"
#include "common/pixels.glsl"
#include "common/dithered.glsl"
#include "common/own_rays.glsl"
#include "common/shadow_state.glsl"
#include "common/light_space.glsl"
#include "common/corners.glsl"
#include "common/shadow_past.glsl"
#include "common/sheared_gather.glsl"
#include "common/working_cells.glsl"

const int R = RADIUS;
#include "common/bit_rows.glsl"
#include "common/this_frame.glsl"
#include "common/penumbra_around.glsl"
#include "common/frame_residuals.glsl"

// Of the variance between the texels that the past is resampled from: what resampling adds to its error. Over the
// penumbra's radius in pixels; both numbers minimise the shots' error (docs/denoiser.md).
const float RESAMPLING_SHARE = 0.5, LARGEST_SHARE = 3.0;
const float NARROW_PX = 0.75;    // radius below which a young past is judged by the edge beside it
const float DOUBTED = 2.0;       // frames: a past that drift leaves fewer is one that it does not believe
const float OWN_SPREAD = 0.005;  // v (1 - v) to hold against what resampling does to the own rays' mean
const float NEW_RESIDUAL = 0.2;  // weight of a frame in the running mean of the residual

// Have the rays of some pixel of a cell, all of which say `lit` now, said something else? Then there is a thin or faint
// penumbra, and one frame's agreement is no reason to forget it. One motion serves the whole cell: under a camera that moves
// hardly anything stays faint for long. Cells that were idle know without a look at their pixels.
bool past_disagrees(ivec2 first, bool lit) {
    if ((frame.flags & FRAME_RESET) != 0u) return false;
    const ivec2 last = ivec2(frame.prev_size) - 1;
    ivec2 there = first;
#if HAS_MOTION
    const ivec2 middle = min(first + CELL / 2, ivec2(frame.size) - 1);
    const Reprojection before = reproject(middle, texelFetch(motion, middle, 0).xy);
    if (!before.on_screen) return false;
    there += ivec2(floor(before.uv * vec2(frame.prev_size))) - middle;
#endif
    bool idled = true;
    for (int i = 0; i < 4; ++i) {
        const ivec2 q = clamp(there + (CELL - 1) * corner(i), ivec2(0), last);
        idled = idled && idled_as(idle_cells_prev[cell_index(q / CELL, frame.prev_size)], lit);
    }
    bool unlike = false;
    for (int i = 0; i < (idled ? 0 : CELL * CELL); ++i) {
        const ivec2 q = clamp(there + in_cell(i), ivec2(0), last);
        unlike = unlike || disagrees(imageLoad(history, q).x, lit);
    }
    return unlike;
}

// 1 = pixels that are lit, whatever the rays around say: no receivers, or their own rays' word.
uint lit_or_sky(ivec2 cell) {
    const uint tile = tile_index(cell * CELL / TILE);
    return visibility_words[tile] | ~receiver_words[tile];
}

mat3 light;           // to light space
ViewRays first_rays;  // around the workgroup's first pixel

ViewRays rays_of(ivec2 p) { return moved(first_rays, vec2(p - cell_of(0u) * CELL)); }
vec3 normal_at(ivec2 p) { return unit_or_zero(decode_normal(imageLoad(guide_normal, p))); }

// What is found out about the cells of the list, `at` their places in it; 13.5 KiB of the 16 that every device has.
const uint PIXELS = uint(CELL * CELL), MOST_PIXELS = MOST_CELLS * PIXELS;
shared vec3 cell_penumbrae[MOST_CELLS];
shared uint cell_rows[MOST_CELLS * uint(ROWS)];
shared uint cell_asking[MOST_CELLS];  // pixels that ask their neighbours, and what they are told:
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

// Of one pixel of a cell.
Footprint footprint_of_cell(ivec2 cell) {
    const ivec2 p = min(cell * CELL + CELL / 2, ivec2(frame.size) - 1);
    return footprint_of(rays_of(p), imageLoad(view_depth, p).x, light * normal_at(p));
}

void look_around(uint at, ivec2 cell) {
    load_rows(cell);
    [[unroll]] for (int i = 0; i < ROWS; ++i) cell_rows[at * uint(ROWS) + uint(i)] = rows[i];
    const Footprint foot = footprint_of_cell(cell);
    const Penumbra penumbra = penumbra_at(cell, foot);
    cell_penumbrae[at] = vec3(penumbra.distance_m, penumbra.tangent, penumbra.spread);
    uint asking = pixels_with_both();
    cell_asking[at] = asking;
    const uint n = uint(bitCount(asking));
    const bool wide = radius_m(penumbra) >= OWN_RAY_PX * foot.s.s2;  // it takes many rays; only who works beside whom depends on it
    uint next = wide ? atomicAdd(wide_count, n) : MOST_PIXELS - n - atomicAdd(narrow_count, n);
    for (; asking != 0u; asking &= asking - 1u) asking_pixels[next++] = PIXELS * at + uint(findLSB(asking));
}

void ask_around(uint asking) {
    const uint at = asking / PIXELS, pixel = asking % PIXELS;
    recall_rows(at);
    const ivec2 offset = in_cell(int(pixel)), p = cell_of(left_cells[at]) * CELL + offset;
    const Receiver r = receiver_at(p, offset, imageLoad(view_depth, p).x, light * normal_at(p), rays_of(p));
    estimates[asking] = pack_estimate(this_frame(r, penumbra_of(at)));
}

bool is_settled(ivec2 cell, bool below_last) {
    const ivec2 first = cell * CELL;
    if (below_last)
        load_rows_below(cell);
    else
        load_rows(cell);
    const uint said = said_within(R);
    bool works = has_both(said);
    for (int i = 0; i < (!works && said != 0u ? 1 : 0); ++i) works = past_disagrees(first, (said & 0xffffu) != 0u);

    const uint lit = lit_or_sky(cell);
    // Counted by what there is to do: older software devices run both sides of a branch, but no loop that no lane enters.
    uint idle = 0u;
    for (int i = 0; i < (works ? 0 : CELL * CELL); ++i) {
        const ivec2 offset = in_cell(i), p = first + offset;
        const bool bit = (lit & pixel_bit(p)) != 0u, tests = is_tested(offset + R);
        idle |= ((bit ? 1u : 0u) | (tests ? 0x10000u : 0u)) << uint(i);
        // Packed when this is compiled.
        const uvec2 g = bit ? pack_gathered(Gathered(1.0, 1.0, IDLE_COUNT, 0.0, 0.0, false, NO_RAYS), 0u)
                            : pack_gathered(Gathered(0.0, 0.0, IDLE_COUNT, 0.0, 0.0, false, NO_RAYS), 0u);
        imageStore(gathered, p, uvec4(g | uvec2(0u, tests ? TESTED : 0u), 0u, 0u));
    }
    idle_cells[cell_index(cell)] = works ? NOT_IDLE : idle;
    if (!works) {  // nothing to doubt
        cells[2u * cell_index(cell)] = vec4(0.0);
        cells[2u * cell_index(cell) + 1u] = vec4(0.0);
    }
    return !works;
}

void work_on(uint at, ivec2 cell) {
    const ivec2 first = cell * CELL;
    const uint asking = cell_asking[at];
    recall_rows(at);
    const uint lit = lit_or_sky(cell);
#if HAS_MOTION
    const ViewRays before = previous_rays(light);
#endif
    const Penumbra penumbra = penumbra_of(at);
    const float rho = radius_m(penumbra);

    Sums sums = Sums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    Bias bias = Bias(0.0, 0.0, 0.0, 0.0);
    vec2 steps = vec2(1e9);  // light-space pixel sizes
    float largest = 0.0, seen_m2 = 0.0;  // by the sun, of the cell's pixels
    int pairs = 0, pasts = 0;
    float radii = 0.0, by_counts = 0.0;  // over these
    int tested_pixels = 0;
    bool resampled = false;
    for (int i = 0; i < CELL * CELL; ++i) {
        const ivec2 offset = in_cell(i), p = first + offset;
        const float bit = (lit & pixel_bit(p)) != 0u ? 1.0 : 0.0;
        Gathered g = Gathered(bit, bit, 0.0, 0.0, 0.0, false, NO_RAYS);
        if (is_tested(offset + R)) {
            const float z = imageLoad(view_depth, p).x;
            const vec3 n = normal_at(p), n_light = light * n;
            const ViewRays rays = rays_of(p);
            const Receiver r = receiver_at(p, offset, z, n_light, rays);
            const Footprint foot = r.foot;
            const bool asked = (asking >> uint(i) & 1u) != 0u;
            Estimate now;
            if (asked) now = unpack_estimate(estimates[PIXELS * at + uint(i)]);
            for (int k = 0; k < (asked ? 0 : 1); ++k) now = agreement(r, reach_of(foot.s, penumbra).box);
#if HAS_MOTION
            const Surface then = Surface(off_plane(before, n_light, rays.o + z * rays.r), r.surface.tolerance_m);
            Past past = under_this_sun(past_of(p, n, then));
#else
            Past past = under_this_sun(past_of(p));
#endif
            const float radius_px = rho / max(foot.s.s1, 1e-9);
            const float resampling = min(RESAMPLING_SHARE / max(radius_px, 1e-3), LARGEST_SHARE) * past.variance;
            if (past.count < DOUBTED) past.own.count = 0.0;
            add_pixel(bias, past, now);
            resampled = resampled || past.resampled;
            past.count = min(past.count, squared_error(now) / max(resampling, 1e-6));
            past.own.count = min(past.own.count, OWN_SPREAD / max(resampling, 1e-6));
            steps = min(steps, vec2(length(foot.tangents[0].xy), length(foot.tangents[1].xy)));
            largest = max(largest, foot.s.s1);
            ++tested_pixels;
            seen_m2 += foot.s.s1 * foot.s.s2;
            pairs += differs(r, ivec2(1, 0)) + differs(r, ivec2(0, 1));

            g = Gathered(now.visibility, past.count > 0.0 ? past.visibility : now.visibility, past.count, 0.0,
                         sqrt(squared_error(now)), true, with_ray(past.own, bit > 0.5));
            if (past.count > 0.0) {
                const float d = g.now - g.past;
                g.residual = past.residual + NEW_RESIDUAL * (d - past.residual);
                const float variance = null_variance(now, past, rho / max(foot.s.s2, 1e-9));
                ++pasts;
                radii += rho / max(foot.s.s2, 1e-9);
                by_counts += 1.0 / past.count;
                sums.d += d;
                sums.e += g.residual;
                sums.v += variance;
                sums.d2 += d * d;
                sums.e2 += g.residual * g.residual;
                sums.c += variance * (1.0 + 0.5 * (now.rays - 1.0));
            }
        }
        imageStore(gathered, p, uvec4(pack_gathered(g, thresholds_at(p)), 0u, 0u));
    }
    const float by_pasts = 1.0 / float(max(pasts, 1));
    if (pasts > 0 && radii * by_pasts < NARROW_PX) {
        const float flips = flips_of(pairs, radii * by_pasts, by_counts * by_pasts);
        sums.c += max(flips - sums.v, 0.0);  // where it counts there is one ray
        sums.v = max(sums.v, flips);
    }
    const vec2 reach = rho > 0.0 ? min(0.25 * rho / max(steps, vec2(1e-9)), 6.0) : vec2(0.0);
    const float radius_px = rho > 0.0 && largest > 0.0 ? rho / largest : 0.0;
    // Rays per frame that test a pixel's disc: its area in pixels. Without blockers there is no disc to miss.
    float tests = rho > 0.0 ? 3.1415927 * rho * rho * float(tested_pixels) / max(seen_m2, 1e-20) : ALWAYS_TESTED;
    uint past_kind = resampled ? PAST_RESAMPLED : PAST_WHOLE;
#if !HAS_MOTION && !HAS_SUN_PREV
    past_kind = PAST_CERTAIN;
    sums = Sums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0);  // nothing can have changed, so nothing says that it has
#endif
    cells[2u * cell_index(cell)] = vec4(sums.d, sums.e, sums.v, sums.d2);
    const uint softening = pack_softening(ivec2(reach), past_kind, has_both(said_within(1)), tests, mean_bias(bias));
    cells[2u * cell_index(cell) + 1u] = vec4(sums.e2, sums.c, radius_px, uintBitsToFloat(softening));
}

void main() {
    light = transpose(sun_frame(sun.to_sun));
    first_rays = view_rays(cell_of(0u) * CELL, light);
    if (gl_LocalInvocationIndex == 0u) wide_count = narrow_count = 0u;
    settle_cells();
    const uint lane = gl_LocalInvocationIndex, lanes = lanes_in_workgroup();
    for (uint i = lane; i < left_count; i += lanes) look_around(i, cell_of(left_cells[i]));
    barrier();
    const uint wide = wide_count, n = wide + narrow_count;
    for (uint i = lane; i < n; i += lanes) ask_around(asking_pixels[i < wide ? i : i + MOST_PIXELS - n]);
    barrier();
    for (uint i = lane; i < left_count; i += lanes) work_on(i, cell_of(left_cells[i]));
}
