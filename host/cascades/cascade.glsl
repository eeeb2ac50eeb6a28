// SPDX-License-Identifier: MIT
// What the cascades' stages share: triangles as rays see them, and where a cascade lies.
layout(set = 0, binding = 0, std430) readonly buffer Triangles { float coordinates[]; };  // 9 per triangle

layout(push_constant) uniform Constants {
    vec4 texels_from_metres[3];  // rows: u and v in texels, metres from depth 0
    float size;                  // texels along a side
    float depth_m;               // metres per unit of depth
    float texel_m;
    int layer;
    uint triangle_count;
    float raster_margin;  // texels by which the rasteriser may move a vertex
} cascade;

// u and v in texels, metres along the light.
vec3 in_cascade(uint corner) {
    const uint at = 3u * corner;
    const vec4 p = vec4(coordinates[at], coordinates[at + 1u], coordinates[at + 2u], 1.0);
    return vec3(dot(cascade.texels_from_metres[0], p), dot(cascade.texels_from_metres[1], p),
                dot(cascade.texels_from_metres[2], p));
}

vec4 clip_position(vec2 texel, float metres) {
    return vec4(2.0 * texel / cascade.size - 1.0, metres / cascade.depth_m, 1.0);
}
