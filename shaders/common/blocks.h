// SPDX-License-Identifier: MIT
// Uniform blocks that the host passes as inputs (std140) and constants of the dataflow, shared by C++ and GLSL.
#ifdef __cplusplus
#pragma once
#include <cstdint>
namespace penumbra::blocks {
struct vec3 { float v[3]; };
#endif

struct Sun {
    vec3 to_sun;           // unit, world axes
    float angular_radius;  // radians
};

struct Scene {
    vec3 camera_from_origin;  // metres: camera position in the BVH's frame, differenced in double precision
    float padding;
};

#ifdef __cplusplus
static_assert(sizeof(Sun) == 16 && sizeof(Scene) == 16);
}
#endif
