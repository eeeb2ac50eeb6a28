// SPDX-License-Identifier: MIT
// One frame's visibility of a pixel from its neighbours' rays. A shadow ray tests one point of the blocker's silhouette.
// Seen from the sun and on the pixel's own terms (eta: the point's place on the disc that the sun makes there), a
// neighbour's ray is a sample of the pixel's visibility wherever |eta| < 1, and an exact one: no blur, so no width of a
// filter to choose. What remains is variance, and that regression on eta (whose mean over the disc is 0) removes most of
// where the edge is straight.
//
// The idea of filtering along the shear that a light field has: Egan et al. 2011, "Frequency Analysis and Sheared
// Filtering for Shadow Light Fields of Complex Occluders". Here single rays are sheared, and none is filtered.
//
// Includer has rounded.glsl and common/light.glsl.

const float UNEVEN = 0.109;   // see Window
const float FEWEST = 2.5;     // rays with which a plane through their bits is fitted
// Rays by which such a plane is pulled to the disc's rim: one for each of its two slopes; more where those at the rim are of pixels that have
// fewer, and count for more; and more again of a square, in which fewer pixels are asked.
const float PULL_OF_ONE = 2.0, PULL_OF_MANY = 3.0, PULL_IN_SQUARE = 3.8;

// What surrounds the pixel, in light space.
struct Penumbra {
    float distance_m;  // of the blockers, 0: none
    float tangent;     // of the sun's angular radius
    float spread;      // relative deviation of the distance; of none, what is_cut() says
};

struct Estimate {
    float visibility;
    float rays;  // independent ones that it is worth
    float gain;  // of its variance by regression, over v (1 - v) / rays
    float each;  // rays that every pixel has which was asked, on average
};

// In a word: 16 bits of visibility, 10 of rays (up to 85) and 6 of gain.
const float RAYS_STEP = 1.0 / 12.0;
uint pack_estimate(Estimate e) {
    const uint rays = rounded(min(e.rays / RAYS_STEP, 1023.0)), gain = rounded(clamp(e.gain, 0.0, 1.0) * 63.0);
    return rounded(clamp(e.visibility, 0.0, 1.0) * 65535.0) | rays << 16 | gain << 26;
}
Estimate unpack_estimate(uint word) {
    return Estimate(float(word & 0xffffu) / 65535.0, float(word >> 16 & 0x3ffu) * RAYS_STEP, float(word >> 26) / 63.0, 1.0);
}

// Where pixels may have several rays: 15 bits of visibility, 7 of rays, 5 of gain and 5 of how many each has; 0 rays are 0.
uint pack_estimate_of_many(Estimate e) {
    const uint rays = e.rays > 0.0 ? 1u + rounded(clamp(log2(max(e.rays, 1.0)) * 12.0, 0.0, 126.0)) : 0u;
    const uint gain = rounded(clamp(e.gain, 0.0, 1.0) * 31.0), each = rounded(clamp(log2(max(e.each, 1.0)) * 6.0, 0.0, 31.0));
    return rounded(clamp(e.visibility, 0.0, 1.0) * 32767.0) | rays << 15 | gain << 22 | each << 27;
}
Estimate unpack_estimate_of_many(uint word) {
    const uint rays = word >> 15 & 127u;
    return Estimate(float(word & 0x7fffu) / 32767.0, rays == 0u ? 0.0 : exp2((float(rays) - 1.0) / 12.0), float(word >> 22 & 31u) / 31.0,
                    exp2(float(word >> 27) / 6.0));
}

float radius_m(Penumbra p) { return p.distance_m * p.tangent; }

// Moments of the rays that hit the disc, from which everything follows.
struct Moments {
    float asked;        // rays, those below the horizon too
    float n, n2;        // weights, and their squares
    float b, be2;       // bits, bit * eta^2
    vec2 e, be;         // eta, bit * eta
    vec3 ee;            // eta eta^T: xx, xy, yy
};

// What of the sun's disc stands above the receiver's own plane. A ray to a point below meets the receiver whatever else is
// there: it knows nothing of blockers and shears nowhere. It is left out, and its share of the disc is known.
struct Horizon {
    vec2 up;        // unit vector
    float height;   // of the disc's centre above the horizon, in radii
    float above;    // share of the disc
    vec2 middle;    // of what is above
};

const Horizon NO_HORIZON = Horizon(vec2(0.0), 1.0, 1.0, vec2(0.0));

bool light_is_a_square() { return HAS_LIGHT && light_is_square(); }

// A square's part above a line. Its middle by eight strips.
Horizon square_horizon(vec2 up, float d) {
    const vec2 size = abs(up);
    const float across = max(size.x, size.y), sides = size.x + size.y;
    if (d >= sides) return NO_HORIZON;
    const bool steep = size.x > size.y;  // strips lie along the axis that the line crosses
    const float rise = steep ? up.x : up.y, slope = steep ? up.y : up.x, side = rise < 0.0 ? -1.0 : 1.0;
    vec3 sum = vec3(0.0);  // area, and its moments along the strips and across
    [[unroll]] for (int i = 0; i < 8; ++i) {
        const float t = 0.25 * float(i) - 0.875;
        const float from = clamp(-(d + slope * t) / abs(rise), -1.0, 1.0), l = 1.0 - from;
        sum += vec3(l, 0.5 * (1.0 - from * from) * side, l * t);
    }
    const vec2 middle = sum.yz / max(sum.x, 1e-3);
    return Horizon(up, d, clamp(0.5 + square_area(across / sides, clamp(d / sides, -1.0, 1.0)), 0.0, 1.0), steep ? middle : middle.yx);
}

// `n`: the receiver's normal in light space.
Horizon horizon_of(vec3 n, float tangent) {
    if (light_is_a_square()) return square_horizon(n.xy / max(length(n.xy), 1e-9), n.z / max(length(n.xy), 1e-9));
    const float across = length(n.xy), d = n.z / max(across * tangent, 1e-9);
    if (d >= 1.0) return NO_HORIZON;
    const float c = max(d, -1.0), s = sqrt(max(1.0 - c * c, 0.0));
    const float above = 0.5 + (asin(c) + c * s) * 0.31830989;
    return Horizon(n.xy / across, c, above, 0.21220659 * s * s * s / max(above, 1e-3) * (n.xy / across));
}

bool is_above(Horizon h, vec2 point) { return dot(h.up, point) > -h.height; }

// Which rays are asked. A window that covers a part c of the disc's radius sees rays from eta near 1 less often than from
// the middle: their pixels lie outside. That coverage is flat up to |eta| = 1 - c and falls from there on: with t = (1 - |eta|) / c by
// a cubic that is within 2 % of the discs of pixels that are asked.
struct Window {
    float by_radius;          // 1 / the disc's radius, per metre: the unit of what follows
    float tangent, distance;
    float limit2;             // of a neighbour's distance across the light, squared
    float by_covered;         // 1 / c
    float at_rim, bulge;      // coverage where t = 0, of 1 where t = 1, and what bulge t^2 (1 - t) adds to the line between
};

Window window_of(Penumbra p, float limit, float covered_m) {
    const float by_radius = 1.0 / max(radius_m(p), 1e-9), c = clamp(covered_m * by_radius, 1e-3, 1.0), by_limit = limit * by_radius;
    return Window(by_radius, p.tangent, p.distance_m * by_radius, by_limit * by_limit, 1.0 / c, 0.5 - UNEVEN * c, 0.5 - 0.5 * c * c);
}

// Of rays that are all worth the same.
Window even_window(Penumbra p, float limit) {
    const float by_radius = 1.0 / max(radius_m(p), 1e-9), by_limit = limit * by_radius;
    return Window(by_radius, p.tangent, p.distance_m * by_radius, by_limit * by_limit, 1.0, 1.0, 0.0);
}

// Of a ray at |eta| = e < 1.
float coverage_at(Window window, float e) {
    const float t = min((1.0 - e) * window.by_covered, 1.0);
    return mix(window.at_rim, 1.0, t) + window.bulge * t * t * (1.0 - t);
}

// Of a square's point, on each axis by itself: the part of a disc that lies within its side, by a cubic.
float coverage_at(Window window, vec2 sides) {
    const vec2 t = min((1.0 - sides) * window.by_covered, vec2(1.0)), part = 0.5 + t * (0.6366 - 0.1366 * t * t);
    return part.x * part.y;
}

// `at`: the neighbour, light space, relative to the pixel, in radii of the disc; `point`: of the sun, that its ray went to; `part`: what the
// ray counts for.
void add_ray(inout Moments m, bool usable, bool lit, float part, vec3 at, vec2 point, Window window, Horizon horizon) {
    const vec2 eta = at.xy + (window.distance - at.z) * window.tangent * point;
    const float e2 = dot(eta, eta);
    const vec2 sides = abs(eta);
    const bool inside = light_is_a_square() ? max(sides.x, sides.y) < 1.0 : e2 < 1.0;
    const bool asked = usable && inside && dot(at.xy, at.xy) <= window.limit2;
    const bool hits = asked && is_above(horizon, point) && is_above(horizon, eta);
    m.asked += asked ? 1.0 : 0.0;
    const float w = hits ? part / (light_is_a_square() ? coverage_at(window, sides) : coverage_at(window, sqrt(e2))) : 0.0;
    const vec2 we = hits ? w * eta : vec2(0.0);
    m.n += w;
    m.n2 += w * w;
    m.b += lit ? w : 0.0;
    m.be2 += lit ? w * e2 : 0.0;
    m.e += we;
    m.be += lit ? we : vec2(0.0);
    m.ee += hits ? vec3(we.x * eta.x, we.x * eta.y, we.y * eta.y) : vec3(0.0);
}

Estimate estimate_of(Moments m, Horizon horizon) {
    const float by_n = 1.0 / m.n, rays = m.n * m.n / m.n2;
    const float mean = m.b * by_n, variance = mean * (1.0 - mean);
    Estimate e = Estimate(mean, rays, 0.0, 1.0);
    float left = variance;
    if (rays > FEWEST) {
        const vec2 eta = m.e * by_n, cov = m.be * by_n - mean * eta;
        const float ridge = 1.0 / rays;
        const vec3 s = m.ee * by_n - vec3(eta.x * eta.x, eta.x * eta.y, eta.y * eta.y) + vec3(ridge, 0.0, ridge);
        const float det = s.x * s.z - s.y * s.y;
        const vec2 beta = vec2(s.z * cov.x - s.y * cov.y, s.x * cov.y - s.y * cov.x) / det;
        // The plane lies too near to the bits at the disc's rim, which pull it most. 4, so that a handful of rays is not made noisier by it than
        // it was wrong.
        const float at_rim = horizon.above == 1.0 ? m.be2 / (m.ee.x + m.ee.z) : mean;
        const float pull = !MANY_RAYS ? PULL_OF_ONE : light_is_a_square() ? PULL_IN_SQUARE : PULL_OF_MANY;
        e.visibility = clamp(mean - dot(beta, eta - horizon.middle) + pull / (rays + 4.0) * (at_rim - mean), 0.0, 1.0);
        left = max(variance - dot(beta, cov), 0.1 * variance);
    }
    e.gain = variance > 1e-6 ? clamp(left / variance, 0.25, 1.0) : 0.4;
    e.gain = max(e.gain, min(1.0, 3.0 / rays));
    e.visibility *= horizon.above;
    return e;
}

// Standard error, squared, with a prior so that a handful of equal rays is not certainty.
float squared_error(Estimate e) {
    const float v = (e.rays * e.visibility + 1.0) / (e.rays + 2.0);
    return e.gain * v * (1.0 - v) / e.rays;
}
