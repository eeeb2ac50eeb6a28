// SPDX-License-Identifier: MIT
// What the standalone program's host brings to a pipeline, frame by frame, and what comes out, as files:
// other hosts are fed with the one and held to the other. In FOLDER/FRAME/: SLOT.bin (an image's or a texel
// buffer's texels, a block's bytes), frame.bin (FrameDescription), frame_block.bin, and OUTPUT.out.
#pragma once

#include <filesystem>

#include "penumbra/check.h"
#include "penumbra/plan.h"

namespace penumbra::test {

// All but alpha-tested triangles, which no recorded scene has.
Facts recorded_facts();

// The plaza (test_scene.h), whose camera, objects and sun move. Returns the standalone program's plan.
Plan record_plaza(const CheckedPipeline& pipeline, std::array<uint32_t, 2> size, uint32_t frames,
                  const std::filesystem::path& folder);

}  // namespace penumbra::test
