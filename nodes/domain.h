// SPDX-License-Identifier: MIT
// What penumbra's node types speak of: a scene and its sun.
#pragma once

#include <memory>

#include "graph/domain.h"

namespace penumbra {

// One and the same for the whole program, so that node sets made apart fit together.
std::shared_ptr<const Domain> shadow_domain();

}  // namespace penumbra
