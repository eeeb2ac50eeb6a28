// SPDX-License-Identifier: MIT
// First pass of the sheared denoiser: what this frame's rays say about each pixel (common/sheared_gather.glsl), beside
// what the previous frame knew about the same surface, and how the two differ, summed over cells of 4x4 pixels for the
// drift test. An invocation owns a cell. Cells with nothing but equal bits in reach are what these say.
#define READS_BLOCKERS
#include "node.glsl"
#include "common/blockers.glsl"
#include "common/camera.glsl"
#include "common/guide_normal.glsl"
#include "common/pixels.glsl"
#include "common/previous_surface.glsl"
#include "common/shadow_state.glsl"
#include "common/sun_sample.glsl"
#include "common/light_space.glsl"
#include "common/sheared_gather.glsl"
#include "common/tiles.glsl"

const int R = RADIUS;
const int ROWS = CELL + 2 * R;
const float SAME_FACE = 0.9;      // cosine: beyond a crease the sun stands differently
const float EQUAL_SHARE = 0.6;    // of the rays of a box that all say the same: what they count
const float IDLE_COUNT = 8.0;     // frames that a cell without any doubt counts for
const float RESAMPLING_SHARE = 0.5; // over the radius in pixels: of the variance between texels, error that resampling makes
const float LARGEST_SHARE = 3.0;
const float SHARE_PER_RADIUS = 1.0;
const float LEAST_SHARE = 0.02;
const float KNOWN = 12.0;
const float NEW_RESIDUAL = 0.2;   // weight of a frame in the running mean of the residual

// Rows of 24 pixels around the cell, bit 0 is 8 pixels left of the tile's first; the first row lies R above the cell.
uint lit_rows[ROWS];
uint test_rows[ROWS];

// Row `y` of the frame, of the tile column `tile_x` and its neighbours.
void load_row(int tile_x, int y, out uint lit, out uint tests) {
    const ivec2 grid = tile_grid();
    const int tile_y = y >> 2, shift = 8 * (y & 3);
    lit = 0u;
    tests = 0u;
    if (y < 0 || tile_y >= grid.y) return;
    for (int i = 0; i < 3; ++i) {
        const int x = tile_x - 1 + i;
        if (x < 0 || x >= grid.x) continue;
        const uint t = tile_index(ivec2(x, tile_y)), tested = sunward_words[t] >> shift & 0xffu;
        tests |= tested << 8 * i;
        lit |= (visibility_words[t] >> shift & tested) << 8 * i;
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

struct Past {
    float visibility, count, residual;
    float variance;  // between the texels that it is resampled from; 0: it is one of them
};
const Past NO_PAST = Past(0.0, 0.0, 0.0, 0.0);

bool shows_plane(ivec2 q, vec3 here, vec3 n, float tolerance_m) {
    if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, ivec2(frame.prev_size)))) return false;
    const float z = imageLoad(view_depth_prev, q).x;
    const vec3 n_prev = unit_or_zero(decode_normal(imageLoad(guide_normal_prev, q)));
    return z > 0.0 && dot(n, n_prev) > SAME_FACE && lies_on_plane(previous_position(q, z), here, n, tolerance_m);
}

// Weights of four neighbours at -1, 0, 1, 2 for a position t between 0 and 1: Catmull-Rom.
vec4 cubic_weights(float t) {
    return 0.5 * vec4(t * (-1.0 + t * (2.0 - t)), 2.0 + t * t * (3.0 * t - 5.0), t * (1.0 + t * (4.0 - 3.0 * t)),
                      t * t * (t - 1.0));
}

float sharper(ivec2 corner, vec2 t) {
    const vec4 wx = cubic_weights(t.x), wy = cubic_weights(t.y);
    const ivec2 last = ivec2(frame.prev_size) - 1;
    float sum = 0.0;
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) {
            const ivec2 q = clamp(corner + ivec2(x, y) - 1, ivec2(0), last);
            sum += wx[x] * wy[y] * unpack_state(imageLoad(history, q).x).visibility;
        }
    return sum;
}

Past past_of(ivec2 p, float z, vec3 n, float tolerance_m) {
    const Reprojection there = reproject(p, texelFetch(motion, p, 0).xy);
    if (!there.on_screen || (frame.flags & FRAME_RESET) != 0u) return NO_PAST;
    const vec3 here = position(p, z);
    const vec2 at = there.uv * vec2(frame.prev_size) - 0.5;
    const ivec2 corner = ivec2(floor(at + 1e-3));
    const vec2 t = clamp(at - vec2(corner), 0.0, 1.0);
    float weights = 0.0, nearest = 0.0, low = 1.0, high = 0.0;
    Past past = NO_PAST;
    for (int i = 0; i < 4; ++i) {
        const ivec2 q = corner + ivec2(i & 1, i >> 1);
        const float weight = ((i & 1) != 0 ? t.x : 1.0 - t.x) * ((i >> 1) != 0 ? t.y : 1.0 - t.y);
        if (weight > 1e-3 && shows_plane(q, here, n, tolerance_m)) {
            const ShadowState s = unpack_state(imageLoad(history, q).x);
            if (s.count > 0.0) {
                weights += weight;
                past.visibility += weight * s.visibility;
                past.variance += weight * s.visibility * s.visibility;
                low = min(low, s.visibility);
                high = max(high, s.visibility);
                if (weight > nearest) {
                    nearest = weight;
                    past.count = s.count;
                    past.residual = s.residual;
                }
            }
        }
    }
    if (weights <= 0.0) return NO_PAST;
    past.visibility /= weights;
    past.variance = max(past.variance / weights - past.visibility * past.visibility, 0.0);
    if (weights > 0.99 && high > low) past.visibility = clamp(sharper(corner, t), low, high);
    return past;
}

Estimate this_frame(ivec2 p, ivec2 in_rows, float z, vec3 n, ViewRays rays, Penumbra penumbra) {
    const uint own = 1u << uint(in_rows.x);
    const float bit = (lit_rows[in_rows.y] & own) != 0u ? 1.0 : 0.0;
    const float rho = radius_m(penumbra);
    if (rho <= 0.0) return Estimate(bit, 1.0, 1.0);

    const mat2x3 t = tangents(rays, z, n);
    const Stretches s = stretches_of(mat2(t[0].xy, t[1].xy));
    const float limit = rho * min(1.0, 0.5 / max(penumbra.spread, 1e-3));
    const float b1 = min(float(R), limit / max(s.s1, 1e-9)), b2 = min(float(R), limit / max(s.s2, 1e-9));
    const ivec2 box = clamp(ivec2(ceil(vec2(length(vec2(b1 * s.first.x, b2 * s.second.x)),
                                            length(vec2(b1 * s.first.y, b2 * s.second.y))) - 1e-3)), 1, R);
    // All rays of the box agree?
    uint lit = 0u, dark = 0u;
    int tests = 0;
    for (int dy = -box.y; dy <= box.y; ++dy) {
        const uint columns = ((2u << uint(2 * box.x)) - 1u) << uint(in_rows.x - box.x);
        const uint tested = test_rows[in_rows.y + dy] & columns, l = lit_rows[in_rows.y + dy] & columns;
        lit |= l;
        dark |= tested & ~l;
        tests += bitCount(tested);
    }
    if (lit == 0u || dark == 0u) {
        const float n_rays = max(EQUAL_SHARE * float(tests), 1.0);
        return Estimate(bit, n_rays, max(0.4, min(1.0, 3.0 / n_rays)));
    }

    const float c = clamp(sqrt(b1 * s.s1 * b2 * s.s2) / rho, 1e-3, 1.0);
    const float tolerance_m = params.plane_tolerance * pixel_span_m(z);
    const vec3 here = rays.o + z * rays.r;
    Moments m = Moments(0.0, 0.0, 0.0, vec2(0.0), vec2(0.0), vec3(0.0));
    for (int dy = -box.y; dy <= box.y; ++dy) {
        const uint row = test_rows[in_rows.y + dy];
        const int half_width = min(int(sqrt(float(R * R - dy * dy)) + 1e-3), box.x);
        for (int dx = -half_width; dx <= half_width; ++dx) {
            const uint mask = 1u << uint(in_rows.x + dx);
            if ((row & mask) == 0u) continue;
            const ivec2 q = p + ivec2(dx, dy);
            Tap tap;
            tap.at = seen_at(rays, vec2(dx, dy), imageLoad(view_depth, q).x) - here;
            tap.usable = abs(dot(n, tap.at)) <= tolerance_m;
            tap.lit = (lit_rows[in_rows.y + dy] & mask) != 0u ? 1.0 : 0.0;
            tap.sun = unpackSnorm2x16(sun_points[(q.y & 127) * 128 + (q.x & 127)]);
            add_ray(m, tap, penumbra, 1.0 / rho, limit * limit, c);
        }
    }
    if (m.n <= 0.0) return Estimate(bit, 1.0, 1.0);
    return estimate_of(m);
}

// What drift reads of a cell: sums over its pixels.
struct Sums {
    float d, e, v, d2, e2, c;
};

void main() {
    const ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(cell, cell_grid()))) return;
    const ivec2 first = cell * CELL;
    const int tile_x = cell.x >> 1, column = 8 + (first.x & 7);

    const uint in_reach = ((1u << uint(CELL + 2 * R)) - 1u) << uint(column - R);
    uint any_lit = 0u, any_dark = 0u;
    for (int i = 0; i < ROWS; ++i) {
        uint lit, tests;
        load_row(tile_x, first.y - R + i, lit, tests);
        lit_rows[i] = lit;
        test_rows[i] = tests;
        any_lit |= lit & in_reach;
        any_dark |= tests & ~lit & in_reach;
    }
    const bool works = any_lit != 0u && any_dark != 0u;

    const mat3 light = transpose(sun_frame(sun.to_sun));
    const ViewRays corner = view_rays(first, light);
    Penumbra penumbra = Penumbra(0.0, 0.0, 0.0);
    if (works) penumbra = penumbra_at(cell);

    Sums sums = Sums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    vec2 steps = vec2(1e9);  // light-space pixel sizes
    float largest = 0.0;
    const uint receivers = receiver_words[tile_index(first / TILE)], visible = visibility_words[tile_index(first / TILE)];
    for (int i = 0; i < CELL * CELL; ++i) {
        const ivec2 offset = ivec2(i & 3, i >> 2), p = first + offset;
        if (!inside_frame(p)) continue;
        const uint mask = pixel_bit(p);
        Gathered g = Gathered((visible & mask) != 0u || (receivers & mask) == 0u ? 1.0 : 0.0, 0.0, 0.0, 0.0, 0.0, false);
        g.past = g.now;
        const ivec2 in_rows = ivec2(column + offset.x, R + offset.y);
        if (works && (test_rows[in_rows.y] >> uint(in_rows.x) & 1u) != 0u) {
            const float z = imageLoad(view_depth, p).x;
            const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
            const ViewRays rays = moved(corner, vec2(offset));
            const vec3 n_light = light * n;
            const Estimate now = this_frame(p, in_rows, z, n_light, rays, penumbra);
            Past past = past_of(p, z, n, params.plane_tolerance * pixel_span_m(z));
            const mat2x3 t = tangents(rays, z, n_light);
            const float radius_px = radius_m(penumbra) / max(stretches_of(mat2(t[0].xy, t[1].xy)).s1, 1e-9);
            const float share = min(RESAMPLING_SHARE / max(radius_px, 1e-3), LARGEST_SHARE);
            past.count = min(past.count, squared_error(now) / max(share * past.variance, 1e-6));
            const vec2 size = vec2(length(t[0].xy), length(t[1].xy));
            steps = min(steps, size);
            largest = max(largest, stretches_of(mat2(t[0].xy, t[1].xy)).s1);

            const float penumbra_share = clamp(SHARE_PER_RADIUS * radius_m(penumbra) / stretches_of(mat2(t[0].xy, t[1].xy)).s2, LEAST_SHARE, 1.0);
            g.now = now.visibility;
            g.counts = true;
            g.error = sqrt(squared_error(now));
            g.past = past.count > 0.0 ? past.visibility : g.now;
            g.count = past.count;
            const float d = g.now - g.past;
            g.residual = past.count > 0.0 ? past.residual + NEW_RESIDUAL * (d - past.residual) : 0.0;
            if (past.count > 0.0) {
                const float v = (now.rays * g.now + past.count * g.past) / (now.rays + past.count);
                const float variance = max(penumbra_share * v * (1.0 - v), min(past.count / KNOWN, 1.0) * g.past * (1.0 - g.past)) * now.gain / now.rays * (1.0 + 1.0 / past.count) + 1e-5;
                sums.d += d;
                sums.e += g.residual;
                sums.v += variance;
                sums.d2 += d * d;
                sums.e2 += g.residual * g.residual;
                sums.c += variance * (1.0 + 0.5 * (now.rays - 1.0));
            }
        } else if (!works) {
            g.count = IDLE_COUNT;
            g.counts = (test_rows[in_rows.y] >> uint(in_rows.x) & 1u) != 0u;
        }
        imageStore(gathered, p, uvec4(pack_gathered(g), 0u, 0u));
    }
    const float rho = radius_m(penumbra);
    const vec2 reach = rho > 0.0 && works ? min(0.25 * rho / max(steps, vec2(1e-9)), 6.0) : vec2(0.0);
    const float radius_px = rho > 0.0 && largest > 0.0 ? rho / largest : 0.0;
    cells[2u * cell_index(cell)] = vec4(sums.d, sums.e, sums.v, sums.d2);
    cells[2u * cell_index(cell) + 1u] =
        vec4(sums.e2, sums.c, works ? radius_px : -1.0, uintBitsToFloat(packHalf2x16(floor(reach))));
}
