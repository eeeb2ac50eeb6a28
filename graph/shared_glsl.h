// SPDX-License-Identifier: MIT
// The GLSL that every node may include (shaders/common/*, graph/frame_block.glsl), embedded by the build: a
// user's node compiles without penumbra's source tree.
#pragma once

#include <span>
#include <string_view>

namespace penumbra {

struct SharedGlsl {
    std::string_view name;  // as an #include spells it: "common/camera.glsl"
    std::string_view text;
};

std::span<const SharedGlsl> shared_glsl();

}  // namespace penumbra
