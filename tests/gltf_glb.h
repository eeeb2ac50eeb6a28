// SPDX-License-Identifier: MIT
// A .glb that a test fills, and the square that most begin with.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host/models/gltf.h"
#include "tests/test_folder.h"

namespace penumbra {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// A .glb with its one buffer, filled as accessors and views are added.
struct Glb {
    Json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {0}}}}}};
    std::string bytes;

    int view(const void* data, size_t size) {
        bytes.resize((bytes.size() + 3) / 4 * 4);
        json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", size}});
        bytes.append(static_cast<const char*>(data), size);
        return static_cast<int>(json["bufferViews"].size()) - 1;
    }
    int accessor(int view, int component, size_t count, const char* type) {
        Json accessor = {{"componentType", component}, {"count", count}, {"type", type}};
        if (view >= 0) accessor["bufferView"] = view;
        json["accessors"].push_back(accessor);
        return static_cast<int>(json["accessors"].size()) - 1;
    }
    int floats(const std::vector<float>& values, const char* type, size_t width) {
        return accessor(view(values.data(), values.size() * 4), 5126, values.size() / width, type);
    }
    // Gone when the process ends.
    fs::path save(const std::string& name) {
        bytes.resize((bytes.size() + 3) / 4 * 4);
        if (!json.contains("buffers")) json["buffers"] = Json::array({Json::object()});
        json["buffers"][0]["byteLength"] = bytes.size();
        std::string text = json.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        const auto word = [](size_t value) {
            const auto v = static_cast<uint32_t>(value);
            return std::string(reinterpret_cast<const char*>(&v), 4);
        };
        static const test::TestFolder folder;
        const fs::path file = folder / name;
        std::ofstream(file, std::ios::binary)
            << "glTF" << word(2) << word(28 + text.size() + bytes.size()) << word(text.size()) << "JSON"
            << text << word(bytes.size()) << std::string("BIN\0", 4) << bytes;
        return file;
    }
};

inline Model loaded(Glb& glb, const char* name) {
    Diagnostics diagnostics;
    auto model = load_gltf(glb.save(name), diagnostics);
    EXPECT_TRUE(model) << diagnostics.text();
    return model ? std::move(*model) : Model{};
}

inline const std::vector<float> square{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
inline const std::vector<uint32_t> square_indices{0, 1, 2, 0, 2, 3};

inline Glb square_file() {
    Glb glb;
    glb.json["nodes"] = {{{"mesh", 0}}};
    const int position = glb.floats(square, "VEC3", 3);
    const int indices = glb.accessor(glb.view(square_indices.data(), 24), 5125, 6, "SCALAR");
    glb.json["meshes"] = {
        {{"primitives", {{{"attributes", {{"POSITION", position}}}, {"indices", indices}}}}}};
    return glb;
}
inline Json& primitive(Glb& glb) {
    return glb.json["meshes"][0]["primitives"][0];
}

}  // namespace penumbra
