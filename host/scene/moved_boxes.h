// SPDX-License-Identifier: MIT
// What has moved, for passes that keep what nothing has touched.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "shaders/common/blocks.h"

namespace penumbra {

// `boxes`: least and greatest corners, in the frame in which the camera is at `camera`; of more than the
// block holds some share one.
blocks::MovedBoxes moved_block(const std::vector<std::array<glm::dvec3, 2>>& boxes, const glm::dvec3& camera);

}  // namespace penumbra
