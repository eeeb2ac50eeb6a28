// SPDX-License-Identifier: MIT
// The reconnection gather: what a neighbour's ray found is a sample of this pixel's integral too, with this pixel's response
// and all neighbours' densities. Pairwise multiple importance weights (Bitterli et al. 2020 for reservoirs; here over rays),
// normalised: the result is demodulated, and a constant stays what it is.
//   w_j = F_p(Q_j) / ((M-1) q_j(Q_j) + q_p(Q_j)),  w_p = mean over k of F_p(Q_p) / ((M-1) q_k(Q_p) + q_p(Q_p))
// with densities per area at the hit point Q. Without its normal the cosine there is left out, as if it were the same for all of them:
// close by, where it is not, what lies along a wall then counts too much.
//
// What a neighbour's ray found is taken to be seen from here. With ASKS one ray of the pixel asks, of the neighbour that makes most of a
// difference: what is hidden counts nothing.
//
// Includer has node.glsl and defines ASKS.
#include "common/camera.glsl"
#include "common/pixels.glsl"
#include "common/receiver_normal.glsl"
#include "common/rounded.glsl"
#include "common/same_surface.glsl"
#include "common/dithered.glsl"
#include "common/sun_sample.glsl"
#include "reflections/lobe.glsl"
#include "reflections/ray_texel.glsl"
#include "reflections/ray_word.glsl"
#include "reflections/radiance_word.glsl"
#include "reflections/gathered_texel.glsl"
#include "reflections/emitters.glsl"
#if ASKS
#include "common/hash.glsl"
#include "common/ray_origin.glsl"
#if BACKEND == BACKEND_RAY_QUERY
#include "common/ray_query.glsl"
#else
#include "common/bvh.glsl"
#endif
#endif

const int REACH = int(RADIUS), SIDE = 2 * REACH + 1, TAPS = SIDE * SIDE;


ivec2 tap(int i) { return ivec2(i % SIDE, i / SIDE) - REACH; }

// A point that a ray found, or the direction that it left in.
struct Found {
    vec3 at;  // camera-relative, or a unit vector
    vec3 normal;
    float m, cosine;  // how far away and how steeply the ray met it
};

bool is_far(Found f) { return !(f.m < NO_HIT_M); }

// A normal of 6 bits is off by .07 at most, but not along the axes; .03 and .07 in its place have 1 to 3 % fewer effective rays on one shot of
// five and as many on the others.
const float LEAST_COSINE = 0.005;

float cosine_at(vec3 normal, vec3 direction) {
    const float cosine = -dot(normal, direction);
    return cosine < -LEAST_COSINE ? 0.0 : max(cosine, LEAST_COSINE);
}

Found found(vec3 x, vec4 ray, RayWord word) {
    return Found(missed(ray) ? word.direction : x + abs(ray.w) * word.direction, word.hit_normal, abs(ray.w),
                 max(cosine_at(word.hit_normal, word.direction), LEAST_COSINE));
}

// How a pixel draws its ray.
struct Source {
    vec3 x;
    Lobe lobe;
    Emitter emitter;  // that it may be aimed at
};

Source source_at(ivec2 p, Shown s) {
    const uint number = HAS_AIMED ? rounded(255.0 * imageLoad(aimed, p).x) : 0u;
    return Source(s.x, make_lobe(s.n, to_viewer(p), s.roughness), emitter_of(number));
}

// Density and response per steradian. `in_cone`: where that is known better than by the direction's digits.
vec2 in_direction(Source s, vec3 l, bool in_cone) {
    vec2 both = density_and_response(s.lobe, l);
    if (HAS_AIMED) {
        if (s.emitter.radius > 0.0) both.x = 0.5 * (both.x + (in_cone ? cone_density(s.emitter, s.x) : 0.0));
    }
    return both;
}

vec2 in_direction(Source s, vec3 l) { return in_direction(s, l, HAS_AIMED && lies_in_cone(s.emitter, s.x, l)); }

// The same for what was found: per area there, in units of what its own ray saw.
vec2 at_found(Source s, Found f) {
    if (is_far(f)) return in_direction(s, f.at);
    const vec3 to = f.at - s.x;
    const float d2 = max(dot(to, to), 1e-10);
    const vec3 direction = to * inversesqrt(d2);
    // A small body's cone is narrower than the digits of the directions in which others found it.
    const float off_m = (f.normal == vec3(0.0) ? OFF : OFF_WIDE) * f.m;
    return in_direction(s, direction, HAS_AIMED && lies_in_cone(s.emitter, s.x, direction, off_m)) * (f.m * f.m * cosine_at(f.normal, direction) / (d2 * f.cosine));
}

struct Sums {
    float weight, squares;      // of w, of w^2
    vec3 radiance;              // of w L
    vec3 of_squares;            // of w^2 L
    float of_squares2;          // of w^2 |L|^2
    float inverse_m, moving;    // of w / distance, of w where the hit moves
};

void add(inout Sums s, float w, vec4 ray) {
    const float w2 = w * w;
    const vec3 found = radiance_of(ray);
    s.weight += w;
    s.squares += w2;
    s.radiance += w * found;
    s.of_squares += w2 * found;
    s.of_squares2 += w2 * dot(found, found);
    s.inverse_m += w / abs(ray.w);
    s.moving += ray.w < 0.0 ? w : 0.0;
}

const float MOST_SCALE = 1e6;  // its square is far from infinity

void scale(inout Sums s, float by) {
    const float by2 = by * by;
    s = Sums(s.weight * by, s.squares * by2, s.radiance * by, s.of_squares * by2, s.of_squares2 * by2, s.inverse_m * by, s.moving * by);
}

void store(ivec2 p, vec3 g, float distance_m, bool moving, float deviation, float samples) {
    const uvec2 words = encode_gathered(Gathered(g, distance_m, moving, deviation, samples), thresholds_at(p));
    store_gathered(p, uvec4(words, 0u, 0u));
}

bool near_plane(Shown here, Shown there) { return dot(here.n, there.n) > 0.9 && on_plane(here, there); }

// Which neighbours with a ray show the same surface, as bits; mirrors have nothing to give.
uint kept_taps(ivec2 p, Shown here) {
    uint kept = 0u;
    const OffPlane plane = off_plane(view_rays(p, mat3(1.0)), here.n, here.x);
    for (int i = 0; i < TAPS; ++i) {
        const ivec2 o = tap(i);
        const uvec2 there = surface_texel(p + o);
        const float z = surface_depth(there);
        const bool near = o != ivec2(0) && z > 0.0 && abs(metres_off(plane, vec2(o), z)) < ON_PLANE * here.z && near_normal(here, there);
        if (near && !is_mirror(surface_roughness(there)) && has_ray(texelFetch(radiance, p + o, 0))) kept |= 1u << uint(i);
    }
    return kept;
}

float response_over_density(vec2 both) { return both.y / max(both.x, 1e-30); }

// Whether another pixel's ray went where that one or this one might have aimed it: what is taken to be around such things is not of them.
bool at_a_body(Source s, vec3 x_q, vec3 direction, vec4 ray) {
    return HAS_AIMED && (went_into_cone(ray) || lies_in_cone(s.emitter, x_q, direction));
}

vec3 direction_of(ivec2 p, float roughness) { return decode_ray_word(texelFetch(ray_direction, p, 0).x, roughness).direction; }

// The mean of what rays around found, and of the inverse of how far away: of those on the same plane, or of all that met no body.
struct Surroundings {
    vec3 radiance;
    float inverse_m, rays;
};

Surroundings surroundings(ivec2 p, Source s, Shown here, bool same_plane) {
    Surroundings mean = Surroundings(vec3(0.0), 0.0, 0.0);
    const int RINGS = 4;  // where few pixels have rays all of those near may have met bodies: then up to seven times as far away
    for (int k = 0; k < RINGS * TAPS && (k % TAPS != 0 || mean.rays == 0.0); ++k) {
        const ivec2 q = p + (2 * (k / TAPS) + 1) * tap(k % TAPS);
        const Shown there = shown(q);
        if (q == p || !(there.z > 0.0)) continue;
        const vec4 ray = texelFetch(radiance, q, 0);
        if (!has_ray(ray) || HAS_AIMED && went_below(ray)) continue;
        if (same_plane ? !near_plane(here, there) : at_a_body(s, there.x, direction_of(q, there.roughness), ray)) continue;
        mean = Surroundings(mean.radiance + radiance_of(ray), mean.inverse_m + 1.0 / abs(ray.w), mean.rays + 1.0);
    }
    const float each = 1.0 / max(mean.rays, 1.0);
    return Surroundings(mean.radiance * each, mean.inverse_m * each, mean.rays);
}

// No ray but the pixel's own tells of its lobe. Has it none, what its surface sees around it stands in, as no sample at all. A ray that
// might have been aimed counts as much as it has to; what it then lacks is taken from others', whatever they are of: without a bias, and
// what is the same everywhere stays so.
void store_alone(ivec2 p, Source s, float roughness, vec4 own, Surroundings around) {
    if (!has_ray(own)) {
        store(p, around.radiance, around.rays > 0.0 ? 1.0 / max(around.inverse_m, 1e-10) : 0.0, false, 0.0, 0.0);
        return;
    }
    vec3 radiance = radiance_of(own);
    if (HAS_AIMED) {
        const float weight = went_below(own) ? 0.0 : response_over_density(in_direction(s, direction_of(p, roughness), went_into_cone(own)));
        if (around.rays > 0.0) radiance = max(around.radiance + weight * (radiance - around.radiance), 0.0);
    }
    store(p, radiance, abs(own.w), own.w < 0.0, 0.0, 1.0);
}

// A neighbour, drawn in proportion to what it makes of a difference.
struct Choice {
    float u, sum;
    int tap;
};

void offer(inout Choice choice, int i, float difference) {
    choice.sum += difference;
    const float share = difference / max(choice.sum, 1e-30);
    if (choice.u < share) {
        choice.tap = i;
        choice.u /= share;
    } else {
        choice.u = (choice.u - share) / max(1.0 - share, 1e-6);
    }
}

// The rays of a window as their own pixels drew them.
struct Window {
    vec4 lobes;      // response over density in the lobe and that times L, of rays that met no body
    vec4 beside;     // the gather's weight of these, of that times L
    float response;  // response over density, of rays that were not aimed
    float rays;      // how many these are
    float aimed;     // of how many might have been
};

// `s`: of the pixel whose ray it is.
void add(inout Window window, Source s, vec4 ray, vec3 direction, float w, bool of_body) {
    const float in_lobe = HAS_AIMED && went_below(ray) ? 0.0 : sample_weight(s.lobe, direction);
    const vec4 found = vec4(radiance_of(ray), 1.0);
    if (!of_body) window.lobes += in_lobe * found;
    if (HAS_AIMED) {
        window.aimed += s.emitter.radius > 0.0 ? 1.0 : 0.0;
        if (!was_aimed(ray)) window.response += in_lobe;
        if (!was_aimed(ray)) window.rays += 1.0;
        if (!of_body) window.beside += w * found;
    }
}

// Sums over the pixel's ray and those of the neighbours that are kept but not hidden; these count as densities all the same, since they
// could have found what is seen.
Sums gather(ivec2 p, uint kept, uint hidden, Source source, float roughness, vec4 own, out Window window, inout Choice choice) {
    const float others = float(bitCount(kept));
    const bool ray_here = has_ray(own);
    const RayWord own_word = decode_ray_word(texelFetch(ray_direction, p, 0).x, roughness);
    const Found own_found = found(source.x, own, own_word);
    vec2 own_lobe = in_direction(source, own_word.direction, went_into_cone(own));
    if (HAS_AIMED && went_below(own)) own_lobe.y = 0.0;
    Sums sums = Sums(0.0, 0.0, vec3(0.0), vec3(0.0), 0.0, 0.0, 0.0);
    window = Window(vec4(0.0), vec4(0.0), 0.0, 0.0, 0.0);
    float own_weight = 0.0;
    for (int i = 0; i < TAPS; ++i) {
        if ((kept >> uint(i) & 1u) == 0u) continue;
        const ivec2 q = p + tap(i);
        const Shown shown_q = shown(q);
        const Source source_q = source_at(q, shown_q);
        const vec4 ray = texelFetch(radiance, q, 0);
        const RayWord word = decode_ray_word(texelFetch(ray_direction, q, 0).x, shown_q.roughness);
        const vec2 here = at_found(source, found(shown_q.x, ray, word)), there = in_direction(source_q, word.direction, went_into_cone(ray));
        const float w = HAS_AIMED && went_below(ray) ? 0.0 : here.y / max(others * there.x + here.x, 1e-30);
        if (ASKS == 0 || (hidden >> uint(i) & 1u) == 0u) add(sums, w, ray);
        if (ASKS == 1) offer(choice, i, w * length(ray_here ? radiance_of(ray) - radiance_of(own) : radiance_of(ray)));
        add(window, source_q, ray, word.direction, w, at_a_body(source, shown_q.x, word.direction, ray));
        if (!ray_here) continue;
        const float of_own = at_found(source_q, own_found).x;
        own_weight += own_lobe.y / max(others * of_own + own_lobe.x, 1e-30);
    }
    if (ray_here) {
        add(sums, own_weight / others, own);
        add(window, source, own, own_word.direction, own_weight / others, at_a_body(source, source.x, own_word.direction, own));
    }
    return sums;
}

#if ASKS
Found found_by(ivec2 q, Shown there) {
    return found(there.x, texelFetch(radiance, q, 0), decode_ray_word(texelFetch(ray_direction, q, 0).x, there.roughness));
}

// Whether something hides from the pixel what a ray found, and how far away that may be. A hit is known less well than its surface is
// thin: its direction has 10 bits and its distance 11. So the ray ends short of it, and off its surface where that is known.
bool hides(ivec2 p, vec3 n, Found f, out float blocker_m) {
    const float OFF = 0.005, WAY = 0.97;
    const RayStart start = ray_start(p, n);
    const vec3 target = f.at + scene.camera_from_origin + OFF * f.m * f.normal;
    const vec3 origin = is_far(f) ? ray_origin(start, n, f.at) : ray_origin_to(start, n, target), way = is_far(f) ? f.at : target - origin;
    float t = 0.0;
    const bool hidden = occluded_at(origin, way, 0.0, is_far(f) ? 1e30 : WAY, t);
    blocker_m = t * length(way);
    return hidden;
}

// Where the pixel does not see what the chosen neighbour found: the neighbours of which it is taken to see nothing, as bits. Those are
// who found what is near that, and all on that side if what hides it stands beside the pixel, as a wall does on which it borders.
uint hidden_with(ivec2 p, uint kept, int chosen, vec3 x, vec3 n) {
    const float NEAR = 0.5, ON_SIDE = 0.25, BESIDE = 4.0;
    const ivec2 asked = p + tap(chosen);
    const Shown shown_asked = shown(asked);
    const vec3 way = shown_asked.x - x;
    const Found there = found_by(asked, shown_asked);
    float blocker_m;
    if (!hides(p, n, there, blocker_m)) return 0u;
    const bool beside = blocker_m < BESIDE * length(way);
    const float reach = NEAR * (is_far(there) ? 1.0 : distance(there.at, x));
    uint hidden = 1u << uint(chosen);
    for (int i = 0; i < TAPS; ++i) {
        if ((kept >> uint(i) & 1u) == 0u) continue;
        const ivec2 q = p + tap(i);
        const Shown shown_q = shown(q);
        const Found f = found_by(q, shown_q);
        const bool near = is_far(f) == is_far(there) && distance(f.at, there.at) < reach;
        if (near || beside && dot(shown_q.x - x, way) > ON_SIDE * dot(way, way)) hidden |= 1u << uint(i);
    }
    return hidden;
}
#endif

const float LEAST_INTEGRAL = 0.25;  // of a response: few rays may tell of less than any lobe has

void for_pixel(ivec2 p) {
    const Shown here = shown(p);
    if (!(here.z > 0.0)) {
        store(p, vec3(0.0), 0.0, false, 0.0, 0.0);
        return;
    }
    const vec4 own = texelFetch(radiance, p, 0);
    const float roughness = here.roughness;
    const Source source = source_at(p, here);
    const bool ray_here = has_ray(own);
    const uint kept = !HAS_RAY_DIRECTION || is_mirror(roughness) ? 0u : kept_taps(p, here);
    Sums sums = Sums(0.0, 0.0, vec3(0.0), vec3(0.0), 0.0, 0.0, 0.0);
    Window window = Window(vec4(0.0), vec4(0.0), 0.0, 0.0, 0.0);
    Choice choice = Choice(0.0, 0.0, -1);
#if ASKS
    const uint number = noise_hash(uint(p.x) ^ noise_hash(uint(p.y) ^ noise_hash(frame.frame_index)));
    choice.u = noise_unit(uvec2(number)).x;
#endif
    if (kept != 0u) sums = gather(p, kept, 0u, source, roughness, own, window, choice);
#if ASKS
    const uint hidden = is_wide(roughness) && choice.tap >= 0 ? hidden_with(p, kept, choice.tap, source.x, source.lobe.n) : 0u;
    if (hidden != 0u) {  // what the pixel sees in its place is like the rest of what it sees
        const float all = sums.weight;
        sums = gather(p, kept, hidden, source, roughness, own, window, choice);
        if (!(window.aimed > 0.0)) scale(sums, min(all / max(sums.weight, 1e-20), MOST_SCALE));
    }
#endif
    const bool alone = !(sums.weight > 1e-20), stand_in = alone && !ray_here;
    const bool lacks = HAS_AIMED && (alone ? source.emitter.radius > 0.0 || went_below(own) : window.aimed > 0.0 && !(window.beside.w > 0.0));
    Surroundings around = Surroundings(vec3(0.0), 0.0, 0.0);
    if (stand_in || lacks) around = surroundings(p, source, here, stand_in);
    if (alone) {
        store_alone(p, source, roughness, own, around);
        return;
    }

    // Weights sum up to the response's integral in the mean, which neighbours' rays tell well. Divided by their sum instead, what only
    // some pixels find well is too faint, in every frame; so what the sum lacks or has too much of is their mean radiance.
    const bool wide = ray_here && is_wide(roughness) && window.lobes.w > 0.0;
    float integral = wide ? window.lobes.w / (float(bitCount(kept)) + 1.0) : sums.weight;
    vec3 mean = vec3(0.0);
    if (wide) mean = window.lobes.rgb / window.lobes.w;
    if (HAS_AIMED) {  // the sum tells of how many were aimed: it is not divided by, and the mean is that of the others
        if (window.aimed > 0.0) integral = LOBE == LOBE_DIFFUSE || window.rays == 0.0 ? 1.0 : max(window.response / window.rays, LEAST_INTEGRAL);
        if (window.aimed > 0.0 && window.beside.w > 0.0 && !wide) mean = window.beside.rgb / window.beside.w;
        if (lacks) mean = around.rays > 0.0 ? around.radiance : sums.radiance / sums.weight;  // all went into their cones
    }
    const vec3 g = max((sums.radiance + mean * (integral - sums.weight)) / integral, 0.0);
    const float samples = sums.weight * sums.weight / sums.squares;
    const float spread = sums.of_squares2 - 2.0 * dot(g, sums.of_squares) + dot(g, g) * sums.squares;
    const float variance = max(spread, 0.0) / (integral * integral) * samples / max(samples - 1.0, 0.5);
    store(p, g, sums.weight / sums.inverse_m, sums.moving > 0.1 * sums.weight, sqrt(variance), samples);
}
