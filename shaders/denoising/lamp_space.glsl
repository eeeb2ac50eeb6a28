// SPDX-License-Identifier: MIT
// Light space of a light that is near. With D a receiver's distance from the light's plane, x its place along the light's half axes, in these,
// u = x / D and w = 1 / D: a ray from u_j, w_j to the light's point y passes the plane of w at u_j + y (w - w_j), as one to the sun's
// point passes a height; planes stay planes. So what is true of (lateral metres, height, the sun's radius) is of (u, w, 1), and the sun is
// the limit of large D. Everything here is relative to one receiver and in units of its own 1 / D: blockers at w_b make its disc
// D w_b - 1 wide, the way of its rays to them over the way from there on to the light.
//
// Includer has common/light.glsl and common/light_axes.glsl.

struct LampSpace {
    mat3 axes;      // to the light's coordinates
    vec3 normal;    // of the receiver's plane, in these: metres off it
    vec2 at;        // the receiver's own u, per metre
    float depth_m;  // D
    vec3 horizon;   // a point y of the light is above the receiver's plane where dot(horizon, (y, 1)) is positive
    vec2 twist;     // of a sphere's axes, from here to a place nearby: radians, over its u
};

// `from_centre`: the receiver, whose normal is `n`.
LampSpace lamp_space(vec3 from_centre, vec3 n) {
    const LightAxes a = light_axes(light, from_centre);
    LampSpace s;
    s.axes = light_coordinates(a);
    const vec3 here = s.axes * from_centre;
    s.depth_m = max(here.z, 1e-6);
    s.at = here.xy / s.depth_m;
    s.normal = vec3(dot(n, a.u), dot(n, a.v), dot(n, a.away));
    s.horizon = vec3(s.normal.xy, -dot(n, from_centre));
    s.twist = vec2(0.0);
    if (light.kind == LIGHT_SPHERE) {
        const vec3 to = -a.away;
        s.twist = -by_pole(to) / s.depth_m * vec2(to.x * a.u.z - to.z * a.u.x, to.x * a.v.z - to.z * a.v.x);
    }
    return s;
}

// Of something next to the receiver, its way from there in the light's coordinates: its place.
vec3 place_of(LampSpace s, vec3 way) {
    const float by_depth = 1.0 / (s.depth_m + way.z);
    return vec3((way.xy - s.at * way.z) * (s.depth_m * by_depth), -way.z * by_depth);
}

// The same of a derivative.
vec3 moves_by(LampSpace s, vec3 metres) {
    const vec3 way = s.axes * metres;
    return vec3(way.xy - s.at * way.z, -way.z / s.depth_m);
}

// A point of a sphere, as the receiver at `place` names it, as this one does: the axes have turned about it on the way.
vec2 untwisted(LampSpace s, vec2 place, vec2 point) {
    const float angle = dot(s.twist, place);
    return point + angle * vec2(-point.y, point.x);
}
