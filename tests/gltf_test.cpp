// SPDX-License-Identifier: MIT
// The glTF reader: the same triangles however a file stores them, double precision down the tree, and a
// diagnostic for whatever is wrong. Files are made here; nothing is read from outside.
#include "host/models/gltf.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <glm/gtc/matrix_transform.hpp>
#include <iterator>
#include <limits>
#include <random>
#include <span>

#include "host/generated/colonnade.h"
#include "host/images/image_file.h"
#include "host/models/glb_writer.h"
#include "host/scene/scene_file.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

std::string base64(std::span<const std::byte> bytes) {
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

const std::vector<float> zigzag{0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 2, 0, 0};

class Gltf : public ::testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::path(::testing::TempDir()) /
                  (std::string("gltf_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

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

    fs::path folder_;
    Diagnostics diagnostics_;
};

// A file with one mesh of one primitive; `accessors` from 0 on, `primitive` its body.
std::string one_primitive(const Buffer& buffer, const std::string& views, const std::string& accessors,
                          const std::string& primitive, const std::string& more = "") {
    return R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{)" +
           primitive + R"(}]}],"buffers":[{"byteLength":)" + std::to_string(buffer.bytes.size()) +
           R"(,"uri":")" + buffer.uri() + R"("}],"bufferViews":[)" + views + R"(],"accessors":[)" +
           accessors + "]" + more + "}";
}

std::string view(size_t offset, size_t length) {
    return R"({"buffer":0,"byteOffset":)" + std::to_string(offset) + R"(,"byteLength":)" +
           std::to_string(length) + "}";
}

std::string positions_file(int mode, const std::string& more = "") {
    Buffer buffer;
    buffer.add(zigzag);
    return one_primitive(buffer, view(0, 60),
                         R"({"bufferView":0,"componentType":5126,"count":5,"type":"VEC3"})",
                         R"("mode":)" + std::to_string(mode) + R"(,"attributes":{"POSITION":0})", more);
}

std::vector<Triangle> triangles_of(std::optional<Model> model) {
    if (!model) return {};
    Shot shot;
    return Scene(std::move(*model), shot).triangles(0);
}

glm::dvec3 normal_of(const Triangle& t) {
    const auto corner = [&](int i) { return glm::dvec3(t.v[i][0], t.v[i][1], t.v[i][2]); };
    return glm::cross(corner(1) - corner(0), corner(2) - corner(0));
}

double area_of(const std::vector<Triangle>& triangles) {
    double area = 0;
    for (const Triangle& t : triangles) area += 0.5 * glm::length(normal_of(t));
    return area;
}

TEST_F(Gltf, StripKeepsItsWinding) {
    const auto triangles = triangles_of(load(positions_file(5)));
    ASSERT_EQ(triangles.size(), 3u) << diagnostics_.text();
    for (const Triangle& t : triangles) EXPECT_LT(normal_of(t).z, 0);  // all of them turn the same way
    EXPECT_DOUBLE_EQ(area_of(triangles), 1.5);
}

TEST_F(Gltf, FanAndListAndIndexedAgreeOnTriangles) {
    EXPECT_EQ(triangles_of(load(positions_file(6))).size(), 3u);
    EXPECT_EQ(triangles_of(load(positions_file(4))).size(), 1u);  // the last two points make no triangle

    for (const int type : {5121, 5123, 5125}) {
        Buffer buffer;
        buffer.add(zigzag);
        const std::vector<uint32_t> corners{0, 1, 2, 2, 1, 3, 2, 3, 4};
        size_t offset = 0;
        if (type == 5121) offset = buffer.add(std::vector<uint8_t>(corners.begin(), corners.end()));
        if (type == 5123) offset = buffer.add(std::vector<uint16_t>(corners.begin(), corners.end()));
        if (type == 5125) offset = buffer.add(corners);
        const size_t bytes = buffer.bytes.size() - offset;
        const auto triangles = triangles_of(load(one_primitive(
            buffer, view(0, 60) + "," + view(offset, bytes),
            R"({"bufferView":0,"componentType":5126,"count":5,"type":"VEC3"},{"bufferView":1,"componentType":)" +
                std::to_string(type) + R"(,"count":9,"type":"SCALAR"})",
            R"("attributes":{"POSITION":0},"indices":1)")));
        ASSERT_EQ(triangles.size(), 3u) << diagnostics_.text();
        EXPECT_DOUBLE_EQ(area_of(triangles), 1.5);
    }
}

TEST_F(Gltf, SparseOverridesPositions) {
    Buffer buffer;
    buffer.add(zigzag);
    const size_t where = buffer.add(std::vector<uint16_t>{4});
    const size_t values = buffer.add(std::vector<float>{3, 0, 0});
    const auto file = [&](int index) {
        Buffer changed = buffer;
        changed.bytes[where] = std::byte(index);
        return one_primitive(
            changed, view(0, 60) + "," + view(where, 2) + "," + view(values, 12),
            R"({"bufferView":0,"componentType":5126,"count":5,"type":"VEC3","sparse":{"count":1,"indices":{"bufferView":1,"byteOffset":0,"componentType":5123},"values":{"bufferView":2,"byteOffset":0}}})",
            R"("mode":5,"attributes":{"POSITION":0})");
    };
    EXPECT_DOUBLE_EQ(area_of(triangles_of(load(file(4)))), 2.0) << diagnostics_.text();
    expect_error(file(5), "sparse index 5 is out of range");
}

TEST_F(Gltf, BadTrianglesAreDroppedAndCounted) {
    const float nan = std::numeric_limits<float>::quiet_NaN(),
                infinite = std::numeric_limits<float>::infinity();
    std::vector<float> points = zigzag;
    points.insert(points.end(), {nan, 0, 0, 0, infinite, 0, 1e38f, 0, 0, 0.5f, 0, 0});
    Buffer buffer;
    buffer.add(points);
    const size_t offset =
        buffer.add(std::vector<uint16_t>{0, 1, 2, 0, 1, 5, 0, 6, 1, 7, 0, 1, 0, 0, 1, 0, 2, 8});
    const auto model = load(one_primitive(
        buffer, view(0, 108) + "," + view(offset, 36),
        R"({"bufferView":0,"componentType":5126,"count":9,"type":"VEC3"},{"bufferView":1,"componentType":5123,"count":18,"type":"SCALAR"})",
        R"("attributes":{"POSITION":0},"indices":1)"));
    ASSERT_TRUE(model) << diagnostics_.text();
    EXPECT_EQ(model->dropped_nonfinite, 3u);
    EXPECT_EQ(model->dropped_degenerate, 2u);
    EXPECT_EQ(model->triangle_count(), 1u);
    EXPECT_EQ(model->warnings.size(), 2u);
    const auto triangles = triangles_of(model);
    ASSERT_EQ(triangles.size(), 1u);
    for (const auto& corner : triangles[0].v)
        for (const float x : corner) EXPECT_TRUE(std::isfinite(x));
}

TEST_F(Gltf, IndexOutOfRangeIsAnError) {
    Buffer buffer;
    buffer.add(zigzag);
    const size_t offset = buffer.add(std::vector<uint16_t>{0, 1, 5});
    expect_error(
        one_primitive(
            buffer, view(0, 60) + "," + view(offset, 6),
            R"({"bufferView":0,"componentType":5126,"count":5,"type":"VEC3"},{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"})",
            R"("attributes":{"POSITION":0},"indices":1)"),
        "index 5 is out of range");
}

TEST_F(Gltf, AccessorsMayNotLeaveTheirBuffer) {
    Buffer buffer;
    buffer.add(zigzag);
    const auto file = [&](const std::string& buffer_view, const std::string& count) {
        return one_primitive(
            buffer, buffer_view,
            R"({"bufferView":0,"componentType":5126,"count":)" + count + R"(,"type":"VEC3"})",
            R"("attributes":{"POSITION":0})");
    };
    EXPECT_TRUE(load(file(view(0, 60), "5"))) << diagnostics_.text();
    expect_error(file(view(0, 60), "6"), "past the end");
    expect_error(file(view(8, 60), "5"), "past the end");
    expect_error(file(view(0, 4294967295), "5"), "past the end");
    expect_error(file(view(0, 60), "357913943"), "past the end");  // * 12 wraps to 20 in 32 bits
    EXPECT_FALSE(load(file(R"({"buffer":3,"byteLength":60})", "5")));
    EXPECT_FALSE(load(file(view(0, 60), "-1")));
}

TEST_F(Gltf, NodesMustFormTrees) {
    const auto file = [&](const std::string& nodes) {
        return R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[)" + nodes + "]}";
    };
    expect_error(file(R"({"children":[1]},{"children":[0]})"), "reached twice");
    expect_error(file(R"({"children":[1,1]},{})"), "reached twice");
    expect_error(file(R"({"children":[7]})"), "node 7 does not exist");
    expect_error(file(R"({"mesh":2})"), "mesh 2 does not exist");
    expect_error(file(R"({"rotation":[0,0,0,0]})"), "zero rotation");

    std::string chain;  // a recursive reader would run out of stack
    for (int i = 1; i < 100000; ++i) {
        chain.append(R"({"children":[)").append(std::to_string(i)).append("]},");
    }
    const auto deep = load(file(chain + "{}"));
    ASSERT_TRUE(deep) << diagnostics_.text();
    EXPECT_EQ(deep->nodes.size(), 100000u);
}

TEST_F(Gltf, UnsupportedGeometryIsAnError) {
    expect_error(
        positions_file(
            4, R"(,"extensionsUsed":["KHR_mesh_of_tomorrow"],"extensionsRequired":["KHR_mesh_of_tomorrow"])"),
        "KHR_mesh_of_tomorrow");
    EXPECT_TRUE(load(positions_file(4, R"(,"extensionsRequired":["KHR_materials_unlit"])")));
}

TEST_F(Gltf, BadImageKeepsTheModel) {
    const std::string materials =
        R"(,"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,1,1],"baseColorTexture":{"index":0}}}],"textures":[{"source":0}])";
    for (const std::string uri : {"missing.png", "data:image/png;base64,bm90IGFuIGltYWdl",
                                  "data:image/webp;base64,bm90IGFuIGltYWdl"}) {
        const auto model =
            load(positions_file(5, fmt::format(R"({},"images":[{{"uri":"{}"}}])", materials, uri)));
        ASSERT_TRUE(model) << uri << diagnostics_.text();
        EXPECT_EQ(model->triangle_count(), 3u);
        EXPECT_EQ(model->materials[0].texture, -1);
        EXPECT_EQ(model->materials[0].base_color[1], 0.25f);
        EXPECT_TRUE(model->warnings.back().starts_with("image 0 cannot be read (")) << model->warnings.back();
    }
    // A good one is used.
    write_png_color(folder_ / "good.png", 2, 1, std::vector<float>{1, 0, 0, 0, 1, 0});
    const auto model = load(positions_file(5, materials + R"(,"images":[{"uri":"good.png"}])"));
    ASSERT_TRUE(model) << diagnostics_.text();
    EXPECT_EQ(model->materials[0].texture, 0);
    EXPECT_EQ(model->textures[0].rgba, (std::vector<uint8_t>{255, 0, 0, 255, 0, 255, 0, 255}));
    EXPECT_TRUE(model->warnings.empty());
}

// The parser hands over a pointer into a buffer that it has not looked at: what it points to must not be
// read.
TEST_F(Gltf, ImagesMayNotLeaveTheirBuffer) {
    const auto file = [&](const std::string& buffer_view, int view_index = 1) {
        Buffer buffer;
        buffer.add(zigzag);
        return one_primitive(
            buffer, view(0, 60) + "," + buffer_view,
            R"({"bufferView":0,"componentType":5126,"count":5,"type":"VEC3"})",
            R"("mode":5,"attributes":{"POSITION":0})",
            R"(,"images":[{"mimeType":"image/png","bufferView":)" + std::to_string(view_index) + "}]");
    };
    EXPECT_TRUE(load(file(view(0, 60)))) << diagnostics_.text();
    expect_error(file(view(2000000000, 8)), "image 0: buffer view 1 reaches past the end of its buffer");
    expect_error(file(view(0, 2000000000)), "image 0: buffer view 1 reaches past the end of its buffer");
    expect_error(file(view(18446744073709551615ull, 1)), "reaches past the end of its buffer");
    expect_error(file(R"({"buffer":3,"byteLength":60})"), "buffer");
    expect_error(file(view(0, 60), 7), "bufferView");
}

TEST_F(Gltf, ImagesInBuffersAreRead) {
    Model model = make_colonnade();
    model.materials = {{.texture = 0}};
    model.textures = {{2, 1, {255, 0, 0, 255, 0, 255, 0, 128}}};
    for (Mesh& mesh : model.meshes)
        for (Part& part : mesh.parts) part.material = 0;
    write_file(folder_ / "a.glb", to_glb(model));
    const auto back = load_gltf(folder_ / "a.glb", diagnostics_);
    ASSERT_TRUE(back) << diagnostics_.text();
    EXPECT_EQ(back->materials[0].texture, 0);
    EXPECT_EQ(back->textures[0].rgba, model.textures[0].rgba);
}

// A few bytes that stand for gigabytes are refused before any of them is allocated; what they may stand for
// grows with the file.
TEST_F(Gltf, AFileMayNotStandForAThousandTimesItself) {
    const auto zeros = [&](const std::string& count, int primitives) {
        Buffer buffer;
        const size_t where = buffer.add(std::vector<uint16_t>{4});
        const size_t values = buffer.add(std::vector<float>{3, 0, 0});
        const std::string one = R"("attributes":{"POSITION":0})";
        std::string all = one;
        for (int i = 1; i < primitives; ++i) all += "},{" + one;
        return one_primitive(
            buffer, view(where, 2) + "," + view(values, 12),
            R"({"componentType":5126,"type":"VEC3","sparse":{"count":1,"indices":{"bufferView":0,"byteOffset":0,"componentType":5123},"values":{"bufferView":1,"byteOffset":0}},"count":)" +
                count + "}",
            all);
    };
    EXPECT_TRUE(load(zeros("1000", 20))) << diagnostics_.text();
    expect_error(zeros("67108864", 1), "a thousand times what");
    expect_error(zeros("40000", 500), "a thousand times what");
    ::setenv("PENUMBRA_INPUT_LIMIT_MIB", "1", 1);
    expect_error(zeros("40000", 2),
                 "more than 1 MiB, the limit for one file (PENUMBRA_INPUT_LIMIT_MIB raises it)");
    ::unsetenv("PENUMBRA_INPUT_LIMIT_MIB");
}

// Exporters let many primitives share one list of vertices: each takes those of its own.
TEST_F(Gltf, SharedVerticesAreNotRepeated) {
    Buffer buffer;
    std::vector<float> points;
    for (int i = 0; i < 3000; ++i)
        points.insert(points.end(),
                      {static_cast<float>(i / 3), static_cast<float>(i % 3), i % 3 == 2 ? 1.0f : 0.0f});
    buffer.add(points);
    std::vector<uint16_t> corners;
    for (uint16_t i = 0; i < 3000; ++i) corners.push_back(static_cast<uint16_t>(2999 - i));
    const size_t at = buffer.add(corners);
    std::string views = view(0, 36000), primitives,
                accessors = R"({"bufferView":0,"componentType":5126,"count":3000,"type":"VEC3"})";
    for (size_t i = 0; i < 1000; ++i) {
        views += "," + view(at + 6 * i, 6);
        accessors +=
            fmt::format(R"(,{{"bufferView":{},"componentType":5123,"count":3,"type":"SCALAR"}})", i + 1);
        primitives += fmt::format(R"({}"attributes":{{"POSITION":0}},"indices":{})", i ? "},{" : "", i + 1);
    }
    const auto model = load(one_primitive(buffer, views, accessors, primitives));
    ASSERT_TRUE(model) << diagnostics_.text();
    size_t vertices = 0;
    for (const Part& part : model->meshes[0].parts) vertices += part.positions.size();
    EXPECT_EQ(vertices, 3 * model->meshes[0].parts.size());
    const std::vector<uint32_t>& first = model->meshes[0].parts[0].indices;
    EXPECT_EQ(first, (std::vector<uint32_t>{2, 1, 0}));  // corners 2999, 2998, 2997
    EXPECT_EQ(model->meshes[0].parts[0].positions[0].y + model->meshes[0].parts[0].origin.y, 0);
}

// One mesh at very many nodes is very many meshes.
TEST_F(Gltf, InstancesAreCounted) {
    Buffer buffer;
    std::vector<float> strip;
    for (int i = 0; i < 1002; ++i)
        strip.insert(strip.end(), {static_cast<float>(i / 2), static_cast<float>(i % 2), 0});
    buffer.add(strip);
    std::string file = one_primitive(buffer, view(0, strip.size() * sizeof(float)),
                                     R"({"bufferView":0,"componentType":5126,"count":1002,"type":"VEC3"})",
                                     R"("mode":5,"attributes":{"POSITION":0})");
    const std::string root = R"("nodes":[0]}],"nodes":[{"mesh":0})";
    const size_t at = file.find(root);
    ASSERT_NE(at, std::string::npos);
    std::string roots = "0", nodes = R"({"mesh":0})";
    for (int i = 1; i < 100; ++i) {
        roots += "," + std::to_string(i);
        nodes += R"(,{"mesh":0})";
    }
    file.replace(at, root.size(), R"("nodes":[)" + roots + R"(]}],"nodes":[)" + nodes);
    Shot shot;
    shot.model = save("a.gltf", file);
    std::vector<std::string> warnings;
    EXPECT_TRUE(load_scene(shot, diagnostics_, warnings)) << diagnostics_.text();
    ::setenv("PENUMBRA_INPUT_LIMIT_MIB", "4", 1);
    EXPECT_FALSE(load_scene(shot, diagnostics_, warnings));
    ::unsetenv("PENUMBRA_INPUT_LIMIT_MIB");
    EXPECT_NE(diagnostics_.text().find("its nodes show 100000 triangles, which take more than 4 MiB"),
              std::string::npos)
        << diagnostics_.text();
}

// The parser walks what it does not know by recursion.
TEST_F(Gltf, DepthIsBounded) {
    const auto file = [](size_t depth) {
        return R"({"asset":{"version":"2.0","extras":)" + std::string(depth, '[') + std::string(depth, ']') +
               "}}";
    };
    EXPECT_TRUE(load(file(200))) << diagnostics_.text();
    expect_error(file(1'000'000), "nested more than 256 levels deep");
}

// A model names files; devices and pipes, which never end, are none.
TEST_F(Gltf, OnlyRegularFilesAreRead) {
    ASSERT_EQ(::mkfifo((folder_ / "pipe.bin").c_str(), 0600), 0);
    std::string file = positions_file(5);
    const size_t from = file.find("data:"), to = file.find('"', from);
    file.replace(from, to - from, "pipe.bin");
    expect_error(file, "not a valid glTF");
}

TEST_F(Gltf, MissingAndCorruptFilesAreDiagnostics) {
    EXPECT_FALSE(load_gltf(folder_ / "missing.glb", diagnostics_));
    EXPECT_FALSE(load_gltf(folder_, diagnostics_));
    EXPECT_EQ(diagnostics_.size(), 2u);
    expect_error("{", "not a valid glTF");
    expect_error("", "not a valid glTF");
    const auto empty = load(R"({"asset":{"version":"2.0"},"meshes":7})");
    ASSERT_TRUE(empty);
    EXPECT_EQ(empty->warnings, std::vector<std::string>{"there are no triangles"});
}

Model small_model() {
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

// Truncated at every length and with bytes changed at random, a .glb loads or is a diagnostic, never a crash.
TEST_F(Gltf, SurvivesDamage) {
    const std::vector<std::byte> good = to_glb(small_model());
    const auto survive = [&](const std::vector<std::byte>& bytes) {
        save("a.glb", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
        Diagnostics diagnostics;
        const auto model = load_gltf(folder_ / "a.glb", diagnostics);
        EXPECT_EQ(model.has_value(), diagnostics.empty());
        if (model) triangles_of(model);
        return model.has_value();
    };
    EXPECT_TRUE(survive(good));
    for (size_t length = 0; length < good.size(); length += 3) {
        EXPECT_FALSE(survive({good.begin(), good.begin() + static_cast<ptrdiff_t>(length)})) << length;
    }
    std::mt19937 random(7);
    for (int i = 0; i < 2000; ++i) {
        std::vector<std::byte> damaged = good;
        for (int k = 0; k < 3; ++k) damaged[random() % damaged.size()] = std::byte(random() & 255);
        survive(damaged);
    }
}

// Large offsets that cancel down the tree leave no trace: fp32 matrices would lose the millimetre.
TEST_F(Gltf, HierarchyIsDoublePrecision) {
    write_file(folder_ / "a.glb", to_glb(small_model()));
    const auto model = load_gltf(folder_ / "a.glb", diagnostics_);
    ASSERT_TRUE(model) << diagnostics_.text();
    EXPECT_EQ(model->materials[0].base_color[1], 0.25f);
    const Scene scene(*model, Shot{});
    EXPECT_NEAR(scene.bounds()[0].z, 1e-3, 1e-9);
    EXPECT_NEAR(scene.bounds()[1].x, 4, 1e-9);
    EXPECT_DOUBLE_EQ(area_of(scene.triangles(0)), 6.0);
}

// Vertices far from the origin are moved there without losing a bit.
TEST(Model, FarVerticesKeepTheirDifferences) {
    Model model;
    Mesh mesh;
    const float far = 1e6f;
    const std::vector<glm::vec3> positions{{far, 0, 0}, {far + 0.0625f, 0, 0}, {far, 0.001f, 0}};
    add_part(model, mesh, positions, {}, {0, 1, 2}, -1);
    ASSERT_EQ(mesh.parts.size(), 1u);
    const Part& part = mesh.parts[0];
    for (size_t i = 0; i < 3; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_EQ(part.origin[axis] + double(part.positions[i][axis]), double(positions[i][axis]));
        }
    }
    EXPECT_LT(std::abs(part.positions[0].x), 1);
}

TEST(Scene, MovesWhatTheShotMoves) {
    Shot shot;
    shot.objects["arm"].keys = {{.frame = 0},
                                {.frame = 10, .translation = {1, 0, 0}, .rotation_deg = {0, 90, 0}}};
    const Scene scene(small_model(), shot);
    EXPECT_FALSE(scene.moved(3, 3));
    EXPECT_TRUE(scene.moved(3, 4));
    EXPECT_FALSE(scene.moved(10, 11));
    // local = T(translation + moved) * R * S: at frame 10 the scaled point (2, 0, 0) has turned to -z and
    // moved by 1.
    const glm::dvec4 p = scene.transforms(10)[1] * glm::dvec4(1, 0, 0, 1);
    EXPECT_NEAR(p.x, 1, 1e-9);
    EXPECT_NEAR(p.z, 1e-3 - 2, 1e-9);
    EXPECT_EQ(scene.triangles(0).size(), scene.triangles(10).size());
    EXPECT_EQ(scene.triangle_objects(), (std::vector<uint32_t>{0, 0, 0}));
}

TEST(Scene, FlattenedNodesShowNothing) {
    Model model = small_model();
    model.nodes[1].scale = {1, 0, 1};
    const Scene scene(std::move(model), Shot{});
    EXPECT_EQ(scene.dropped_instances(), 1);
    EXPECT_TRUE(scene.triangles(0).empty());
}

TEST(Colonnade, IsTheSameEachTimeAndHasItsGate) {
    const Model model = make_colonnade();
    EXPECT_EQ(to_glb(model), to_glb(make_colonnade()));
    EXPECT_EQ(std::ranges::count(model.nodes, "gate", &Node::name), 1);
    const Scene scene(model, Shot{});
    EXPECT_GT(scene.triangles(0).size(), 100000u);
    EXPECT_LT(scene.triangles(0).size(), 250000u);
    for (const Mesh& mesh : model.meshes)
        for (const Part& part : mesh.parts) {
            Model copy;
            Mesh out;
            add_part(copy, out, part.positions, {}, part.indices, 0);
            EXPECT_EQ(copy.dropped_degenerate, 0u);
            EXPECT_EQ(copy.dropped_nonfinite, 0u);
        }
}

}  // namespace
}  // namespace penumbra
