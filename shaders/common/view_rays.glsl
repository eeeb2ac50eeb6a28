// SPDX-License-Identifier: MIT
// What pixels around some pixel see, and whether it is the same surface: the one place that knows how far a point lies off
// a receiver's plane. A distance to a plane needs no angle-dependent tolerance at grazing views and no absolute length.
//
// Includer has camera.glsl.

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

// Along other axes.
ViewRays turned(ViewRays v, mat3 axes) {
    return ViewRays(axes * v.o, axes * v.ox, axes * v.oy, axes * v.r, axes * v.rx, axes * v.ry);
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

// A surface that a pixel shows. Others show it whose points lie within its tolerance of its plane.
struct Surface {
    OffPlane plane;
    float tolerance_m;
};

// `rays`: around the pixel; `n`: in their axes.
Surface surface_at(ViewRays rays, vec3 n, float view_depth, float tolerance_px) {
    return Surface(off_plane(rays, n, rays.o + view_depth * rays.r), tolerance_px * pixel_span_m(view_depth));
}

// A comparison that a NaN fails.
bool shows(Surface s, vec2 offset_px, float view_depth) {
    return abs(metres_off(s.plane, offset_px, view_depth)) <= s.tolerance_m;
}
