// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "host/truth/counted_visibility.h"
#include "penumbra/frame_block.h"

namespace penumbra {

// What pixels show, in the tree's frame, in double precision from the frame's own camera.
class ViewRays {
  public:
    ViewRays(const FrameDescription& frame, const glm::dvec3& scene_origin)
        : frame_(frame),
          clip_(glm::make_mat4(frame.camera.clip_from_view.data())),
          axes_(glm::make_mat3(frame.camera.world_from_view.data())),
          eye_(glm::make_vec3(frame.camera.position.data()) - scene_origin) {}

    ViewRay at(uint32_t x, uint32_t y) const {
        const glm::dvec2 size(frame_.size[0], frame_.size[1]);
        const glm::dvec2 uv =
            (glm::dvec2(x, y) + 0.5) / size - glm::dvec2(frame_.jitter[0], frame_.jitter[1]);
        const glm::dvec2 ndc = 2.0 * uv - 1.0, scale(clip_[0].x, clip_[1].y);
        const double pixel = 2 / (size.y * std::abs(scale.y)),
                     grid_px = std::ldexp(0.5, -int(frame_.sub_pixel_bits));
        if (frame_.flags & frame_orthographic)
            return {eye_ + axes_ * glm::dvec3((ndc - glm::dvec2(clip_[3])) / scale, 0), -axes_[2], pixel, 0,
                    grid_px};
        return {eye_, axes_ * glm::dvec3((ndc + glm::dvec2(clip_[2])) / scale, -1), 0, pixel, grid_px};
    }

  private:
    FrameDescription frame_;
    glm::dmat4 clip_;
    glm::dmat3 axes_;
    glm::dvec3 eye_;
};

}  // namespace penumbra
