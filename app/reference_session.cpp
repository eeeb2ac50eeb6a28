// SPDX-License-Identifier: MIT
#include "app/reference_session.h"

#include "penumbra/shadow_nodes.h"

namespace penumbra {

std::unique_ptr<Session> open_own(Device& device, const Shot& shot, const OwnPipeline& own,
                                  SessionOptions options, Diagnostics& diagnostics,
                                  std::vector<std::string>& warnings) {
    static const NodeSet nodes = shadow_nodes();  // plans point into it
    const auto pipeline = parse_pipeline(own.text, own.name, own.settings, diagnostics);
    const auto checked = pipeline ? check(*pipeline, nodes, diagnostics) : std::nullopt;
    if (!checked) return nullptr;
    options.size = shot.size;
    if (options.captures.empty()) options.captures = checked->output_names();
    return Session::open(device, nodes, *checked, shot, options, diagnostics, warnings);
}

}  // namespace penumbra
