// SPDX-License-Identifier: MIT
// The frame block made from two cameras. All differences of positions are taken in double precision, so that
// the picture does not depend on where in the world the camera stands.
#pragma once

#include <array>
#include <cstdint>

#include "penumbra/export.h"

namespace penumbra PENUMBRA_API {

namespace std140 {
using uint = uint32_t;
struct alignas(8) vec2 {
    float v[2];
};
struct alignas(8) uvec2 {
    uint32_t v[2];
};
struct vec3 {
    float v[3];
};  // the GLSL file follows each vec3 with a float, which fills the slot
struct alignas(16) mat3 {
    float columns[3][4];
};
struct alignas(16) mat4 {
    float columns[4][4];
};
#include "penumbra/frame_block.glsl"
static_assert(sizeof(FrameBlock) == 64 * 3 + 48 + 16 + 32 + 16 + 16);
}  // namespace std140

using std140::FrameBlock;

// frame_depth_at_centres: each depth was computed exactly at its pixel's centre; a rasteriser interpolates it
// for a point up to half a sub-pixel step away.
//
// frame_unchanged: apart from jitter and index, all that the host brings is as in the previously recorded
// frame; View::settled() counts it, and it is not in the block.
enum FrameFlags : uint32_t {
    frame_reset = 1,
    frame_orthographic = 2,
    frame_depth_at_centres = 4,
    frame_unchanged = 8
};

// A camera in double precision. The view looks along its -z axis, x right, y up.
struct Camera {
    std::array<double, 3> position{0, 0, 0};                           // metres, world
    std::array<double, 9> world_from_view{1, 0, 0, 0, 1, 0, 0, 0, 1};  // columns: right, up, back
    // Columns; unjittered, Vulkan clip (y down). All zeros: none, for a pipeline that asks for no camera.
    std::array<double, 16> clip_from_view{};
    double near_m = 0.05;
    friend bool operator==(const Camera&, const Camera&) = default;
};

// Infinite reverse-Z perspective: depth = near_m / view_depth. aspect = width / height.
std::array<double, 16> perspective(double vertical_fov_rad, double aspect, double near_m);

struct FrameDescription {
    // Of this frame, and of the one recorded before it, whatever frames the host has left out in between.
    Camera camera, previous;
    // In uv, how far right and down the image was shifted when it was drawn: a pixel shows what the
    // unjittered image has at its centre's uv - jitter. The host adds 2 * w * jitter to clip-space xy.
    std::array<double, 2> jitter{0, 0}, prev_jitter{0, 0};
    std::array<uint32_t, 2> size{0, 0};  // pixels
    // Of the last recorded frame, for make_frame_block() alone: a view knows it.
    std::array<uint32_t, 2> prev_size{1, 1};
    // Counts the recorded frames, in steps of 1: per-frame random numbers derive from it, and so does
    // which frames may have had the same jitter (docs/coverage.md, "While the camera stands still").
    uint32_t index = 0;
    float dt_s = 0;  // since the frame before
    uint32_t flags = 0;
    // VkPhysicalDeviceLimits::subPixelPrecisionBits of the device that rasterised the depth; 0: of the view's
    // own. A depth that nobody rasterised is as exact as its texels, which any number of bits is safe for.
    uint32_t sub_pixel_bits = 0;
};

// `device_sub_pixel_bits` stands in where the frame has 0; its default is the least that Vulkan allows.
FrameBlock make_frame_block(const FrameDescription& frame, uint32_t device_sub_pixel_bits = 4);

}  // namespace penumbra
