// SPDX-License-Identifier: MIT
// A session of one of the pipelines that the program carries in itself (app/reference_pipeline.h), for a
// truth.
#pragma once

#include "app/session.h"

namespace penumbra {

struct OwnPipeline {
    const char* text;
    const char* name;  // for errors
    std::vector<std::string> settings = {};
};

// At the shot's size, without a search for the smallest heap. Where `options` capture nothing, all of the
// pipeline's outputs are captured.
std::unique_ptr<Session> open_own(Device& device, const Shot& shot, const OwnPipeline& own,
                                  SessionOptions options, Diagnostics& diagnostics,
                                  std::vector<std::string>& warnings);

}  // namespace penumbra
