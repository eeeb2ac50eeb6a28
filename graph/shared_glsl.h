// SPDX-License-Identifier: MIT
// The GLSL that every node may include (what shaders/ has beside the nodes' own, penumbra/frame_block.glsl),
// embedded by the build: a user's node compiles without penumbra's source tree. Names are as an #include
// spells them.
#pragma once

#include "graph/embedded_file.h"

namespace penumbra {

std::span<const EmbeddedFile> shared_glsl();

}  // namespace penumbra
