// SPDX-License-Identifier: MIT
// How a light that is near lies to whoever receives its light: the half axes of the shape that its rays go to, and which way is away from
// that shape's plane. A sphere shows the circle where rays touch it, on the plane through its middle; a tube the rectangle through its axis.
//
// Includer has common/light.glsl.

const float LEAST_HALF_AXIS_M = 1e-6;  // of a light that its size has left

struct LightAxes {
    vec3 u, v;  // metres
    vec3 away;  // unit
};

// `from_centre`: where the receiver is, outside of the light.
LightAxes light_axes(Light l, vec3 from_centre) {
    if (l.kind == LIGHT_SPHERE) {
        const float distance2 = dot(from_centre, from_centre), by_distance = inversesqrt(max(distance2, 1e-30));
        const mat3 frame = frame_of_sphere(-by_distance * from_centre);
        const float r = max(l.u.x, LEAST_HALF_AXIS_M), r2 = r * r;  // a point has coordinates, too
        const float shown = r * sqrt(distance2 / max(distance2 - r2, 1e-3 * r2 + 1e-30));
        return LightAxes(shown * frame[0], shown * frame[1], by_distance * from_centre);
    }
    if (l.kind == LIGHT_TUBE) {
        const vec3 away = from_centre - l.u * (dot(l.u, from_centre) / max(dot(l.u, l.u), 1e-30));
        return LightAxes(l.u, tube_side(l, -from_centre), away * inversesqrt(max(dot(away, away), 1e-30)));
    }
    return LightAxes(l.u, l.v, l.facing);
}

// To the light's own coordinates: along its half axes, in these, and away from its plane in metres.
mat3 light_coordinates(LightAxes a) {
    const float least = LEAST_HALF_AXIS_M * LEAST_HALF_AXIS_M;
    return transpose(mat3(a.u / max(dot(a.u, a.u), least), a.v / max(dot(a.v, a.v), least), a.away));
}
