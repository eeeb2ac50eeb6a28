// SPDX-License-Identifier: MIT
// Uniform blocks that the host passes as inputs (std140) and constants of the dataflow, shared by C++ and GLSL.
#ifdef __cplusplus
#pragma once
#include <cstdint>
namespace penumbra::blocks {
using uint = uint32_t;
struct vec3 { float v[3]; };
struct alignas(16) mat3x4 { float columns[3][4]; };
#endif

struct Sun {
    vec3 to_sun;           // unit, world axes
    float angular_radius;  // radians
};

struct Scene {
    vec3 camera_from_origin;  // metres: camera position in the BVH's frame, differenced in double precision
    float padding;
};

// A shadow map's place: vec4(camera-relative metres, 1) * map = u, v in 0..1 and depth, 0 at the sun's side. Texels are
// square; depth 0 is no farther from the sun than the topmost caster.
struct Cascade {
    mat3x4 map;
    float texel_m;  // width of a texel
    float depth_m;  // metres per unit of depth
};

// The bounds are conservative: every surface in every texel that it touches, however thin. What an ordinary raster finds
// at texels' centres is not, and proves nothing.
const uint BOUNDS_HOLD_ALL = 1u;

struct Cascades {
    uint count;  // 0..4, finest first; each layer of the maps is one
    uint flags;  // BOUNDS_HOLD_ALL, or nothing is promised
    Cascade c[4];
};

// Directions, over half a circle, that the tables of light_mask.glsl know lines of.
const uint HALF_PLANE_DIRECTIONS = 64u;

#ifdef __cplusplus
static_assert(sizeof(Cascade) == 64 && sizeof(Cascades) == 272);
static_assert(sizeof(Sun) == 16 && sizeof(Scene) == 16);
}
#endif
