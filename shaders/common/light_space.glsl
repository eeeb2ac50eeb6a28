// SPDX-License-Identifier: MIT
// What a patch of the image looks like from the sun. Light space is metres along the axes of sun_frame(): x and y across
// the light, z towards the sun, camera-relative. A ray to the sun's point xi (a disc of radius 1) of a receiver at L, z
// passes height h at L + (h - z) tan(angular radius) xi.
//
// Includer has camera.glsl and sun_sample.glsl.

// The points that pixels around some pixel see: o + x ox + y oy + depth (r + x rx + y ry) for the pixel x, y away.
struct ViewRays {
    vec3 o, ox, oy, r, rx, ry;
};

// Taken over the whole image, differences do not round away.
ViewRays view_rays(ivec2 p, mat3 rotation) {
    const vec2 uv = pixel_uv(p) - frame.jitter, by_size = 1.0 / vec2(frame.size);
    const vec3 o = position_at(uv, 0.0), ox = position_at(uv + vec2(1.0, 0.0), 0.0), oy = position_at(uv + vec2(0.0, 1.0), 0.0);
    const vec3 r = position_at(uv, 1.0) - o, rx = position_at(uv + vec2(1.0, 0.0), 1.0) - ox,
               ry = position_at(uv + vec2(0.0, 1.0), 1.0) - oy;
    return ViewRays(rotation * o, rotation * (ox - o) * by_size.x, rotation * (oy - o) * by_size.y, rotation * r,
                    rotation * (rx - r) * by_size.x, rotation * (ry - r) * by_size.y);
}

ViewRays moved(ViewRays v, vec2 px) {
    v.o += px.x * v.ox + px.y * v.oy;
    v.r += px.x * v.rx + px.y * v.ry;
    return v;
}

vec3 seen_at(ViewRays v, vec2 offset_px, float view_depth) {
    return v.o + offset_px.x * v.ox + offset_px.y * v.oy + view_depth * (v.r + offset_px.x * v.rx + offset_px.y * v.ry);
}

// In units of 1 / scale metres.
ViewRays scaled(ViewRays v, float scale) {
    return ViewRays(scale * v.o, scale * v.ox, scale * v.oy, scale * v.r, scale * v.rx, scale * v.ry);
}

// How far what those pixels see lies off a plane: linear in their offset and in their depth, so that a pixel that asks
// several neighbours pays for the plane once.
struct OffPlane {
    float o, ox, oy, r, rx, ry;
};

OffPlane off_plane(ViewRays v, vec3 n, vec3 on_plane) {
    return OffPlane(dot(n, v.o - on_plane), dot(n, v.ox), dot(n, v.oy), dot(n, v.r), dot(n, v.rx), dot(n, v.ry));
}

float metres_off(OffPlane v, vec2 offset_px, float view_depth) {
    return v.o + offset_px.x * v.ox + offset_px.y * v.oy + view_depth * (v.r + offset_px.x * v.rx + offset_px.y * v.ry);
}

// How the seen point moves per pixel along x and y if the surface is the plane with this normal. Seen edge-on, a plane
// has no such derivative; the limit is that of 1 degree.
const float EDGE_ON = 0.0175;

mat2x3 tangents(ViewRays v, float view_depth, vec3 n) {
    const float facing = dot(n, v.r), least = EDGE_ON * length(v.r);
    const float by_facing = 1.0 / (facing < 0.0 ? min(facing, -least) : max(facing, least));
    const vec3 x = v.ox + view_depth * v.rx, y = v.oy + view_depth * v.ry;
    return mat2x3(x - v.r * (dot(n, x) * by_facing), y - v.r * (dot(n, y) * by_facing));
}

// A 2x2 map as two stretches: unit vectors along the image axes and how long their images are, the larger first.
struct Stretches {
    vec2 first, second;
    float s1, s2;
};

Stretches stretches_of(mat2 j) {
    const float a = dot(j[0], j[0]), b = dot(j[0], j[1]), c = dot(j[1], j[1]);
    const float middle = 0.5 * (a + c), half_difference = 0.5 * (a - c);
    const float radius = sqrt(half_difference * half_difference + b * b);
    // The better conditioned of the two forms of the eigenvector of [a b; b c].
    const vec2 v = half_difference >= 0.0 ? vec2(half_difference + radius, b) : vec2(b, radius - half_difference);
    const float length2 = dot(v, v);
    Stretches s;
    s.first = length2 > 0.0 ? v * inversesqrt(length2) : vec2(1.0, 0.0);
    s.second = vec2(-s.first.y, s.first.x);
    s.s1 = sqrt(middle + radius);
    s.s2 = sqrt(max(middle - radius, 0.0));
    return s;
}
