// SPDX-License-Identifier: MIT
// penumbra check: every error of every file, on standard error.
#include "app/commands.h"
#include "app/pipeline_file.h"
#include "nodes/nodes.h"

namespace penumbra {

int run_check(const std::vector<std::string>& pipelines) {
    const NodeSet nodes = shadow_nodes();
    bool good = true;
    for (const std::string& file : pipelines) good = open_pipeline(file, {}, nodes).has_value() && good;
    return good ? exit_good : exit_wrong;
}

}  // namespace penumbra
