// SPDX-License-Identifier: MIT
// Penumbra's own node types, with their shaders and tables, and what they speak of: a scene and its sun.
#pragma once

#include <memory>

#include "penumbra/export.h"
#include "penumbra/node_set.h"

namespace penumbra PENUMBRA_API {

// Every node type of nodes/*/*.json. A host adds its own with NodeSet::add.
NodeSet shadow_nodes();

// One and the same for the whole program, so that node sets made apart fit together.
std::shared_ptr<const Domain> shadow_domain();

}  // namespace penumbra
