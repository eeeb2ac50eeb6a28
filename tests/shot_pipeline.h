// SPDX-License-Identifier: MIT
// A shipped pipeline as the program opens it for a shot.
#pragma once

#include <filesystem>
#include <stdexcept>

#include "app/pipeline_file.h"
#include "tests/view_run.h"

namespace penumbra::test {

inline CheckedPipeline pipeline_for(const Shot& shot, const std::string& name,
                                    const std::vector<std::string>& settings = {}) {
    Diagnostics diagnostics;
    auto pipeline = load_pipeline(std::filesystem::path(PENUMBRA_SOURCE_DIR) / "pipelines" / (name + ".json"),
                                  settings, diagnostics);
    if (pipeline) name_lights(*pipeline, shot, "", diagnostics);
    auto result = pipeline ? check(*pipeline, test_nodes(), diagnostics) : std::nullopt;
    if (!result || !diagnostics.empty()) throw std::runtime_error(diagnostics.text());
    return std::move(*result);
}

}  // namespace penumbra::test
