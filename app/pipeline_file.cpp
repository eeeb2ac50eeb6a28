// SPDX-License-Identifier: MIT
#include "app/pipeline_file.h"

#include <iostream>

namespace penumbra {

std::optional<CheckedPipeline> open_pipeline(const std::string& file,
                                             const std::vector<std::string>& settings, const NodeSet& nodes) {
    Diagnostics diagnostics;
    const auto pipeline = load_pipeline(file, settings, diagnostics);
    auto checked = pipeline ? check(*pipeline, nodes, diagnostics) : std::nullopt;
    if (!checked) std::cerr << diagnostics.text();
    return checked;
}

}  // namespace penumbra
