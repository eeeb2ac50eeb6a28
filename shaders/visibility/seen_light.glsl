// SPDX-License-Identifier: MIT
// The light as the start of a pixel's rays sees it, for leaf_cover.glsl. The sun's axes are at right angles, and so are a sphere's, whose cap
// has a disc for its samples. Of a disc, a rectangle and a tube the axes are those of the light itself: with U, V its half axes and L its
// middle, a corner is v = z (x U + y V + L), so that a line of the light's plane is a line of the table, however it is seen.
//
// Includer has common/light.glsl, common/ray_origin.glsl, common/cone_slabs.glsl, light_mask.glsl and leaf_cover.glsl and declares: block light, scene.

struct SeenLight {
    Receiver receiver;
    LightShape shape;
    ConeSlabs slabs;  // of a cone that holds it
    mat3 span;        // span * (x, y, 1) is the way to a point of it
};

const float UNBOUNDED_M = 3e38;

Receiver sun_receiver(RayStart start, mat3 axes, vec2 noise) {
    const float angle = 6.283185307179586 * noise.x, c = cos(angle), s = sin(angle);
    return Receiver(start.off_surface, start.beyond_edge_m, c * axes[0] + s * axes[1], c * axes[1] - s * axes[0], axes[2], line_dither(noise.y), false, UNBOUNDED_M, UNBOUNDED_M);
}

// A point is a disc of a millionth of a radian.
SeenLight seen_sphere(RayStart start, vec3 to_centre, vec2 noise) {
    const float distance_m = length(to_centre), sine = clamp(light.u.x / distance_m, 1e-6, 0.9999), cosine = sqrt(1.0 - sine * sine);
    SeenLight seen;
    seen.receiver = sun_receiver(start, sun_frame(to_centre / distance_m), noise);
    seen.receiver.before = (1.0 - LIGHT_HOUSING) * (1.0 - sine) * distance_m;
    seen.receiver.behind = cosine * cosine * distance_m;
    seen.shape = sun_shape(0.0);
    seen.shape.radius = sine / cosine;
    seen.shape.per_radius = cosine / sine;
    seen.shape.cap = vec2(sine * sine / (1.0 + cosine), sine * sine);
    seen.slabs = cone_slabs(seen.receiver.z, seen.shape.radius, 0.0);
    seen.slabs.reach = seen.receiver.behind;
    seen.span = mat3(seen.receiver.x, seen.receiver.y, seen.receiver.z);
    return seen;
}

// Of the pyramid over a light's parallelogram, all of which lies ahead along `axis`.
ConeSlabs pyramid_slabs(vec3 axis, vec3 u, vec3 v, vec3 to_centre) {
    vec3 lower = vec3(3e38), upper = vec3(-3e38);
    float reach = 0.0;
    for (int i = 0; i < 4; ++i) {
        const vec3 to_corner = to_centre + ((i & 1) != 0 ? u : -u) + ((i & 2) != 0 ? v : -v);
        const float along = dot(to_corner, axis);
        reach = max(reach, along);
        lower = min(lower, to_corner / max(along, 1e-30));
        upper = max(upper, to_corner / max(along, 1e-30));
    }
    const vec3 rounding = 1e-6 + 1e-6 * max(abs(lower), abs(upper));
    ConeSlabs slabs = slabs_of_slopes(lower - rounding, upper + rounding);
    slabs.reach = reach;
    return slabs;
}

SeenLight seen_plane(RayStart start, vec3 to_centre, vec2 noise) {
    vec3 u = light.u, v = light.v;
    if (light.kind == LIGHT_TUBE) v = tube_side(light, to_centre);
    SeenLight seen;
    seen.shape = sun_shape(0.0);
    seen.shape.radius = seen.shape.per_radius = 1.0;
    seen.shape.square = light_is_square();
    // A square has eight ways to lie, a disc any.
    const float angle = 6.283185307179586 * noise.x, eighth = floor(8.0 * noise.x);
    const vec3 u0 = u, v0 = v;
    if (seen.shape.square) {
        const bool swapped = eighth >= 4.0;
        u = (mod(eighth, 2.0) < 1.0 ? 1.0 : -1.0) * (swapped ? v0 : u0);
        v = (mod(eighth, 4.0) < 2.0 ? 1.0 : -1.0) * (swapped ? u0 : v0);
    } else {
        u = cos(angle) * u0 + sin(angle) * v0;
        v = cos(angle) * v0 - sin(angle) * u0;
    }
    vec3 away = cross(u, v);  // none of a tube that is seen along its axis
    away *= inversesqrt(max(dot(away, away), 1e-37));
    float height_m = dot(to_centre, away);
    // A start may lie in the light's plane, where nothing is to be seen of it.
    seen.receiver.mirrored = height_m < 0.0;
    if (seen.receiver.mirrored) away = -away;
    height_m = max(abs(height_m), 1e-6 * length(to_centre));
    seen.receiver.start = start.off_surface;
    seen.receiver.beyond_edge_m = start.beyond_edge_m;
    seen.receiver.x = (u - away * (dot(to_centre, u) / height_m)) / max(dot(u, u), 1e-30);
    seen.receiver.y = (v - away * (dot(to_centre, v) / height_m)) / max(dot(v, v), 1e-30);
    seen.receiver.z = away / height_m;
    seen.receiver.dither = line_dither(noise.y);
    seen.receiver.before = seen.receiver.behind = 1.0 - LIGHT_HOUSING;
    // Around the way to its plane, whose every section is the light, scaled, and where it ends; where that is nearly edge-on, to its middle,
    // unless corners may lie beside that.
    const float distance_m = length(to_centre), size_m = length(u) + length(v);
    const bool edge_on = distance_m + size_m > 64.0 * height_m && size_m < 0.6 * distance_m;
    seen.slabs = pyramid_slabs(edge_on ? to_centre / distance_m : away, u, v, to_centre);
    seen.slabs.reach *= 1.0 - LIGHT_HOUSING;
    seen.span = mat3(u, v, to_centre);
    return seen;
}

// `noise`: what turns the samples, and rounds.
SeenLight seen_light(RayStart start, vec2 noise) {
    const vec3 to_centre = light.centre + scene.camera_from_origin - start.off_surface;
    SeenLight seen;
    if (light.kind == LIGHT_SPHERE) seen = seen_sphere(start, to_centre, noise);
    if (light.kind != LIGHT_SPHERE) seen = seen_plane(start, to_centre, noise);
    return seen;
}

SeenLight seen_sun(RayStart start, mat3 axes, LightShape shape, ConeSlabs slabs, vec2 noise) {
    const Receiver r = sun_receiver(start, axes, noise);
    return SeenLight(r, shape, slabs, mat3(r.x, r.y, r.z));
}

// The line across the light above which the receiver's own plane hides nothing.
vec3 lit_side(SeenLight seen, vec3 normal) { return normal * seen.span; }

// The way of a ray to a point of the table, as far as it goes.
vec3 way_to_sample(SeenLight seen, vec2 point) {
    const vec3 d = to_sample(seen.shape, point);
    float share = 1.0;
    if (HAS_LIGHT) share = light.kind == LIGHT_SPHERE ? surface_along(seen.receiver, d) : seen.receiver.before;
    return share * (d.x * seen.span[0] + d.y * seen.span[1] + d.z * seen.span[2]);
}
