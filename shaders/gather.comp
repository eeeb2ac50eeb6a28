// SPDX-License-Identifier: MIT
// First pass of the sheared denoiser: what this frame's rays say about each pixel (common/sheared_gather.glsl), beside
// what the previous frame knew about the same surface, and how the two differ, summed over cells of 4x4 pixels for the
// drift test. An invocation owns a cell. Cells with nothing but equal bits in reach are what these say.
#define READS_BLOCKERS
#include "node.glsl"
#include "common/tiles.glsl"
#include "common/blockers.glsl"
#include "common/bit_window.glsl"
#include "common/camera.glsl"
#include "common/guide_normal.glsl"
#include "common/pixels.glsl"
#include "common/previous_surface.glsl"
#include "common/shadow_state.glsl"
#include "common/own_rays.glsl"
#include "common/sun_sample.glsl"
#include "common/light_space.glsl"
#include "common/shadow_past.glsl"
#include "common/sheared_gather.glsl"
#include "common/working_cells.glsl"

const int R = RADIUS;
const int ROWS = CELL + 2 * R;
const int TILES_ABOVE = (R + TILE.y - 1) / TILE.y;
const float EQUAL_SHARE = 0.6;    // of the rays of a box that all say the same: what they count
// Of the variance between the texels that the past is resampled from: what resampling adds to its error. Over the
// penumbra's radius in pixels; both numbers minimise the shots' error (docs/sheared.md).
const float RESAMPLING_SHARE = 0.5, LARGEST_SHARE = 3.0;
const float SHARE_PER_RADIUS = 1.0;  // per pixel: of the pixels beside a narrow penumbra, how many lie in it
const float LEAST_SHARE = 0.02;
const float KNOWN = 12.0;         // frames after which a past in a penumbra is taken at its word
// Flips that a still edge shows, of what its length and width say (see flips_of), and how many a window may always show: one
// surprise is no proof. Half of it follows a moving shadow best and is enough for one that stands still (docs/sheared.md).
const float FLIP_SHARE = 0.5, FEWEST_FLIPS = 0.8;
const float PAIRS_PER_PX = 1.2732;  // of an edge, mean over its angles: 4 / pi
const float CELLS_POOLED = 16.0;    // weight of drift's window in cells, so that it has all of FEWEST_FLIPS; see there
const float NARROW_PX = 0.75;      // radius below which a young past is judged by the edge beside it
const float OWN_RAY_PX = 1.25;      // radius up to which a handful of neighbours' rays would do the own one's average harm
const float DOUBTED = 2.0;        // frames: a past that drift leaves fewer is one that it does not believe
const float OWN_SPREAD = 0.02;    // v (1 - v) to hold against what resampling does to the own rays' mean
// Of the noise of the own rays' mean, taken for no bias: with 1.5 instead, 8 frames of a 32 px edge lose a quarter.
const float NOISE_SHARE = 3.0;
const float NEW_RESIDUAL = 0.2;   // weight of a frame in the running mean of the residual

// Rows of 24 pixels around the cell, bit 0 is 8 pixels left of the tile's first; the first row lies R above the cell.
uint lit_rows[ROWS];
uint test_rows[ROWS];

void load_rows(ivec2 tile) {
    const ivec2 grid = tile_grid();
    for (int ty = -TILES_ABOVE; ty <= TILES_ABOVE; ++ty) {
        uvec3 lit = uvec3(0u), tests = uvec3(0u);
        for (int tx = 0; tx < 3; ++tx) {
            const ivec2 at = tile + ivec2(tx - 1, ty);
            if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, grid))) continue;
            tests[tx] = sunward_words[tile_index(at)];
            lit[tx] = visibility_words[tile_index(at)] & tests[tx];
        }
        for (int y = 0; y < TILE.y; ++y) {
            const int row = TILE.y * ty + y + R;
            if (row < 0 || row >= ROWS) continue;
            lit_rows[row] = row_of(lit, y);
            test_rows[row] = row_of(tests, y);
        }
    }
}

// Blockers around the cell: 8x8 tiles, weighted by how near they are. x: hits, y: log2 of the distance, z: of its square.
Penumbra penumbra_at(ivec2 cell) {
    const vec2 centre = (vec2(cell * CELL) + 0.5 * float(CELL)) / 8.0;
    const ivec2 first = ivec2(floor(centre - 0.5)) - 1, grid = tile_grid();
    vec3 sums = vec3(0.0);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 4; ++x) {
            const ivec2 tile = ivec2(first.x + x, 2 * first.y + y);
            if (any(lessThan(tile, ivec2(0))) || any(greaterThanEqual(tile, grid))) continue;
            const vec2 d = max(2.0 - abs(vec2(first) + vec2(x, y >> 1) + 0.5 - centre), 0.0);
            sums += d.x * d.x * d.y * d.y * blockers_of(tile_index(tile));
        }
    if (sums.x <= 0.0) return Penumbra(0.0, 0.0, 0.0);
    const float octaves = sums.y / sums.x;
    const float deviation = sqrt(max(sums.z / sums.x - octaves * octaves, 0.0));
    return Penumbra(exp2(octaves), tan(sun.angular_radius), 0.6931472 * deviation);
}

// A pixel on its receiver's plane, as the sun sees it.
struct Footprint {
    mat2x3 tangents;  // light space per pixel along x and y
    Stretches s;      // of their part across the light
};

Footprint footprint_of(ViewRays rays, float z, vec3 n) {
    const mat2x3 t = tangents(rays, z, n);
    return Footprint(t, stretches_of(mat2(t[0].xy, t[1].xy)));
}

Estimate this_frame(ivec2 p, ivec2 in_rows, float z, vec3 n, ViewRays rays, Penumbra penumbra, Footprint foot) {
    const float bit = float(lit_rows[in_rows.y] >> uint(in_rows.x) & 1u);
    const float rho = radius_m(penumbra);
    const Stretches s = foot.s;
    const float limit = rho * min(1.0, 0.5 / max(penumbra.spread, 1e-3));
    const float b1 = min(float(R), limit / max(s.s1, 1e-9)), b2 = min(float(R), limit / max(s.s2, 1e-9));
    const ivec2 box = clamp(ivec2(ceil(vec2(length(vec2(b1 * s.first.x, b2 * s.second.x)),
                                            length(vec2(b1 * s.first.y, b2 * s.second.y))) - 1e-3)), 1, R);
    uint lit = 0u, dark = 0u;
    int tests = 0;
    for (int dy = -box.y; dy <= box.y; ++dy) {
        const uint columns = ((2u << uint(2 * box.x)) - 1u) << uint(in_rows.x - box.x);
        const uint tested = test_rows[in_rows.y + dy] & columns, l = lit_rows[in_rows.y + dy] & columns;
        lit |= l;
        dark |= tested & ~l;
        tests += bitCount(tested);
    }
    const bool mixed = lit != 0u && dark != 0u;
    const float tolerance_m = params.plane_tolerance * pixel_span_m(z);
    const vec3 here = rays.o + z * rays.r;
    // All rays of the box agree, and so may those beyond: worth as many rays, if they are of this surface.
    bool flat_box = true;
    const ivec2 last = ivec2(frame.size) - 1;
    for (int i = 0; i < (mixed ? 0 : 4); ++i) {
        const ivec2 q = clamp(p + box * (2 * ivec2(i & 1, i >> 1) - 1), ivec2(0), last);
        const vec3 there = seen_at(rays, vec2(q - p), imageLoad(view_depth, q).x);
        flat_box = flat_box && abs(dot(n, there - here)) <= tolerance_m;
    }
    const float n_rays = flat_box ? max(EQUAL_SHARE * float(tests), 1.0) : 1.0;
    Estimate e = Estimate(bit, n_rays, max(0.4, min(1.0, 3.0 / n_rays)));
    if (mixed) e = Estimate(bit, 1.0, 1.0);

    const Window window = window_of(penumbra, limit, sqrt(b1 * s.s1 * b2 * s.s2));
    const Horizon horizon = horizon_of(n, penumbra.tangent);
    Moments m = Moments(0.0, 0.0, 0.0, 0.0, vec2(0.0), vec2(0.0), vec3(0.0));
    // Own ray only: a penumbra so narrow that no neighbour's can help.
    const int reach_y = !mixed || min(b1, b2) <= 0.0 || max(b1, b2) < OWN_RAY_PX ? -1 : box.y;
    for (int dy = -reach_y; dy <= reach_y; ++dy) {
        const uint tested = test_rows[in_rows.y + dy] >> uint(in_rows.x - R), l = lit_rows[in_rows.y + dy] >> uint(in_rows.x - R);
        const int half_width = min(int(sqrt(float(R * R - dy * dy)) + 1e-3), box.x);
        const vec3 row_o = rays.o - here + float(dy) * rays.oy, row_r = rays.r + float(dy) * rays.ry;
        for (int dx = -half_width; dx <= half_width; ++dx) {
            const vec3 at = row_o + float(dx) * rays.ox +
                            imageLoad(view_depth, p + ivec2(dx, dy)).x * (row_r + float(dx) * rays.rx);
            const bool usable = (tested >> uint(dx + R) & 1u) != 0u && abs(dot(n, at)) <= tolerance_m;
            add_ray(m, usable, float(l >> uint(dx + R) & 1u), at, unpackSnorm2x16(imageLoad(sun_points, p + ivec2(dx, dy)).x), window,
                    horizon);
        }
    }
    if (m.n > 0.0 && (m.asked > FEWEST || horizon.above == 1.0)) e = estimate_of(m, horizon);
    return e;
}

// Does the pixel next to this one, which the same ray of light could hit, say something else?
int differs(ivec2 in_rows, ivec2 offset, ivec2 p, vec3 n, ViewRays rays, float z, float tolerance_m) {
    const ivec2 q = in_rows + offset;
    const uint lit = lit_rows[in_rows.y] >> uint(in_rows.x) ^ lit_rows[q.y] >> uint(q.x);
    const vec3 there = seen_at(rays, vec2(offset), imageLoad(view_depth, p + offset).x);
    const bool same = (test_rows[q.y] >> uint(q.x) & 1u) != 0u && abs(dot(n, there - (rays.o + z * rays.r))) <= tolerance_m;
    return same ? int(lit & 1u) : 0;
}

// In a narrow penumbra the bits are all there is, and a pixel of a young past says nothing of its own variance: it flips
// or it does not. How many flip depends on the edge: over a length L (`pairs` of unlike neighbours) and a width of 2r lie 2rL
// pixels whose visibilities are anything between 0 and 1, so the mean of v (1 - v) is a sixth.
float flips_of(int pairs, float radius_px, float by_count) {
    return FLIP_SHARE * float(pairs) / PAIRS_PER_PX * radius_px / 3.0 * (1.0 + by_count) + FEWEST_FLIPS / CELLS_POOLED;
}

// Of the difference between a frame and the past where nothing moves. A pixel beside a narrow penumbra is seldom in it,
// unless its past says that it is.
float null_variance(Estimate now, Past past, float radius_px) {
    const float share = clamp(SHARE_PER_RADIUS * radius_px, LEAST_SHARE, 1.0);
    const float v = (now.rays * now.visibility + past.count * past.visibility) / (now.rays + past.count);
    const float known = min(past.count / KNOWN, 1.0);
    const float p = max(max(share * v * (1.0 - v), known * past.visibility * (1.0 - past.visibility)), flipping(past.own));
    return p * now.gain / now.rays * (1.0 + 1.0 / past.count) + 1e-5;
}

// Have the rays of some pixel of a cell, all of which say `lit` now, said something else? Then there is a thin or faint
// penumbra, and one frame's agreement is no reason to forget it. One motion serves the whole cell: under a camera that moves
// hardly anything stays faint for long.
bool past_disagrees(ivec2 first, bool lit) {
    if ((frame.flags & FRAME_RESET) != 0u) return false;
    ivec2 moved_px = ivec2(0);
#if HAS_MOTION
    const ivec2 middle = min(first + CELL / 2, ivec2(frame.size) - 1);
    const Reprojection there = reproject(middle, texelFetch(motion, middle, 0).xy);
    if (!there.on_screen) return false;
    moved_px = ivec2(floor(there.uv * vec2(frame.prev_size))) - middle;
#endif
    const ivec2 last = ivec2(frame.prev_size) - 1;
    bool differs = false;
    for (int i = 0; i < CELL * CELL; ++i) {
        const ivec2 q = clamp(first + moved_px + ivec2(i & 3, i >> 2), ivec2(0), last);
        differs = differs || disagrees(imageLoad(own_rays_prev, q).x, lit);
    }
    return differs;
}

// What drift reads of a cell: sums over its pixels.
struct Sums {
    float d, e, v, d2, e2, c;
};

// What the past is wrong by, squared: its differences from what the pixels' own rays have said, beyond the noise of these.
// Over a cell, because one pixel's difference proves little. What is shrunk by it (soften) is at no place much worse than
// either of the two: James and Stein 1961, "Estimation with Quadratic Loss", with the noise taken to be larger than it is.
struct Bias {
    float differences, noise, n;
};

void add_pixel(inout Bias b, Past past) {
    const float w = trust(past.count), d = past.own.visibility - past.visibility;
    b.differences += w * d * d;
    b.noise += w * mean_variance(past.own);
    b.n += w;
}

float bias_of(Bias b) { return max(b.differences - NOISE_SHARE * b.noise, 0.0) / max(b.n, 1.0); }

// 1 = pixels that are lit, whatever the rays around say: no receivers, or their own rays' word.
uint lit_or_sky(ivec2 cell) {
    const uint tile = tile_index(cell * CELL / TILE);
    return visibility_words[tile] | ~receiver_words[tile];
}

// Column of the cell's first pixel in the rows.
int column_of(ivec2 cell) { return 8 + (cell.x * CELL & 7); }

bool is_settled(ivec2 cell) {
    const ivec2 first = cell * CELL;
    const int column = column_of(cell);
    load_rows(ivec2(cell.x >> 1, cell.y));
    const uint in_reach = ((1u << uint(CELL + 2 * R)) - 1u) << uint(column - R);
    uint any_lit = 0u, any_dark = 0u;
    for (int i = 0; i < ROWS; ++i) {
        any_lit |= lit_rows[i] & in_reach;
        any_dark |= test_rows[i] & ~lit_rows[i] & in_reach;
    }
    const bool mixed = any_lit != 0u && any_dark != 0u;
    bool works = mixed;
    for (int i = 0; i < (!mixed && (any_lit | any_dark) != 0u ? 1 : 0); ++i) works = past_disagrees(first, any_lit != 0u);

    const uint lit = lit_or_sky(cell);
    // Counted by what there is to do: older software devices run both sides of a branch, but no loop that no lane enters.
    IdleCell idle = IdleCell(0u, 0u);
    for (int i = 0; i < (works ? 0 : CELL * CELL); ++i) {
        const ivec2 offset = ivec2(i & 3, i >> 2), p = first + offset;
        const float bit = (lit & pixel_bit(p)) != 0u ? 1.0 : 0.0;
        const bool tests = (test_rows[R + offset.y] >> uint(column + offset.x) & 1u) != 0u;
        idle.lit |= (bit > 0.5 ? 1u : 0u) << uint(i);
        idle.tests |= (tests ? 1u : 0u) << uint(i);
        imageStore(gathered, p, uvec4(pack_gathered(Gathered(bit, bit, IDLE_COUNT, 0.0, 0.0, tests)), 0u, 0u));
        imageStore(own_rays, p, uvec4(pack_own(tests ? OwnRays(bit, IDLE_COUNT, 0.0, bit > 0.5) : NO_RAYS), 0u, 0u, 0u));
    }
    if (!works) {
        cells[2u * cell_index(cell)] = vec4(0.0);
        cells[2u * cell_index(cell) + 1u] = vec4(0.0, 0.0, pack_idle(idle));
    }
    return !works;
}

void work_on(ivec2 cell) {
    const ivec2 first = cell * CELL;
    const int column = column_of(cell);
    load_rows(ivec2(cell.x >> 1, cell.y));
    const uint lit = lit_or_sky(cell);
    const mat3 light = transpose(sun_frame(sun.to_sun));
    const ViewRays corner = view_rays(first, light);
#if HAS_MOTION
    const ViewRays before = previous_rays(light);
#endif
    const Penumbra penumbra = penumbra_at(cell);
    const float rho = radius_m(penumbra);

    Sums sums = Sums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    Bias bias = Bias(0.0, 0.0, 0.0);
    vec2 steps = vec2(1e9);  // light-space pixel sizes
    float largest = 0.0, seen_m2 = 0.0;  // by the sun, of the cell's pixels
    int pairs = 0, pasts = 0;
    float radii = 0.0, by_counts = 0.0;  // over these
    int tested_pixels = 0;
    bool resampled = false;
    for (int i = 0; i < CELL * CELL; ++i) {
        const ivec2 offset = ivec2(i & 3, i >> 2), p = first + offset;
        const float bit = (lit & pixel_bit(p)) != 0u ? 1.0 : 0.0;
        Gathered g = Gathered(bit, bit, 0.0, 0.0, 0.0, false);
        OwnRays own = NO_RAYS;
        const ivec2 in_rows = ivec2(column + offset.x, R + offset.y);
        if ((test_rows[in_rows.y] >> uint(in_rows.x) & 1u) != 0u) {
            const float z = imageLoad(view_depth, p).x;
            const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p))), n_light = light * n;
            const ViewRays rays = moved(corner, vec2(offset));
            const Footprint foot = footprint_of(rays, z, n_light);
            const float tolerance_m = params.plane_tolerance * pixel_span_m(z);
            const Estimate now = this_frame(p, in_rows, z, n_light, rays, penumbra, foot);
#if HAS_MOTION
            const OffPlane then = off_plane(before, n_light, rays.o + z * rays.r);
            Past past = under_this_sun(past_of(p, n, then, tolerance_m));
#else
            Past past = under_this_sun(past_of(p));
#endif
            const float radius_px = rho / max(foot.s.s1, 1e-9);
            const float resampling = min(RESAMPLING_SHARE / max(radius_px, 1e-3), LARGEST_SHARE) * past.variance;
            // Drift's doubts, which came after the rays had been counted, and resampling as above.
            past.own.count = past.count < DOUBTED ? 0.0 : min(past.own.count, floor(past.count + 0.5));
            add_pixel(bias, past);
            resampled = resampled || past.resampled;
            past.count = min(past.count, squared_error(now) / max(resampling, 1e-6));
            past.own.count = min(past.own.count, floor(OWN_SPREAD / max(resampling, 1e-6)));
            own = with_ray(past.own, bit > 0.5);
            steps = min(steps, vec2(length(foot.tangents[0].xy), length(foot.tangents[1].xy)));
            largest = max(largest, foot.s.s1);
            ++tested_pixels;
            seen_m2 += foot.s.s1 * foot.s.s2;
            pairs += differs(in_rows, ivec2(1, 0), p, n_light, rays, z, tolerance_m) +
                     differs(in_rows, ivec2(0, 1), p, n_light, rays, z, tolerance_m);

            g = Gathered(now.visibility, past.count > 0.0 ? past.visibility : now.visibility, past.count, 0.0,
                         sqrt(squared_error(now)), true);
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
        imageStore(gathered, p, uvec4(pack_gathered(g), 0u, 0u));
        imageStore(own_rays, p, uvec4(pack_own(own), 0u, 0u, 0u));
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
    const vec2 size = vec2(radius_px, uintBitsToFloat(pack_softening(ivec2(reach), past_kind, tests, bias_of(bias))));
    cells[2u * cell_index(cell) + 1u] = vec4(sums.e2, sums.c, size);
}

void main() { for_each_cell(); }
