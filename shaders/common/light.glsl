// SPDX-License-Identifier: MIT
// A light that is near: whom it can reach, and where a ray to one of its points goes and ends. Points are those of the unit disc,
// or of the square [-1, 1]^2 where the light is a rectangle or a tube.
//
// A disc and a rectangle are sampled evenly over their area. Of a sphere it is the cap that a receiver sees, evenly in solid angle,
// as the sun's, across the axes of frame_of_sphere(). A tube is the rectangle through its axis that faces the receiver.
//
// Includer has common/sun_sample.glsl and declares: block light.

// The share of the way that a ray does not go: what is so near to a light is its own housing.
const float LIGHT_HOUSING = 1e-4;

bool light_is_square() { return light.kind == LIGHT_RECTANGLE || light.kind == LIGHT_TUBE; }
bool light_is_flat() { return light.kind == LIGHT_DISC || light.kind == LIGHT_RECTANGLE; }

// Of a sphere around its centre that holds all of it.
float light_bound_m() {
    const float u = length(light.u), v = length(light.v);
    return light.kind == LIGHT_RECTANGLE ? length(vec2(u, v)) : light.kind == LIGHT_TUBE ? u + v : max(u, v);
}

// About that of a disc of its area; of a sphere its own.
float light_radius_m() { return light.kind == LIGHT_SPHERE ? light.u.x : sqrt(length(light.u) * length(light.v)); }

// Whether any of its light can arrive at a point `from_centre` metres from its middle: others are no receivers of it, and whoever
// is inside a sphere is none either.
bool light_reaches(vec3 from_centre) {
    const float distance_m = length(from_centre), height_m = dot(from_centre, light.facing);
    if (light.on == 0u || !(distance_m < light.range)) return false;
    if (light_is_flat()) return height_m > LIGHT_EDGE_ON * (distance_m + max(length(light.u), length(light.v)));
    if (light.kind != LIGHT_SPHERE) return true;
    // Straight behind a light that shines all around, -d > -d would leave a dark spot.
    return distance_m > light.u.x && (light.cos_outer <= -1.0 || height_m > light.cos_outer * distance_m);
}

// Whether it may reach a point of a box, from its middle as well: metres, empty if `lower` is above `upper`. A hundred-thousandth is left to
// rounding.
bool light_may_reach(vec3 lower, vec3 upper) {
    const vec3 middle = 0.5 * (lower + upper), half_size = 0.5 * (upper - lower);
    const float margin = 1e-5 * (length(middle) + length(half_size));
    if (light.on == 0u || !(lower.x <= upper.x) || length(max(abs(middle) - half_size, 0.0)) > light.range + margin) return false;
    const float height = dot(middle, light.facing);
    if (light_is_flat()) return height + dot(half_size, abs(light.facing)) + margin > 0.0;
    if (light.kind != LIGHT_SPHERE || light.cos_outer <= -1.0) return true;
    // How far the ball around the box is beside the cone.
    const float across = length(middle - height * light.facing);
    const float beside = light.cos_outer * across - sqrt(max(1.0 - light.cos_outer * light.cos_outer, 0.0)) * height;
    return beside <= length(half_size) + margin;
}

// Whether no point of it is above a receiver's horizon, whose normal is off by at most `normal_error`.
bool light_is_below(vec3 n, vec3 to_centre, float normal_error) {
    const float bound = light_bound_m();
    return dot(n, to_centre) + bound + normal_error * (length(to_centre) + bound) < 0.0;
}

struct LightRay {
    vec3 direction;  // unit
    float t_max;     // metres
    float t_plane;   // where it meets the plane through the light's middle
};

// The half axis of a tube's rectangle that faces a receiver, besides the one along the tube.
vec3 tube_side(Light l, vec3 to_centre) {
    const vec3 side = cross(l.u, to_centre);
    return l.v.x * side * inversesqrt(max(dot(side, side), 1e-30));
}

// Across the unit vector to a sphere, from one receiver to the next with as little turn about it as can be, so that they can ask
// each other's rays. Every field of axes has whirls: here there is one, where the sphere is straight below. (sun_frame() has a seam
// instead, which the sun alone does not mind.) 1 + y from x and z where y is negative, since it cancels there.
float by_pole(vec3 to) { return to.y < 0.0 ? (1.0 - to.y) / max(dot(to.xz, to.xz), 1e-30) : 1.0 / (1.0 + to.y); }

mat3 frame_of_sphere(vec3 to) {
    const float k = by_pole(to);
    return mat3(-to.x * to.z * k, -to.z, 1.0 - to.z * to.z * k,
                1.0 - to.x * to.x * k, -to.x, -to.x * to.z * k,
                to);
}

// `to_centre`: from the ray's start, outside of the light, to the light's middle.
LightRay light_ray(vec3 to_centre, vec2 point) {
    if (light.kind == LIGHT_SPHERE) {
        const float distance_m = length(to_centre), sine = min(light.u.x / distance_m, 1.0);
        const vec3 direction = frame_of_sphere(to_centre / distance_m) * in_cap(asin(sine), point);
        const float along = dot(direction, to_centre), off2 = max(distance_m * distance_m - along * along, 0.0);
        return LightRay(direction, (1.0 - LIGHT_HOUSING) * (along - sqrt(max(light.u.x * light.u.x - off2, 0.0))),
                        distance_m * distance_m / along);
    }
    const vec3 across = light.kind == LIGHT_TUBE ? tube_side(light, to_centre) : light.v;
    const vec3 to_point = to_centre + point.x * light.u + point.y * across;
    const float distance_m = length(to_point);
    return LightRay(to_point / distance_m, (1.0 - LIGHT_HOUSING) * distance_m, distance_m);
}

// Of the square, where `across` is the greater of |e.x| and |e.y| and both are 1 together: a trapezium's area. To the line's left, less 1/2.
float square_area(float across, float c) {
    const float along = 1.0 - across, beyond = max(abs(c) - (across - along), 0.0);
    const float corner = beyond * beyond / max(8.0 * across * along, 1e-20);
    return 0.5 * c / across - (c < 0.0 ? -corner : corner);
}

// The light's point for two numbers in [0, 1), areas kept: turning a disc is shifting u.x.
vec2 light_point(vec2 u) { return light_is_square() ? 2.0 * u - 1.0 : polar_disc(u); }
