// SPDX-License-Identifier: MIT
// Lower bounds of one triangle within one texel, exact up to rounding, which is always towards the sun: its least depth,
// and how far below a plane of the given slope through the texel's centre it reaches. A linear function on the part of a
// triangle inside a square is least at an end of a clipped side or at a corner of the square that the triangle covers.
// Includer has cascade.glsl and cascade_margin.glsl.

const float NO_SURFACE_M = 1e30;
const float ROUNDING = 4.8e-7;  // four ulps

vec2 per_texel;  // the plane's rise in metres
vec2 least;

void take(vec3 p) {
    least = min(least, vec2(p.z, p.z - dot(per_texel, p.xy)));
}

// The part of a side inside the square of half width r about the origin.
void take_side(vec3 p, vec3 q, float r) {
    vec2 d = q.xy - p.xy;
    d = mix(d, vec2(1e-20), lessThan(abs(d), vec2(1e-20)));
    const vec2 t_a = (-r - p.xy) / d, t_b = (r - p.xy) / d;
    const vec2 enter = min(t_a, t_b), leave = max(t_a, t_b);
    const float from = max(max(enter.x, enter.y), 0.0), to = min(min(leave.x, leave.y), 1.0);
    if (!(from <= to)) return;
    take(mix(p, q, from));
    take(mix(p, q, to));
}

float cross2(vec2 u, vec2 v) { return u.x * v.y - u.y * v.x; }

// The least depth, and the plane's at the texel's centre; NO_SURFACE_M where the triangle does not touch the texel.
vec2 bounds_in_texel(vec3 a, vec3 b, vec3 c, ivec2 texel, vec2 slope) {
    const vec3 centre = vec3(vec2(texel) + 0.5, 0.0);
    per_texel = slope * cascade.texel_m;
    least = vec2(NO_SURFACE_M);

    const float r = 0.5 + margin_texels(a, b, c);
    const vec3 p = a - centre, q = b - centre, s = c - centre;
    const float turn = cross2(q.xy - p.xy, s.xy - p.xy) < 0.0 ? -1.0 : 1.0;
    const float nearest = min(min(p.z, q.z), s.z), farthest = max(max(p.z, q.z), s.z);
    int covered = 0;
    for (int corner = 0; corner < 4; ++corner) {
        const vec2 at = r * vec2((corner & 1) * 2 - 1, (corner & 2) - 1);
        const vec3 w = turn * vec3(cross2(s.xy - q.xy, at - q.xy), cross2(p.xy - s.xy, at - s.xy),
                                   cross2(q.xy - p.xy, at - p.xy));
        const float sum = w.x + w.y + w.z;
        if (min(min(w.x, w.y), w.z) >= 0.0 && sum > 0.0) {
            take(vec3(at, clamp(dot(w, vec3(p.z, q.z, s.z)) / sum, nearest, farthest)));
            ++covered;
        }
    }
    if (covered < 4) {  // or no side runs through the square
        take_side(p, q, r);
        take_side(q, s, r);
        take_side(s, p, r);
    }
    if (!(least.x < NO_SURFACE_M)) return vec2(NO_SURFACE_M);
    const float reach = r * (abs(per_texel.x) + abs(per_texel.y));
    return least - ROUNDING * (abs(farthest) + abs(nearest) + vec2(0.0, reach));
}
