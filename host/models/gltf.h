// SPDX-License-Identifier: MIT
// glTF 2.0 (.gltf and .glb) to a Model. Whatever is wrong with the file is a diagnostic or a warning, never a
// crash: every index and every range of bytes is checked before it is used.
#pragma once

#include <filesystem>
#include <optional>

#include "host/models/model.h"
#include "penumbra/diagnostic.h"

namespace penumbra {

// Reads the default scene's nodes: triangles, strips and fans, indexed or not, with sparse accessors and
// normalised integers; skins, morph targets, animations; base colours with their textures, transforms and
// vertex colours; alphaMode MASK and BLEND; metalness, roughness, emission, transmission; perspective
// cameras, lights; KHR_mesh_quantization, KHR_texture_transform, KHR_lights_punctual,
// KHR_materials_emissive_strength, KHR_materials_transmission, KHR_draco_mesh_compression,
// EXT_meshopt_compression, EXT_mesh_gpu_instancing. What is shown otherwise than the file says is a warning,
// and the rest is read. An error: files that break the format or take more than input_limit(), and required
// extensions that nothing is known of.
std::optional<Model> load_gltf(const std::filesystem::path& path, Diagnostics& diagnostics);

}  // namespace penumbra
