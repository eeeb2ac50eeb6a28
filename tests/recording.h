// SPDX-License-Identifier: MIT
// What the standalone program's host brings to a pipeline, frame by frame, and what comes out: other hosts
// are fed with the one and held to the other.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "host/shots/shot.h"
#include "penumbra/check.h"
#include "penumbra/frame_block.h"
#include "penumbra/plan.h"

namespace penumbra::test {

using Bytes = std::vector<std::byte>;

struct RecordedFrame {
    FrameDescription description;
    std::map<std::string, Bytes>
        slots;  // an image's or a texel buffer's texels, a buffer's or a block's bytes
    std::map<std::string, Bytes> outputs;
};

struct Recording {
    Plan plan;  // the standalone program's
    std::vector<RecordedFrame> frames;
};

// All but alpha-tested triangles, which no recorded scene has.
Facts recorded_facts();

Recording record(const CheckedPipeline& pipeline, const Shot& shot, uint32_t frames, const Facts& facts,
                 bool jitter = true);

// The plaza (test_scene.h), whose camera, objects and sun move, as files. In FOLDER/FRAME/: SLOT.bin,
// frame.bin (FrameDescription), frame_block.bin, and OUTPUT.out. Returns the plan.
Plan record_plaza(const CheckedPipeline& pipeline, std::array<uint32_t, 2> size, uint32_t frames,
                  const std::filesystem::path& folder);

}  // namespace penumbra::test
