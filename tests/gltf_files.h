// SPDX-License-Identifier: MIT
// Small glTF files, written by tests of the reader.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/models/gltf.h"
#include "host/scene/scene.h"
#include "tests/test_folder.h"

namespace penumbra {

namespace fs = std::filesystem;

inline std::string base64(std::span<const std::byte> bytes) {
    constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t group = 0;
        for (size_t k = 0; k < 3; ++k) {
            group = group << 8 | (i + k < bytes.size() ? std::to_integer<uint32_t>(bytes[i + k]) : 0);
        }
        for (size_t k = 0; k < 4; ++k)
            out += i + k <= bytes.size() ? digits[group >> (18 - 6 * k) & 63] : '=';
    }
    return out;
}

// Five points of a strip (or fan) in the plane z = 0, then the indices of the strip's triangles.
struct Buffer {
    std::vector<std::byte> bytes;
    template <class T>
    size_t add(const std::vector<T>& values) {
        bytes.resize((bytes.size() + 3) / 4 * 4);
        const size_t offset = bytes.size();
        const auto added = std::as_bytes(std::span(values));
        bytes.insert(bytes.end(), added.begin(), added.end());
        return offset;
    }
    std::string uri() const { return "data:application/octet-stream;base64," + base64(bytes); }
};

inline const std::vector<float> zigzag{0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 2, 0, 0};

class Gltf : public ::testing::Test {
  protected:
    fs::path save(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name, std::ios::binary) << text;
        return folder_ / name;
    }
    std::optional<Model> load(const std::string& text) {
        diagnostics_ = {};
        return load_gltf(save("a.gltf", text), diagnostics_);
    }
    // Loading fails, and the reason mentions `part`.
    void expect_error(const std::string& text, const std::string& part) {
        EXPECT_FALSE(load(text)) << part;
        EXPECT_NE(diagnostics_.text().find(part), std::string::npos) << diagnostics_.text();
    }

    test::TestFolder folder_;
    Diagnostics diagnostics_;
};

// A file with one mesh of one primitive; `accessors` from 0 on, `primitive` its body.
inline std::string one_primitive(const Buffer& buffer, const std::string& views, const std::string& accessors,
                                 const std::string& primitive, const std::string& more = "") {
    return R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{)" +
           primitive + R"(}]}],"buffers":[{"byteLength":)" + std::to_string(buffer.bytes.size()) +
           R"(,"uri":")" + buffer.uri() + R"("}],"bufferViews":[)" + views + R"(],"accessors":[)" +
           accessors + "]" + more + "}";
}

inline std::string view(size_t offset, size_t length) {
    return R"({"buffer":0,"byteOffset":)" + std::to_string(offset) + R"(,"byteLength":)" +
           std::to_string(length) + "}";
}

inline std::string positions_file(int mode, const std::string& more = "") {
    Buffer buffer;
    buffer.add(zigzag);
    return one_primitive(buffer, view(0, 60),
                         R"({"bufferView":0,"componentType":5126,"count":5,"type":"VEC3"})",
                         R"("mode":)" + std::to_string(mode) + R"(,"attributes":{"POSITION":0})", more);
}

inline std::vector<Triangle> triangles_of(std::optional<Model> model) {
    if (!model) return {};
    Shot shot;
    return Scene(std::move(*model), shot).triangles(0);
}

inline glm::dvec3 normal_of(const Triangle& t) {
    const auto corner = [&](int i) { return glm::dvec3(t.v[i][0], t.v[i][1], t.v[i][2]); };
    return glm::cross(corner(1) - corner(0), corner(2) - corner(0));
}

inline double area_of(const std::vector<Triangle>& triangles) {
    double area = 0;
    for (const Triangle& t : triangles) area += 0.5 * glm::length(normal_of(t));
    return area;
}

inline Model small_model() {
    Model model;
    Part part;
    for (size_t i = 0; i < zigzag.size(); i += 3)
        part.positions.emplace_back(zigzag[i], zigzag[i + 1], zigzag[i + 2]);
    part.indices = {0, 1, 2, 2, 1, 3, 2, 3, 4};
    part.material = 0;
    model.materials.push_back({{0.5f, 0.25f, 1, 1}});
    model.meshes.push_back({{part}});
    model.nodes = {
        Node{.name = "root", .translation = {1e6, 0, 0}},
        Node{.name = "arm", .parent = 0, .mesh = 0, .translation = {-1e6, 0, 1e-3}, .scale = {2, 2, 2}}};
    return model;
}

}  // namespace penumbra
