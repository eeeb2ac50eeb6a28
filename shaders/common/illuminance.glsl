// SPDX-License-Identifier: MIT
// Lux on a surface under a light that is near, if nothing stands between them.
//
// Includer has common/light.glsl.

// Of what a light has left after a distance, so that nothing is lit beyond its range without a step there, and of a spot's cone:
// as KHR_lights_punctual recommends both.
float within_range(float distance_m) {
    const float share = distance_m / light.range, share2 = share * share;
    return clamp(1.0 - share2 * share2, 0.0, 1.0);
}
float within_cone(vec3 from_centre) {
    if (light.cos_outer <= -1.0) return 1.0;
    const float cosine = dot(from_centre, light.facing) / length(from_centre);
    const float share = clamp((cosine - light.cos_outer) / max(light.cos_inner - light.cos_outer, 1e-3), 0.0, 1.0);
    return share * share;
}

// A sphere's is that of its middle, where all of it is above the horizon; other shapes are sixteen points.
vec3 unshadowed_lux(vec3 n, vec3 to_centre) {
    if (!light_reaches(-to_centre)) return vec3(0.0);
    const float distance_m = length(to_centre);
    if (light.kind == LIGHT_SPHERE)  // whose colour is an intensity
        return light.color * max(dot(n, to_centre), 0.0) / (distance_m * distance_m * distance_m) * within_range(distance_m) * within_cone(-to_centre);
    vec3 across = light.v, facing = light.facing;
    if (light.kind == LIGHT_TUBE) {
        const vec3 side = cross(light.u, to_centre);
        const vec3 unit_side = side * inversesqrt(max(dot(side, side), 1e-30));
        across = light.v.x * unit_side;
        facing = normalize(cross(light.u, unit_side));
        if (dot(facing, to_centre) > 0.0) facing = -facing;
    }
    float sum = 0.0;
    for (int i = 0; i < 16; ++i) {
        const vec2 u = (vec2(i & 3, i >> 2) + 0.5) / 4.0, point = light_is_square() ? 2.0 * u - 1.0 : concentric_disc(u);
        const vec3 to_point = to_centre + point.x * light.u + point.y * across;
        const float d2 = dot(to_point, to_point);
        sum += max(dot(n, to_point), 0.0) * max(-dot(facing, to_point), 0.0) / (d2 * d2);
    }
    const float area = (light_is_square() ? 4.0 : 3.14159265) * length(light.u) * length(across);
    return light.color * (sum / 16.0 * area * within_range(distance_m));
}
