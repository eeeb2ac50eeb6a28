// SPDX-License-Identifier: MIT
// Last phase of gather: this frame beside the past, pixel by pixel, and what of their differences a cell hands on to drift and
// soften.
//
// Includer has shadow_past.glsl, this_frame.glsl and frame_residuals.glsl, and defines what gather.comp knows of its cells.

// Of the variance between the texels that the past is resampled from: what resampling adds to its error. Over the
// penumbra's radius in pixels; both numbers minimise the shots' error (docs/denoiser.md).
const float RESAMPLING_SHARE = 0.5, LARGEST_SHARE = 3.0;
const float NARROW_PX = 0.75;    // radius below which a young past is judged by the edge beside it
const float DOUBTED = 2.0;       // frames: a past that drift leaves fewer is one that it does not believe
const float OWN_SPREAD = 0.005;  // v (1 - v) to hold against what resampling does to the own rays' mean
const float NEW_RESIDUAL = 0.2;  // weight of a frame in the running mean of the residual

const float LEAST_REACH = 0.5;   // pixels, from which on a quarter of the penumbra's radius is softened over

// How far apart soften's taps are along an axis.
int step_for(float reach) { return reach >= 1.0 ? int(reach) : reach >= LEAST_REACH ? NEAR_STEP : 0; }

// What is added up over the pixels of a cell: first over those of a row, then over the rows in their order.
struct CellSums {
    Sums sums;
    Bias bias;
    vec2 steps;               // light-space pixel sizes, the least
    float largest, seen_m2;   // by the sun, of the pixels
    float flips_per_pair;     // a pixel of many rays does not flip
    float radii, by_counts;   // over those with a past
    uint counts;              // 8 bits each: pairs, pasts, tested pixels, and whether any past was resampled
};

const CellSums NOTHING_YET = CellSums(NO_SUMS, Bias(0.0, 0.0, 0.0, 0.0), vec2(1e9), 0.0, 0.0, 0.0, 0.0, 0.0, 0u);
const uint PAST = 1u << 8, TESTED_PIXEL = 1u << 16, RESAMPLED = 1u << 24;

void add(inout CellSums a, CellSums b) {
    a.sums = Sums(a.sums.d + b.sums.d, a.sums.e + b.sums.e, a.sums.v + b.sums.v, a.sums.d2 + b.sums.d2, a.sums.e2 + b.sums.e2, a.sums.c + b.sums.c);
    a.bias = Bias(a.bias.differences + b.bias.differences, a.bias.noise + b.bias.noise, a.bias.past_noise + b.bias.past_noise, a.bias.n + b.bias.n);
    a.steps = min(a.steps, b.steps);
    a.largest = max(a.largest, b.largest);
    a.seen_m2 += b.seen_m2;
    a.flips_per_pair += b.flips_per_pair;
    a.radii += b.radii;
    a.by_counts += b.by_counts;
    a.counts += b.counts;
}

#if CLASS_CPU
// A cell's rows are four lanes of a subgroup that stand side by side: a software device shuffles in a tenth of the time of a
// load from shared memory, which it does lane by lane.
float of_row(float own, uint row) { return subgroupShuffle(own, (gl_SubgroupInvocationID & ~3u) + row); }
uint of_row(uint own, uint row) { return subgroupShuffle(own, (gl_SubgroupInvocationID & ~3u) + row); }
vec2 of_row(vec2 own, uint row) { return vec2(of_row(own.x, row), of_row(own.y, row)); }

void recall_rows_together(uint at, uint row) {
    const int EACH = (ROWS + CELL - 1) / CELL;
    uint own[EACH];
    [[unroll]] for (int i = 0; i < EACH; ++i) own[i] = cell_rows[at * uint(ROWS) + min(row + uint(CELL * i), uint(ROWS - 1))];
    [[unroll]] for (int i = 0; i < ROWS; ++i) rows[i] = of_row(own[i / CELL], uint(i % CELL));
}

CellSums of_row(CellSums own, uint row) {
    return CellSums(Sums(of_row(own.sums.d, row), of_row(own.sums.e, row), of_row(own.sums.v, row), of_row(own.sums.d2, row),
                         of_row(own.sums.e2, row), of_row(own.sums.c, row)),
                    Bias(of_row(own.bias.differences, row), of_row(own.bias.noise, row), of_row(own.bias.past_noise, row),
                         of_row(own.bias.n, row)),
                    of_row(own.steps, row), of_row(own.largest, row), of_row(own.seen_m2, row), of_row(own.flips_per_pair, row),
                    of_row(own.radii, row), of_row(own.by_counts, row), of_row(own.counts, row));
}
#else
shared CellSums row_sums[MOST_CELLS * uint(CELL)];

void recall_rows_together(uint at, uint row) { recall_rows(at); }
#endif

CellSums compare_row(uint at, ivec2 cell, int row) {
    const ivec2 first = cell * CELL;
    const uint asking = cell_asking[at];
    recall_rows_together(at, uint(row));
    const uint tile = tile_index(cell * CELL / TILE), lit = lit_or_sky(cell), sunward = sunward_words[tile];
    uint traced = ~0u;
    if (HAS_RAY_WORDS) traced = ray_words[tile];
    const Penumbra penumbra = penumbra_of(at);
    const float rho = radius_m(penumbra);

    CellSums all = NOTHING_YET;
    vec4 worths = vec4(0.0);
    for (int i = CELL * row; i < CELL * (row + 1); ++i) {
        const ivec2 offset = in_cell(i), p = first + offset;
        const float bit = (lit & pixel_bit(p)) != 0u ? 1.0 : 0.0;
        Gathered g = Gathered(bit, bit, 0.0, 0.0, 0.0, false, NO_RAYS);
        float worth = 1.0;  // of this frame, in frames of one ray
        if ((sunward & pixel_bit(p)) != 0u) {
            const bool tested = (traced & pixel_bit(p)) != 0u;
            const uint further = tested ? further_at(p) : 0u;
            const float z = imageLoad(view_depth, p).x;
            const vec3 n = normal_at(p), n_light = views().towards_light * n;
            const ViewRays rays = rays_of(p);
            const Receiver r = receiver_at(p, offset, z, n_light, rays);
            const Footprint foot = r.foot;
            const bool asked = (asking >> uint(i) & 1u) != 0u;
            Estimate now;
            if (asked) {
                const uint word = estimates[PIXELS * at + uint(i)];
                if (MANY_RAYS)
                    now = unpack_estimate_of_many(word);
                else
                    now = unpack_estimate(word);
            } else {
                now = agreement(r, reach_of(foot.s, penumbra).box, is_cut(penumbra));
            }
            Past past;
            if (HAS_MOTION)
                past = past_of(p, n, z, Surface(off_plane(views().before, n_light, rays.o + z * rays.r), r.surface.tolerance_m));
            else
                past = past_of(p);
            past = under_this_light(past, rays.o + z * rays.r);
            const float radius_px = rho / max(foot.s.s1, 1e-9);
            const float resampling = min(RESAMPLING_SHARE / max(radius_px, 1e-3), LARGEST_SHARE) * past.variance;
            if (past.count < DOUBTED) past.own.count = 0.0;
            // Who has no ray trusts its past before what rays say that do not test its own disc.
            const bool told = now.rays > 0.0 && (tested || asked || past.count <= 0.0);
            worth = told ? frames_worth(now, further) : 0.0;
            const float shared_by = max(now.rays / now.each, 1.0);  // pixels whose rays it counts
            now = with_own(now, further, bit > 0.5);
            // The more this frame knows, the less it asks a past that could be over: what the own rays have said, which drift does not
            // test, and what has moved across the pixels. A past that stayed where it was is drift's to doubt: cut short whenever a
            // frame has several rays, it would never be a mean of rays that repel each other.
            if (MAY_CHANGE) {
                const float most = COUNT_CAP * inversesqrt(max(worth, 1.0));
                if (past.elsewhere) past.count = min(past.count, most);
                past.own.count = min(past.own.count, most);
                if (further != 0u) past.count = min(past.count, believed(past, further, bit > 0.5));
            }
            if (worth > 0.0) add_pixel(all.bias, past, now, worth);
            all.counts += TESTED_PIXEL + (past.resampled ? RESAMPLED : 0u);
            if (worth > 0.0) past.count = min(past.count, worth * squared_error(now) / max(resampling, 1e-6));
            past.own.count = min(past.own.count, OWN_SPREAD / max(resampling, 1e-6));
            all.steps = min(all.steps, vec2(length(foot.tangents[0].xy), length(foot.tangents[1].xy)));
            all.largest = max(all.largest, foot.s.s1);
            all.seen_m2 += foot.s.s1 * foot.s.s2;
            const int unlike = differs(r, ivec2(1, 0)) + differs(r, ivec2(0, 1));
            all.counts += uint(unlike);
            all.flips_per_pair += float(unlike) / max(worth, 1.0);

            OwnRays own = past.own;
            if (tested) own = with_rays(own, bit > 0.5, further == 0u ? bit : lit_share(further, bit > 0.5), own_worth(further));
            g = Gathered(now.visibility, past.count > 0.0 ? past.visibility : now.visibility, past.count, 0.0,
                         worth > 0.0 ? sqrt(max(squared_error(now), error_by_past(now, past))) : 0.5, true, own);
            worths[offset.x] = pack_worth(worth);
            if (worth <= 0.0) g.residual = past.residual;
            if (past.count > 0.0 && worth > 0.0) {
                const float d = g.now - g.past;
                g.residual = past.residual + NEW_RESIDUAL * (d - past.residual);
                const float across_px = rho / max(foot.s.s2, 1e-9);
                const float variance = null_variance(now, past, is_cut(penumbra) ? 1.0 : across_px, worth);  // as in a penumbra
                all.counts += PAST;
                all.radii += across_px;
                all.by_counts += 1.0 / past.count;
                all.sums.d += d;
                all.sums.e += g.residual;
                all.sums.v += variance;
                all.sums.d2 += d * d;
                all.sums.e2 += g.residual * g.residual;
                all.sums.c += variance * (1.0 + 0.5 * (shared_by - 1.0));
            }
        }
        // Whoever does not hand on what a frame is worth has drift take every one for one.
        store_gathered(p, uvec4(pack_gathered(g, HAS_FRAME_WORTH != 0 ? worth : 1.0, thresholds_at(p)), 0u, 0u));
    }
#if HAS_FRAME_WORTH
    store4_frame_worth(first + ivec2(0, row), worths);
#endif
    return all;
}

void hand_on(uint at, CellSums all) {
    const ivec2 cell = cell_of(left_cells[at]);
    const float rho = radius_m(penumbra_of(at));
    const int pairs = int(all.counts & 0xffu);
    const uint pasts = all.counts >> 8 & 0xffu, tested_pixels = all.counts >> 16 & 0xffu;
    Sums sums = all.sums;
    const float by_pasts = 1.0 / float(max(pasts, 1u));
    if (pasts > 0u && all.radii * by_pasts < NARROW_PX) {
        const float by_rays = pairs > 0 ? all.flips_per_pair / float(pairs) : 1.0;
        const float flips = by_rays * flips_of(pairs, all.radii * by_pasts, all.by_counts * by_pasts);
        sums.c += max(flips - sums.v, 0.0);  // where it counts hardly a neighbour's ray is asked
        sums.v = max(sums.v, flips);
    }
    const vec2 reach = rho > 0.0 ? min(0.25 * rho / max(all.steps, vec2(1e-9)), 6.0) : vec2(0.0);
    const float radius_px = rho > 0.0 && all.largest > 0.0 ? rho / all.largest : 0.0;
    // Rays per frame that test a pixel's disc: its area in pixels. Without blockers there is no disc to miss.
    float tests = rho > 0.0 ? 3.1415927 * rho * rho * float(tested_pixels) / max(all.seen_m2, 1e-20) : ALWAYS_TESTED;
    uint past_kind = all.counts >= RESAMPLED ? PAST_RESAMPLED : PAST_WHOLE;
    if (!MAY_CHANGE) {
        past_kind = PAST_CERTAIN;
        sums = NO_SUMS;  // nothing can have changed, so nothing says that it has
    }
    cells[2u * cell_index(cell)] = vec4(sums.d, sums.e, sums.v, sums.d2);
    const uint softening = pack_softening(ivec2(step_for(reach.x), step_for(reach.y)), past_kind, (cell_asking[at] & UNLIKE) != 0u, tests, mean_bias(all.bias));
    cells[2u * cell_index(cell) + 1u] = vec4(sums.e2, sums.c, radius_px, uintBitsToFloat(softening));
}

void compare_cells() {
    const uint lanes = lanes_in_workgroup(), n = left_count * uint(CELL);
    for (uint i = gl_LocalInvocationIndex; i < n; i += lanes) {
        const uint at = i / uint(CELL), row = i % uint(CELL);
        const CellSums own = compare_row(at, cell_of(left_cells[at]), int(row));
#if CLASS_CPU
        CellSums all = NOTHING_YET;
        [[unroll]] for (uint r = 0u; r < uint(CELL); ++r) add(all, of_row(own, r));
        if (row == 0u) hand_on(at, all);
#else
        row_sums[i] = own;
#endif
    }
#if !CLASS_CPU
    group_barrier();
    for (uint at = gl_LocalInvocationIndex; at < left_count; at += lanes) {
        CellSums all = NOTHING_YET;
        for (uint r = 0u; r < uint(CELL); ++r) add(all, row_sums[uint(CELL) * at + r]);
        hand_on(at, all);
    }
#endif
}
