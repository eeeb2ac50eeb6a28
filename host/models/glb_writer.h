// SPDX-License-Identifier: MIT
// A Model as a binary glTF: for the scenes that the project makes itself, and for tests of the reader.
#pragma once

#include <cstddef>
#include <vector>

#include "host/models/model.h"

namespace penumbra {

// Positions, texture coordinates, indices, materials, textures (as PNG), nodes. The same model always gives
// the same bytes.
std::vector<std::byte> to_glb(const Model& model);

}  // namespace penumbra
