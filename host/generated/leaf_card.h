// SPDX-License-Identifier: MIT
// A sprig of leaves as a picture with alpha, and the rectangle that carries it: foliage the way games draw
// it.
#pragma once

#include "host/models/shapes.h"

namespace penumbra {

// 128x128 texels; the stalk grows from the middle of the lower border upwards. Leaf-green everywhere, so that
// no border bleeds into the mip levels; alpha rises from 0 to 1 over two texels and is 0.5 on the outline.
Texture leaf_card_texture();
inline constexpr double leaf_card_cutoff = 0.5;

// Two triangles from `foot` along `along`, `side` to the right (unit, orthogonal).
void add_leaf_card(Shape& leaves, const glm::dvec3& foot, const glm::dvec3& along, const glm::dvec3& side,
                   double length);

}  // namespace penumbra
