// SPDX-License-Identifier: MIT
#include "host/scene/moved_boxes.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

blocks::MovedBoxes moved_block(const std::vector<std::array<glm::dvec3, 2>>& boxes,
                               const glm::dvec3& camera) {
    blocks::MovedBoxes block{};
    block.count = static_cast<uint32_t>(std::min(boxes.size(), std::size(block.boxes)));
    for (uint32_t i = 0; i < block.count; ++i)
        for (int axis = 0; axis < 3; ++axis) {
            block.boxes[i].lo.v[axis] = INFINITY;
            block.boxes[i].hi.v[axis] = -INFINITY;
        }
    for (size_t i = 0; i < boxes.size(); ++i) {
        auto& [low, high] = block.boxes[i * block.count / boxes.size()];
        for (int axis = 0; axis < 3; ++axis) {  // rounded away from the middle
            const auto least = static_cast<float>(boxes[i][0][axis] - camera[axis]),
                       most = static_cast<float>(boxes[i][1][axis] - camera[axis]);
            low.v[axis] = std::min(low.v[axis], std::nextafter(least, -INFINITY));
            high.v[axis] = std::max(high.v[axis], std::nextafter(most, INFINITY));
        }
    }
    return block;
}

}  // namespace penumbra
