// SPDX-License-Identifier: MIT
// What an average over the last frame's light is worth under this frame's (sun_change.glsl, whose disc this is of any shape). The last
// frame's light, as the receiver sees it, is projected onto this one's plane.
//
// Includer has common/light_axes.glsl and common/sun_change.glsl.

// A way from the receiver to where it meets the light's plane, along its axes. `at`: the receiver; both in the light's coordinates.
vec2 on_light(vec3 at, vec3 way) { return at.xy - way.xy * (at.z / way.z); }

// Of the longer of two sides, of which one goes from -1 to 1.
float shared_side(float middle, float half_width) {
    return 0.5 * max(min(1.0, middle + half_width) - max(-1.0, middle - half_width), 0.0) / max(half_width, 1.0);
}

// Share of the larger of both frames' lights where both are, seen from `p`; 0 where there was none.
float light_share(Light now, Light before, vec3 p) {
    if (before.on == 0u || before.kind != now.kind) return 0.0;
    const vec3 from_now = p - now.centre, from_before = p - before.centre;
    const LightAxes was = light_axes(before, from_before);
    const mat3 axes = light_coordinates(light_axes(now, from_now));
    const vec3 at = axes * from_now, middle_way = -(axes * from_before);
    if (!(middle_way.z < -1e-3 * at.z) || !(at.z > 0.0)) return 0.0;  // it was not before the receiver
    const vec2 middle = on_light(at, middle_way);
    const vec2 u = on_light(at, middle_way + axes * was.u) - middle, v = on_light(at, middle_way + axes * was.v) - middle;
    if (light_is_square()) {
        // Turned, it leaves the corners that its sides have moved by.
        const float turned = max(1.0 - 0.5 * (abs(u.y) + abs(v.x)), 0.0);
        return shared_side(middle.x, abs(u.x)) * shared_side(middle.y, abs(v.y)) * turned;
    }
    return shared_share(1.0, sqrt(abs(u.x * v.y - u.y * v.x)), length(middle));
}
