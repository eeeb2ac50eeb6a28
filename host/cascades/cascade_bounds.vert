#version 450
// SPDX-License-Identifier: MIT
// Conservative raster on any device: a texel touches a triangle exactly where its centre lies in the triangle grown by the
// texel's own square (their Minkowski sum), a convex polygon of at most seven corners: at each vertex those corners of
// the square that lie between the outward normals of its two sides. It is drawn as a fan, a little larger still, for what
// the rasteriser rounds. Where rounding leaves a doubt which way the triangle turns, a box of whole texels is drawn
// instead; the fragment stage keeps the texels that are touched.
#extension GL_GOOGLE_include_directive : require
#include "cascade.glsl"
#include "cascade_margin.glsl"

layout(set = 0, binding = 3, std430) readonly buffer Large {
    uint vertex_count, instance_count, first_vertex, first_instance;
    uint triangles[];
} large;

layout(location = 0) flat out vec3 a;
layout(location = 1) flat out vec3 b;
layout(location = 2) flat out vec3 c;

const int FAN[15] = int[](0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5, 0, 5, 6);
const float SURE_TURN = 1e-5;       // of the products that a turn is the difference of, which are good to 4e-7
const float FAR_MAPS = 16.0;        // sides of the map: farther vertices leave it to the box, which is clamped to the map

float turn(vec2 u, vec2 v) { return u.x * v.y - u.y * v.x; }

// Of the outward normal of a side of a triangle that turns from x to y, counted in that direction.
int quadrant(vec2 side) {
    const vec2 n = vec2(side.y, -side.x);
    return n.x >= 0.0 ? (n.y >= 0.0 ? 0 : 3) : (n.y >= 0.0 ? 1 : 2);
}

vec2 corner(int q) { return vec2((q & 3) == 0 || (q & 3) == 3 ? 1.0 : -1.0, (q & 3) < 2 ? 1.0 : -1.0); }

void main() {
    const uint first = 3u * large.triangles[uint(gl_VertexIndex) / 15u];
    const int at = FAN[gl_VertexIndex % 15];
    a = in_cascade(first);
    b = in_cascade(first + 1u);
    c = in_cascade(first + 2u);
    const float margin = margin_texels(a, b, c);

    vec2 low, high;
    texel_box(a, b, c, low, high);
    const vec2 box[4] = vec2[](low, vec2(high.x, low.y), high, vec2(low.x, high.y));
    vec2 place = box[min(at, 3)];

    const vec2 ab = b.xy - a.xy, ac = c.xy - a.xy;
    const float area = turn(ab, ac);
    const bool turns = area > 0.0;
    const vec2 p = a.xy, q = turns ? b.xy : c.xy, s = turns ? c.xy : b.xy;
    const int q0 = quadrant(q - p), q1 = quadrant(s - q), q2 = quadrant(p - s);
    const int at_p = (q0 - q2) & 3, at_q = (q1 - q0) & 3, at_s = (q2 - q1) & 3;
    const vec2 largest = max(max(abs(a.xy), abs(b.xy)), abs(c.xy));
    if (abs(area) > SURE_TURN * (abs(ab.x * ac.y) + abs(ab.y * ac.x)) && at_p + at_q + at_s == 4 &&
        max(largest.x, largest.y) < FAR_MAPS * cascade.size) {
        const int in_q = at - (at_p + 1), in_s = in_q - (at_q + 1);
        const vec2 vertex = in_q < 0 ? p : in_s < 0 ? q : s;
        const int which = in_q < 0 ? q2 + at : in_s < 0 ? q0 + in_q : q1 + in_s;
        place = vertex + (0.5 + margin + cascade.raster_margin) * corner(which);
    }
    gl_Position = clip_position(place, 0.5 * cascade.depth_m);
}
