#version 450
// SPDX-License-Identifier: MIT
// Conservative raster on any device: per triangle a rectangle of whole texels about it, whose corners are rounded
// outwards; the fragment stage keeps the texels that the triangle touches.
#extension GL_GOOGLE_include_directive : require
#include "cascade.glsl"
#include "cascade_margin.glsl"

layout(location = 0) flat out vec3 a;
layout(location = 1) flat out vec3 b;
layout(location = 2) flat out vec3 c;

const vec2 CORNERS[6] = vec2[](vec2(0, 0), vec2(1, 0), vec2(0, 1), vec2(0, 1), vec2(1, 0), vec2(1, 1));

void main() {
    const uint first = uint(gl_VertexIndex) / 6u * 3u;
    a = in_cascade(first);
    b = in_cascade(first + 1u);
    c = in_cascade(first + 2u);
    const float margin = margin_texels(a, b, c);
    const vec2 low = max(floor(min(min(a.xy, b.xy), c.xy) - margin), vec2(0.0));
    const vec2 high = min(ceil(max(max(a.xy, b.xy), c.xy) + margin), vec2(cascade.size));
    const bool seen = all(lessThan(low, high));  // false for NaN too
    const vec2 corner = mix(low, high, CORNERS[gl_VertexIndex % 6]);
    gl_Position = seen ? clip_position(corner, 0.5 * cascade.depth_m) : vec4(2.0, 2.0, 0.5, 1.0);
}
