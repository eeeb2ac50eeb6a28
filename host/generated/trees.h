// SPDX-License-Identifier: MIT
// A test scene of foliage: trees on hilly ground, every leaf a folded polygon of its own shape. Thousands of
// casters narrower than a shadow map's texel, at all heights, so that penumbrae overlap into dapples.
#pragma once

#include "host/models/model.h"

namespace penumbra {

// About 260 000 triangles; metres, 40 m square. Nothing moves; nodes "terrain", "tree_0" .. "tree_6".
Model make_trees();

// The same trees with every twig's leaves on alpha-tested cards (leaf_card.h), on a coarser ground: about 32
// 000 triangles.
Model make_cards();

}  // namespace penumbra
