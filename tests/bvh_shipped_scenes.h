// SPDX-License-Identifier: MIT
// The scenes that come with the project, as the host would trace them.
#pragma once

#include <vector>

#include "tests/bvh_scenes.h"

namespace penumbra::test {

// The first frame of every shot in scenes/. Throws with the diagnostics where one cannot be read.
std::vector<TriangleScene> shipped_scenes();

inline std::vector<TriangleScene> all_scenes() {
    std::vector<TriangleScene> scenes = made_scenes();
    for (TriangleScene& s : shipped_scenes()) scenes.push_back(std::move(s));
    return scenes;
}

}  // namespace penumbra::test
