// SPDX-License-Identifier: MIT
// Penumbra's own node types, with their shaders and tables.
#pragma once

#include "graph/node_set.h"

namespace penumbra {

// Every node type of nodes/*/*.json. A host adds its own with NodeSet::add.
NodeSet shadow_nodes();

}  // namespace penumbra
