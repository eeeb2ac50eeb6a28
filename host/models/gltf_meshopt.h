// SPDX-License-Identifier: MIT
// EXT_meshopt_compression: buffer views whose bytes are to be decoded from another buffer.
#pragma once

#include <tiny_gltf.h>

#include "host/models/gltf_accessor.h"

namespace penumbra {

// Replaces every compressed view by its decoded bytes. GltfError.
void decode_meshopt(tinygltf::Model& file, ReadBudget& budget);

}  // namespace penumbra
