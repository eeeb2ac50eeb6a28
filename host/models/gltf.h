// SPDX-License-Identifier: MIT
// glTF 2.0 (.gltf and .glb) to a Model. Whatever is wrong with the file is a diagnostic or a warning, never a
// crash: every index and every range of bytes is checked before it is used.
#pragma once

#include <filesystem>
#include <optional>

#include "host/models/model.h"
#include "penumbra/diagnostic.h"

namespace penumbra {

// Reads the default scene's nodes. Triangles, strips and fans; indexed or not; sparse accessors; normalised
// integers; alphaMode MASK. Ignored with a warning: points and lines, skins, morph targets, animations,
// vertex colours, unreadable images; alphaMode BLEND is read as OPAQUE. An error: files that break the
// format, and required extensions that change the geometry (Draco, meshopt, ...).
std::optional<Model> load_gltf(const std::filesystem::path& path, Diagnostics& diagnostics);

}  // namespace penumbra
