// SPDX-License-Identifier: MIT
// Models that a test makes, as files that sessions read.
#pragma once

#include <filesystem>
#include <span>

#include "host/images/image_file.h"
#include "host/models/shapes.h"
#include "tests/test_folder.h"

namespace penumbra::test {

// A file that is gone with the object.
class SceneFile {
  public:
    SceneFile(const std::string& name, std::span<const std::byte> bytes) : path_(folder_ / name) {
        write_file(path_, bytes);
    }
    const std::filesystem::path& path() const { return path_; }

  private:
    TestFolder folder_;
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
