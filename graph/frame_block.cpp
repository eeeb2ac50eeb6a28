// SPDX-License-Identifier: MIT
// Reprojection is formed as P_prev * R_prev^-1 * T(current - previous) with every factor in double precision
// and only the product rounded: an fp32 product of absolute matrices is wrong by 20 px at 10^5 m from the
// origin.
#include "penumbra/frame_block.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>

namespace penumbra {
namespace {

std140::mat4 to_block(const glm::dmat4& m) {
    std140::mat4 out;
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) out.columns[c][r] = static_cast<float>(m[c][r]);
    return out;
}

std140::vec2 to_block(const std::array<double, 2>& v) {
    return {{static_cast<float>(v[0]), static_cast<float>(v[1])}};
}

}  // namespace

std::array<double, 16> perspective(double vertical_fov_rad, double aspect, double near) {
    const double f = 1.0 / std::tan(0.5 * vertical_fov_rad);
    // Columns. z_clip = near, w_clip = view depth = -z_view: depth = near / view depth.
    return {f / aspect, 0, 0, 0, 0, -f, 0, 0, 0, 0, 0, -1, 0, 0, near, 0};
}

FrameBlock make_frame_block(const FrameDescription& frame, uint32_t device_sub_pixel_bits) {
    const glm::dmat4 clip_from_view = glm::make_mat4(frame.camera.clip_from_view.data());
    const glm::dmat3 world_from_view = glm::make_mat3(frame.camera.world_from_view.data());
    const glm::dmat4 prev_clip_from_view = glm::make_mat4(frame.previous.clip_from_view.data());
    const glm::dmat3 prev_world_from_view = glm::make_mat3(frame.previous.world_from_view.data());
    glm::dvec3 delta;
    for (int i = 0; i < 3; ++i) delta[i] = frame.previous.position[i] - frame.camera.position[i];

    FrameBlock block{};
    block.clip_from_view = to_block(clip_from_view);
    block.view_from_clip = to_block(glm::inverse(clip_from_view));
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r)
            block.world_from_view.columns[c][r] = static_cast<float>(world_from_view[c][r]);
    block.prev_clip_from_rel =
        to_block(prev_clip_from_view * glm::dmat4(glm::transpose(prev_world_from_view)) *
                 glm::translate(glm::dmat4(1.0), -delta));
    for (int i = 0; i < 3; ++i) block.camera_delta.v[i] = static_cast<float>(delta[i]);
    block.near_m = static_cast<float>(frame.camera.near_m);
    block.jitter = to_block(frame.jitter);
    block.prev_jitter = to_block(frame.prev_jitter);
    for (int i = 0; i < 2; ++i) {
        block.size.v[i] = frame.size[i];
        block.prev_size.v[i] = frame.prev_size[i];
    }
    // A pixel spans 2 / size in ndc.
    for (int i = 0; i < 2; ++i) {
        const double across = std::max(frame.size[size_t(i)], 1u) * std::abs(clip_from_view[i][i]);
        block.pixel_angle = std::max(block.pixel_angle, static_cast<float>(2 / across));
    }
    if (const double slope = prev_clip_from_view[2][2]; slope != 0)
        block.prev_depth = to_block(std::array{1 / slope, -prev_clip_from_view[3][2] / slope});
    block.dt_s = frame.dt_s;
    block.frame_index = frame.index;
    block.flags = frame.flags & ~uint32_t{frame_unchanged};
    // Half a step of the grid that vertices are rounded to (shaders/common/ray_offset.glsl).
    const uint32_t bits = frame.sub_pixel_bits ? frame.sub_pixel_bits : device_sub_pixel_bits;
    block.grid_px = static_cast<float>(std::ldexp(0.5, -static_cast<int>(bits)));
    block.snap_px = (frame.flags & frame_depth_at_centres) != 0 ? 0 : block.grid_px;
    return block;
}

}  // namespace penumbra
