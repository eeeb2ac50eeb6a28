// SPDX-License-Identifier: MIT
#include "app/signal_pipeline.h"

#include <fmt/format.h>

#include "app/host_slots.h"

namespace penumbra {

std::optional<CheckedPipeline> signal_pipeline(const std::filesystem::path& file, const std::string& signal,
                                               const std::vector<std::string>& settings, const NodeSet& nodes,
                                               Diagnostics& diagnostics) {
    std::vector<std::string> all = settings;
    all.push_back(fmt::format("outputs=[\"{}\"]", signal));
    const auto pipeline = load_pipeline(file, all, diagnostics);
    auto checked = pipeline ? check(*pipeline, nodes, diagnostics) : std::nullopt;
    if (!checked) return std::nullopt;
    for (const HostInput& input : checked->inputs)
        if (!input.optional && !standalone_has_input(input.name)) {
            diagnostics.add({file.string(), 0, 0}, input.name, "is what only an engine can bring");
            return std::nullopt;
        }
    return checked;
}

}  // namespace penumbra
