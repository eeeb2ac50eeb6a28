// SPDX-License-Identifier: MIT
// Uniform blocks that the host passes as inputs (std140) and constants of the dataflow, shared by C++ and GLSL.
#ifdef __cplusplus
#pragma once
#include <cstdint>
namespace penumbra::blocks {
using uint = uint32_t;
struct vec3 { float v[3]; };
struct alignas(16) vec4 { float v[4]; };
struct alignas(16) mat3x4 { float columns[3][4]; };
#endif

struct Sun {
    vec3 to_sun;           // unit, world axes
    float angular_radius;  // radians
};

// What a local light's rays end at (docs/lights.md).
const uint LIGHT_SPHERE = 0u;     // also points and spots; a radius of 0 is a point
const uint LIGHT_DISC = 1u;       // lights what it faces
const uint LIGHT_RECTANGLE = 2u;  // lights what it faces
const uint LIGHT_TUBE = 3u;       // turns its broad side to whoever looks

// What faces one way is edge-on, and lights nothing, up to a height of this share of the distance to its middle and of its larger half axis: by
// rounding alone, points of a wall that a panel is flush with would be now before it and now behind it.
const float LIGHT_EDGE_ON = 1e-4f;

// A light that is near. Discs, rectangles and tubes have a luminance in candelas per square metre, spheres an intensity in candelas.
struct Light {
    vec3 centre;      // camera-relative metres, world axes
    uint kind;        // LIGHT_SPHERE ..
    vec3 u;           // half axis: the disc's, half the rectangle's or the tube's; of a sphere (radius, 0, 0)
    float range;      // metres; nothing beyond is lit
    vec3 v;           // the other half axis; of a tube (radius, 0, 0)
    float cos_outer;  // of a spot's cone, where its light ends; -1: no spot
    vec3 facing;      // unit; of discs, rectangles and spots
    float cos_inner;  // of the cone in which a spot has all of its light
    vec3 color;       // linear; candelas, or candelas per square metre
    uint on;          // 0: nothing receives light from it
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

// What casts shadows and has moved, appeared, vanished or changed its shape since the frame before: a box around each thing, where it was
// and where it is. Things may share one.
const uint MOST_MOVED_BOXES = 64u;

struct MovedBox {
    vec4 lo, hi;  // camera-relative metres; w: unused
};

struct MovedBoxes {
    uint count;
    uint unused0, unused1, unused2;
    MovedBox boxes[MOST_MOVED_BOXES];
};

// Directions, over half a circle, that the tables of light_mask.glsl know lines of.
const uint HALF_PLANE_DIRECTIONS = 64u;

#ifdef __cplusplus
static_assert(sizeof(Cascade) == 64 && sizeof(Cascades) == 272);
static_assert(sizeof(Light) == 80 && sizeof(MovedBoxes) == 16 + 32 * MOST_MOVED_BOXES);
static_assert(sizeof(Sun) == 16 && sizeof(Scene) == 16);
}
#endif
