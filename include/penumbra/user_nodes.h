// SPDX-License-Identifier: MIT
// Nodes of a user's own, without rebuilding anything: a folder of declarations (NAME.json), each with its
// shader beside it. A variant of a shader is compiled when the first plan needs it, and kept on disk.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "penumbra/check.h"
#include "penumbra/export.h"
#include "penumbra/node_set.h"

namespace penumbra PENUMBRA_API {

// What has been compiled, on disk. `warn` is told what had to be thrown away and that a folder cannot be
// written.
class ShaderCache;
// $XDG_CACHE_HOME/penumbra, or ~/.cache/penumbra; empty where neither variable is an absolute path.
std::filesystem::path default_shader_cache();
// In a folder of the host's; nowhere for an empty path.
std::shared_ptr<ShaderCache> open_shader_cache(const std::filesystem::path& folder,
                                               std::function<void(const std::string&)> warn = {});

// Adds every NAME.json of the folder (but *.schema.json, which an editor may want there). A name that the set
// has already is an error: a pipeline must not change its meaning by the folder it is run with. Where
// anything is wrong, nothing is added. `cache`: nullptr for one in the default place.
bool add_user_nodes(NodeSet& nodes, const std::filesystem::path& folder, Diagnostics& diagnostics,
                    std::shared_ptr<ShaderCache> cache = nullptr);

// Compiles every variant of the user nodes that a pipeline holds, not just those that one plan needs.
bool compile_user_nodes(const CheckedPipeline& pipeline, Diagnostics& diagnostics);

}  // namespace penumbra
