// SPDX-License-Identifier: MIT
#include "app/pipeline_file.h"

#include <iostream>

#include "app/shipped_files.h"

namespace penumbra {

std::optional<CheckedPipeline> open_pipeline(const std::string& file,
                                             const std::vector<std::string>& settings, const NodeSet& nodes) {
    Diagnostics diagnostics;
    const auto found = shipped_file(file, shipped_root(), shipped_pipelines, diagnostics);
    const auto pipeline = found ? load_pipeline(*found, settings, diagnostics) : std::nullopt;
    auto checked = pipeline ? check(*pipeline, nodes, diagnostics) : std::nullopt;
    if (!checked) std::cerr << diagnostics.text();
    return checked;
}

}  // namespace penumbra
