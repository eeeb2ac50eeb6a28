// SPDX-License-Identifier: MIT
// Compiled shaders on disk. An entry holds everything that its SPIR-V came from (compiler, generated
// interface, shader, every included text) and is used only where all of that is the same byte for byte, its
// checksum is right and the SPIR-V is valid; else the shader is compiled again and the entry replaced. Its
// name is made of the shader's path, so that there is one entry per variant of a shader, whatever its
// history.
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>

#include "graph/shader_compiler.h"

namespace penumbra {

class ShaderCache {
  public:
    // Entries that had to be thrown away, and a folder that cannot be written: nothing is wrong with the
    // shader then.
    using Warn = std::function<void(const std::string&)>;

    // Nowhere for an empty path: every shader is compiled.
    explicit ShaderCache(std::filesystem::path folder, Warn warn = {});

    // compile_shader(), or what it gave before, but for the included texts. `variant` tells shaders apart
    // that share a file.
    std::optional<CompiledShader> compile(ShaderSource source, const std::string& variant,
                                          Diagnostics& diagnostics);

    struct Counts {
        uint32_t found = 0, compiled = 0, corrupt = 0;
    };
    Counts counts() const;

  private:
    std::filesystem::path entry_file(const ShaderSource& source, const std::string& variant) const;
    std::optional<CompiledShader> find(const std::filesystem::path& entry, const ShaderSource& source);
    void keep(const std::filesystem::path& entry, const ShaderSource& source, const CompiledShader& shader);
    void warn(const std::string& message);

    std::filesystem::path folder_;
    Warn warn_;
    std::string compiler_;
    mutable std::mutex mutex_;  // guards the members below and calls of warn_
    Counts counts_;
    bool unwritable_ = false;  // said once
};

}  // namespace penumbra
