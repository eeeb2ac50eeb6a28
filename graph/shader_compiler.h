// SPDX-License-Identifier: MIT
// GLSL to SPIR-V with glslang, validated and optimised with SPIRV-Tools. The build uses it to embed the node
// set, hosts to load a user's nodes (user_nodes.h).
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "graph/embedded_file.h"
#include "penumbra/diagnostic.h"

namespace penumbra {

struct ShaderSource {
    std::filesystem::path file;                       // the .comp file
    std::string node_glsl;                            // what `#include "node.glsl"` stands for
    std::vector<std::filesystem::path> include_dirs;  // for every other #include
    std::span<const EmbeddedFile> embedded = {};      // and for what no folder has (shared_glsl())
    std::optional<std::string> text = {};             // the file's content, where it has been read already
};

struct CompiledShader {
    std::vector<uint32_t> spirv;                      // SPIR-V 1.5, Vulkan 1.2 environment
    std::vector<std::filesystem::path> dependencies;  // files that were included (embedded ones are none)
    std::map<std::string, std::string>
        includes;  // what was included, as #include spells it, and the text it gave
};

// What `#include "name"` gives, and the name that errors in it carry (a path, or the name itself where
// embedded).
struct IncludedText {
    std::string name, text;
    bool embedded = false;
};
std::optional<IncludedText> resolve_include(const ShaderSource& source, const std::string& name);

// Errors carry the GLSL file and line that glslang names. Refused is also what uses a descriptor or push
// constants that node_glsl does not declare.
std::optional<CompiledShader> compile_shader(const ShaderSource& source, Diagnostics& diagnostics);

// Whether SPIRV-Tools find these words valid for compile_shader's environment.
bool is_valid_spirv(std::span<const uint32_t> words);

// Names the versions of glslang and SPIRV-Tools and of what this file makes of them: the same sources and the
// same text give the same SPIR-V.
std::string shader_compiler_version();

}  // namespace penumbra
