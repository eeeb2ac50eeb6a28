// SPDX-License-Identifier: MIT
// Models that a test makes, as files that sessions read.
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <span>

#include "host/images/image_file.h"
#include "host/models/shapes.h"

namespace penumbra::test {

// A file that is gone when the test ends.
class SceneFile {
  public:
    SceneFile(const char* name, std::span<const std::byte> bytes)
        : path_(std::filesystem::temp_directory_path() / fmt::format("penumbra_made_{}_{}", getpid(), name)) {
        write_file(path_, bytes);
    }
    SceneFile(const SceneFile&) = delete;
    SceneFile& operator=(const SceneFile&) = delete;
    ~SceneFile() {
        std::error_code ignored;
        std::filesystem::remove(path_, ignored);
    }
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

// A node of its own for a shape.
inline void add(Model& model, const char* name, Shape shape, int material) {
    model.meshes.emplace_back().parts.push_back(to_part(std::move(shape), material));
    Node& node = model.nodes.emplace_back();
    node.name = name;
    node.mesh = static_cast<int>(model.meshes.size()) - 1;
}

}  // namespace penumbra::test
