// SPDX-License-Identifier: MIT
// GLSL to SPIR-V with glslang, validated and optimised with SPIRV-Tools. The build uses it to embed the node
// set.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "graph/node_type.h"

namespace penumbra {

struct ShaderSource {
    std::filesystem::path file;                       // the .comp file
    std::string node_glsl;                            // what `#include "node.glsl"` stands for
    std::vector<std::filesystem::path> include_dirs;  // for every other #include
};

struct CompiledShader {
    std::vector<uint32_t> spirv;                      // SPIR-V 1.5, Vulkan 1.2 environment
    std::vector<std::filesystem::path> dependencies;  // files that were included
};

// Errors carry the GLSL file and line that glslang names.
std::optional<CompiledShader> compile_shader(const ShaderSource& source, Diagnostics& diagnostics);

}  // namespace penumbra
