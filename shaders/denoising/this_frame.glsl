// SPDX-License-Identifier: MIT
// What this frame's rays say about a receiver: its own, and its neighbours' that test what its own sun would be hidden by.
// Where nobody knows which point of the sun a ray went to (no buffer ray_points), it is taken for a test of its own pixel's
// whole disc: that of pixels near by is much the same, and regression on their places takes out what changes across them.
//
// Includer has camera.glsl, light_space.glsl, lamp_space.glsl, corners.glsl, sheared_gather.glsl, bit_rows.glsl and rounded.glsl, and
// declares the image view_depth, params.plane_tolerance and, perhaps, the buffer ray_points.

const uint NO_POINT = 0u;       // in ray_points, of who has no ray
const float EQUAL_SHARE = 0.6;  // of the rays of a box that all say the same: what they count
// Further rays of a turn. Most pixels have few; and one driver ends all loops of a workgroup after 65 535 turns, of which each of a CPU's
// invocations has 128 pixels with up to 49 neighbours (81 at a radius of 5) to ask.
const uint AT_ONCE = R > 4 ? 8u : 4u;
const float UNSHEARED_SHARE = 0.7, UNSHEARED_PX = 2.8;  // of the disc's radius, and at most: how far rays of unknown points are asked

// A pixel on its receiver's plane, as the light sees it.
struct Footprint {
    mat2x3 tangents;  // light space per pixel along x and y
    Stretches s;      // of their part across the light
};

Footprint footprint_of(LampSpace lamp, mat2x3 t) {
    if (HAS_LIGHT) t = mat2x3(moves_by(lamp, t[0]), moves_by(lamp, t[1]));
    return Footprint(t, stretches_of(mat2(t[0].xy, t[1].xy)));
}

// `here`: camera-relative. The sun's light space needs nothing of it.
LampSpace lamp_space_at(vec3 here, vec3 n) {
    LampSpace lamp;
    if (HAS_LIGHT) lamp = lamp_space(here - light.centre, n);
    return lamp;
}

// A receiver, with what it takes to ask its neighbours.
struct Receiver {
    ivec2 p, in_rows;
    vec3 n;             // along towards_light, as all but the footprint
    ViewRays rays;      // around it, from it on
    Surface surface;    // its own
    LampSpace lamp;     // where the light is near
    Footprint foot;
};

Receiver receiver_at(ivec2 p, ivec2 offset, float z, vec3 n, ViewRays rays) {
    const vec3 here = rays.o + z * rays.r;
    const LampSpace lamp = lamp_space_at(here, n);
    const Footprint foot = footprint_of(lamp, tangents(rays, z, n));
    rays.o -= here;
    const Surface surface = Surface(off_plane(rays, n, vec3(0.0)), params.plane_tolerance * pixel_span_m(z));
    return Receiver(p, offset + R, n, rays, surface, lamp, foot);
}

// How far a receiver looks.
struct Reach {
    float limit_m;  // across the light
    float b1, b2;   // pixels along the axes of its footprint
    ivec2 box;      // around that
};

Reach reach_of(Stretches s, Penumbra penumbra) {
    const float limit = radius_m(penumbra) * min(1.0, 0.5 / max(penumbra.spread, 1e-3));
    const float b1 = min(float(R), limit / max(s.s1, 1e-9)), b2 = min(float(R), limit / max(s.s2, 1e-9));
    const vec2 extent = vec2(length(vec2(b1 * s.first.x, b2 * s.second.x)), length(vec2(b1 * s.first.y, b2 * s.second.y)));
    const vec2 box = min(ceil(extent - 1e-3), float(R));
    return Reach(limit, b1, b2, clamp(ivec2(rounded(box.x), rounded(box.y)), 1, R));
}

// The pixels of a row of the neighbourhood that can be within reach on the receiver's plane: those of an ellipse, cut off at the box and at a disc
// of R pixels.
struct ReachRows {
    float limit2;  // along x, in pixels of the receiver's row
    float shear, shrink;
};
const float ROW_MARGIN_PX = 0.25;  // off the plane

ReachRows rows_of(Reach reach, mat2 pixels) {
    const float by_x2 = 1.0 / max(dot(pixels[0], pixels[0]), 1e-20), shear = dot(pixels[0], pixels[1]) * by_x2;
    return ReachRows(reach.limit_m * reach.limit_m * by_x2, shear, dot(pixels[1], pixels[1]) * by_x2 - shear * shear);
}

// First and last; none where the first comes after the last.
ivec2 row_of_reach(ReachRows rows, Reach reach, int dy) {
    const float most = min(floor(sqrt(float(R * R - dy * dy)) + 1e-3), float(reach.box.x)), middle = -rows.shear * float(dy);
    const float half_width = sqrt(max(rows.limit2 - rows.shrink * float(dy * dy), 0.0)) + ROW_MARGIN_PX;
    const float first = clamp(ceil(middle - half_width), -most, most + 1.0), last = clamp(floor(middle + half_width), -most - 1.0, most);
    return clamp(ivec2(rounded(first + float(R + 1)), rounded(last + float(R + 1))) - (R + 1), -R - 1, R + 1);  // a NaN is no end of a loop
}

// Nothing blocks but the receivers' own plane, which hides a part of the light: rays that go below it are dark, here and there.
const float CUT = -1.0;  // a penumbra's spread
bool is_cut(Penumbra penumbra) { return penumbra.spread == CUT; }

// All rays of the box agree, and so may those beyond: worth as many rays, if they are of this surface and do not agree by chance (is_cut()).
Estimate agreement(Receiver r, ivec2 box, bool by_chance) {
    const uint columns = ((2u << uint(2 * box.x)) - 1u) << uint(r.in_rows.x - box.x + 16);
    int tests = 0;
    uint lit = 0u;
    for (int dy = -box.y; dy <= box.y; ++dy) {
        tests += bitCount(rows[r.in_rows.y + dy] & columns);
        lit |= rows[r.in_rows.y + dy] & columns >> 16;
    }
    bool flat_box = true;
    const ivec2 last = ivec2(frame.size) - 1;
    for (int i = 0; i < 4; ++i) {
        const ivec2 q = clamp(r.p + box * diagonal(i), ivec2(0), last);
        flat_box = flat_box && shows(r.surface, vec2(q - r.p), imageLoad(view_depth, q).x);
    }
    const bool sure = flat_box && !by_chance && !(HAS_RAY_BITS && further_disagree(further_at(r.p), lit != 0u));
    const float n = sure ? max(EQUAL_SHARE * float(tests), 1.0) : 1.0;
    const bool told = !HAS_RAY_WORDS || has_ray(r.p) || flat_box && tests != 0;
    return Estimate(lit != 0u ? 1.0 : 0.0, told ? n : 0.0, max(0.4, min(1.0, 3.0 / n)), 1.0);
}

// Of a receiver without a ray: the mean of the rays next to it, which is nothing to average with others.
Estimate next_to(Receiver r) {
    const uint columns = 7u << uint(r.in_rows.x - 1);
    int lit = 0, tests = 0;
    for (int dy = -1; dy <= 1; ++dy) {
        lit += bitCount(rows[r.in_rows.y + dy] & columns);
        tests += bitCount(rows[r.in_rows.y + dy] & columns << 16);
    }
    return Estimate(tests != 0 ? float(lit) / float(tests) : 1.0, 0.0, 1.0, 1.0);
}

// The points of a pixel's further rays from that of its first one: turned evenly, and of evenly spread areas (noise_step()).
struct FurtherPoint {
    vec2 unit, turn;
    float area;
};

// On a square it is the first coordinate that steps evenly, and the second that takes the golden ratio.
FurtherPoint further_point(vec2 first, uint further) {
    if (HAS_LIGHT && light_is_square()) return FurtherPoint(0.5 * first + 0.5, vec2(1.0 / float(further + 1u), 0.618033989), 0.0);
    const float turn = 6.2831853 / float(further + 1u), r2 = dot(first, first);
    return FurtherPoint(r2 > 0.0 ? first * inversesqrt(r2) : vec2(1.0, 0.0), vec2(cos(turn), sin(turn)), r2);
}

// What is proved or known without a ray is so of every point of the light. It is taken for a ray to one that is as good as random, made from
// that of whoever was asked before: were it the middle, or where the receiver's own ray went, such pixels would be asked more often than others,
// or when that ray is blocked, and would pull the mean towards what they say.
vec2 first_stand_in() {
    const float f = float(frame.frame_index & 0xffffu);
    if (HAS_LIGHT && light_is_square()) return 2.0 * fract(f * vec2(0.754877666, 0.569840291)) - 1.0;
    const float turn = 6.2831853 * fract(f * 0.754877666);
    return sqrt(fract(f * 0.569840291)) * vec2(cos(turn), sin(turn));
}

vec2 next_stand_in(vec2 p) {
    if (HAS_LIGHT && light_is_square()) return vec2(-p.y, p.x);
    return vec2(-0.7373688 * p.x - 0.6754903 * p.y, 0.6754903 * p.x - 0.7373688 * p.y);  // by the golden angle
}

void step_on(inout FurtherPoint p) {
    if (HAS_LIGHT && light_is_square()) {
        p.unit = fract(p.unit + p.turn);
        return;
    }
    p.unit = vec2(p.turn.x * p.unit.x - p.turn.y * p.unit.y, p.turn.y * p.unit.x + p.turn.x * p.unit.y);
    p.area = fract(p.area + 0.618033989);
}

vec2 point_of(FurtherPoint p) { return HAS_LIGHT && light_is_square() ? 2.0 * p.unit - 1.0 : sqrt(p.area) * p.unit; }

// What the rays around say that hit the receiver's disc; `otherwise` where they are too few.
Estimate asked_around(Receiver r, Reach reach, Penumbra penumbra, Estimate otherwise) {
    Window window;
    Horizon horizon = NO_HORIZON;
    if (HAS_RAY_POINTS) {
        window = window_of(penumbra, reach.limit_m, sqrt(reach.b1 * r.foot.s.s1 * reach.b2 * r.foot.s.s2));
        horizon = HAS_LIGHT ? horizon_of(r.lamp.horizon, 1.0) : horizon_of(r.n, penumbra.tangent);
    } else {
        const float most_m = UNSHEARED_PX * sqrt(r.foot.s.s1 * r.foot.s.s2);
        window = even_window(penumbra, min(UNSHEARED_SHARE * reach.limit_m, most_m));
    }
    const ViewRays around = HAS_LIGHT ? turned(r.rays, r.lamp.axes) : scaled(r.rays, window.by_radius);
    const float tolerance = HAS_LIGHT ? r.surface.tolerance_m : r.surface.tolerance_m * window.by_radius;
    const vec3 plane = HAS_LIGHT ? r.lamp.normal : r.n;
    const int at_p = r.p.y * int(frame.size.x) + r.p.x, last = int(frame.size.x * frame.size.y) - 1;
    Moments m = Moments(0.0, 0.0, 0.0, 0.0, 0.0, vec2(0.0), vec2(0.0), vec3(0.0));
    float further_asked = 0.0;
    const ReachRows reach_rows = rows_of(reach, mat2(r.foot.tangents[0].xy, r.foot.tangents[1].xy));
    vec2 stand_in = vec2(0.0);
    if (HAS_RAY_WORDS && HAS_RAY_POINTS) stand_in = first_stand_in();
    for (int dy = -reach.box.y; dy <= reach.box.y; ++dy) {
        const uint row = rows[r.in_rows.y + dy] >> uint(r.in_rows.x - R);
        const ivec2 span = row_of_reach(reach_rows, reach, dy);
        const ViewRays of_row = moved(around, vec2(0.0, float(dy)));
        for (int dx = span.x; dx <= span.y; ++dx) {
            vec3 at = seen_at(of_row, vec2(float(dx), 0.0), imageLoad(view_depth, r.p + ivec2(dx, dy)).x);
            bool usable = (row >> uint(dx + R + 16) & 1u) != 0u && abs(dot(plane, at)) <= tolerance;
            if (HAS_LIGHT) at = window.by_radius * place_of(r.lamp, at);
            vec2 point = vec2(0.0);
            if (HAS_RAY_POINTS) {
                const int of = clamp(at_p + dy * int(frame.size.x) + dx, 0, last);
                uint told = ray_points[of];
                if (HAS_KNOWN && !has_ray(clamp(r.p + ivec2(dx, dy), ivec2(0), ivec2(frame.size) - 1))) told = NO_POINT;
                point = unpack_point(told);
                if (HAS_RAY_WORDS) stand_in = point = told == NO_POINT ? next_stand_in(stand_in) : point;
                if (HAS_LIGHT) point = untwisted(r.lamp, at.xy / window.by_radius, point);
            }
            uint word = 0u, further = 0u;
            if (HAS_RAY_BITS && HAS_RAY_POINTS) {
                word = usable ? further_at(r.p + ivec2(dx, dy)) : 0u;
                further = further_count(word);
            }
            // Each by itself, most would be of pixels in the middle of the penumbra and all see it from one side; each pixel as one, few would
            // say most.
            const float part = inversesqrt(float(further + 1u));
            add_ray(m, usable, (row >> uint(dx + R) & 1u) != 0u, part, at, point, window, horizon);
            if (HAS_RAY_BITS && HAS_RAY_POINTS) {
                if (further != 0u) {
                    const float before = m.asked;
                    FurtherPoint next = further_point(point, further);
                    for (uint k = 0u; k < further; k += AT_ONCE)
                        [[unroll]] for (uint j = 0u; j < AT_ONCE; ++j) {
                            step_on(next);
                            add_ray(m, k + j < further, (word >> k + j & 1u) == 0u, part, at, point_of(next), window, horizon);
                        }
                    further_asked += m.asked - before;
                }
            }
        }
    }
    if (!(m.n > 0.0 && (m.asked > FEWEST || horizon.above == 1.0))) return otherwise;
    Estimate e = estimate_of(m, horizon);
    if (HAS_RAY_BITS) e.each = m.asked / max(m.asked - further_asked, 1.0);
    return e;
}

// Of a receiver with unlike rays around, some of them beyond its reach perhaps.
Estimate this_frame(Receiver r, Penumbra penumbra) {
    const Reach reach = reach_of(r.foot.s, penumbra);
    const uint columns = ((2u << uint(2 * reach.box.x)) - 1u) << uint(r.in_rows.x - reach.box.x);
    uint said = 0u;
    for (int dy = -reach.box.y; dy <= reach.box.y; ++dy)
        said |= said_by(rows[r.in_rows.y + dy]) & (columns | columns << 16);
    const bool mixed = has_both(said);
    Estimate e = Estimate(is_lit(r.in_rows) ? 1.0 : 0.0, 1.0, 1.0, 1.0);
    if (HAS_RAY_WORDS && !has_ray(r.p)) e = next_to(r);
    if (!mixed) e = agreement(r, reach.box, is_cut(penumbra));
    // Own ray only: a penumbra so narrow that no neighbour's can help.
    const bool asks = mixed && min(reach.b1, reach.b2) > 0.0 && max(reach.b1, reach.b2) >= OWN_RAY_PX;
    if (asks) e = asked_around(r, reach, penumbra, e);
    return e;
}
