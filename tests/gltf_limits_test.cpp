// SPDX-License-Identifier: MIT
// What a glTF file may not make the reader do, however it is broken: read beside a buffer, take memory that
// the file does not stand for, recurse without end, wait for a device, crash.
#include <fmt/format.h>
#include <sys/stat.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <limits>
#include <numeric>
#include <random>

#include "host/images/image_file.h"
#include "host/models/glb_writer.h"
#include "host/scene/scene_file.h"
#include "tests/gltf_files.h"
#include "tests/gltf_glb.h"

namespace penumbra {
namespace {

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
    const auto positions_of_nothing = [&](const std::string& count) {
        Buffer buffer;
        buffer.add(zigzag);
        return one_primitive(buffer, view(0, 60),
                             R"({"componentType":5126,"type":"VEC3","count":)" + count + "}",
                             R"("attributes":{"POSITION":0})");
    };
    EXPECT_TRUE(load(zeros("1000", 20))) << diagnostics_.text();
    EXPECT_TRUE(load(positions_of_nothing("1000"))) << diagnostics_.text();
    expect_error(zeros("67108864", 1), "a thousand times what");
    expect_error(zeros("40000", 500), "a thousand times what");
    expect_error(positions_of_nothing("67108864"), "a thousand times what");
    ::setenv("PENUMBRA_INPUT_LIMIT_MIB", "1", 1);
    expect_error(zeros("40000", 2),
                 "more than 1 MiB, the limit for one file (PENUMBRA_INPUT_LIMIT_MIB raises it)");
    ::unsetenv("PENUMBRA_INPUT_LIMIT_MIB");
}

// What many nodes or channels share is in the file once, and in memory once for each of them.
TEST_F(Gltf, WhatIsSharedCountsForEachThatHasIt) {
    const auto zeros = [](Glb& glb, size_t count) {  // of a few bytes
        const uint16_t where = 0;
        const std::array<float, 3> value{};
        const int indices = glb.view(&where, 2), values = glb.view(value.data(), 12),
                  accessor = glb.accessor(-1, 5126, count, "VEC3");
        glb.json["accessors"][static_cast<size_t>(accessor)]["sparse"] = {
            {"count", 1},
            {"indices", {{"bufferView", indices}, {"byteOffset", 0}, {"componentType", 5123}}},
            {"values", {{"bufferView", values}, {"byteOffset", 0}}}};
        return accessor;
    };
    const auto show = [](Glb& glb, size_t nodes) {
        glb.json["nodes"] = Json(nodes, Json(glb.json["nodes"][0]));
        std::vector<size_t> roots(nodes);
        std::iota(roots.begin(), roots.end(), size_t{0});
        glb.json["scenes"][0]["nodes"] = roots;
    };
    const auto instances = [&](size_t nodes) {
        Glb glb = square_file();
        glb.json["nodes"][0]["extensions"] = {
            {"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", zeros(glb, 2000)}}}}}};
        show(glb, nodes);
        return glb;
    };
    const auto posed = [&](size_t count) {  // an animation would give each a weight for every target
        Glb glb = square_file();
        primitive(glb)["targets"] = Json(2000, Json{{"POSITION", zeros(glb, 4)}});
        glb.json["nodes"][0]["extensions"] = {
            {"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", zeros(glb, count)}}}}}};
        return glb;
    };
    const auto weights = [&](size_t nodes) {
        Glb glb = square_file();
        glb.json["meshes"][0]["weights"] = std::vector<int>(20'000);
        show(glb, nodes);
        return glb;
    };
    const auto channels = [&](size_t count) {
        Glb glb = square_file();
        std::vector<uint16_t> times(20'000);
        std::iota(times.begin(), times.end(), uint16_t{0});
        const int input = glb.accessor(glb.view(times.data(), 40'000), 5123, 20'000, "SCALAR");
        const Json channel = {{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}};
        glb.json["animations"] = {{{"samplers", {{{"input", input}, {"output", zeros(glb, 20'000)}}}},
                                   {"channels", Json(count, channel)}}};
        return glb;
    };
    const auto text = [&](Glb glb) {
        Diagnostics diagnostics;
        const auto model = load_gltf(glb.save("shared.glb"), diagnostics);
        EXPECT_EQ(model.has_value(), diagnostics.empty());
        return diagnostics.text();
    };
    EXPECT_EQ(text(instances(1)), "");
    EXPECT_EQ(text(posed(1)), "");
    EXPECT_EQ(text(weights(1)), "");
    EXPECT_EQ(text(channels(1)), "");
    for (const Glb& many : {instances(20), posed(10'000), weights(600), channels(300)})
        EXPECT_NE(text(many).find("a thousand times what"), std::string::npos);
}

// A text is not gone through again for each that names it, nor taken apart as a path that it cannot be.
TEST_F(Gltf, LongNamesOfImagesAreNotReadForEachMaterial) {
    std::string folders;
    for (int i = 0; i < 500'000; ++i) folders += "a/";
    write_png_color(folder_ / "good.png", 1, 1, std::vector<float>{1, 0, 0});
    Json materials, material = {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}};
    for (int i = 0; i < 4000; ++i) materials.push_back(material);
    const std::string file =
        positions_file(5, R"(,"textures":[{"source":0}],"materials":)" + materials.dump() +
                              R"(,"images":[{"uri":")" + folders + R"(good.png"}])");
    const auto model = load(file);
    ASSERT_TRUE(model) << diagnostics_.text();
    EXPECT_EQ(model->warnings, std::vector<std::string>{"image \"" + folders.substr(0, 77) +
                                                        "...\" is not there: the colour factor is used"});
}

// A wide texture and a high one of few texels make a map of many.
TEST_F(Gltf, AMapOfWhatIsLetThroughIsNoLargerThanAFile) {
    write_png_color(folder_ / "wide.png", 600, 1, std::vector<float>(1800, 1));
    write_png_color(folder_ / "high.png", 1, 600, std::vector<float>(1800, 1));
    const std::string pane = positions_file(
        5,
        R"(,"images":[{"uri":"wide.png"},{"uri":"high.png"}],"textures":[{"source":0},{"source":1}],"materials":[{"name":"pane","pbrMetallicRoughness":{"metallicFactor":0,"baseColorTexture":{"index":0}},"extensions":{"KHR_materials_transmission":{"transmissionFactor":1,"transmissionTexture":{"index":1}}}}])");
    EXPECT_TRUE(load(pane)) << diagnostics_.text();
    ::setenv("PENUMBRA_INPUT_LIMIT_MIB", "2", 1);  // each of two, but not both
    EXPECT_TRUE(load(pane)) << diagnostics_.text();
    std::string panes = pane;
    const std::string turned =
        R"({"name":"turned","pbrMetallicRoughness":{"metallicFactor":0,"baseColorTexture":{"index":1}},"extensions":{"KHR_materials_transmission":{"transmissionFactor":1,"transmissionTexture":{"index":0}}}},)";
    panes.insert(panes.find(R"({"name":"pane")"), turned);
    expect_error(panes, "material \"pane\": what its textures let through takes more than 2 MiB");
    ::setenv("PENUMBRA_INPUT_LIMIT_MIB", "1", 1);
    expect_error(pane, "material \"pane\": what its textures let through takes more than 1 MiB");
    ::unsetenv("PENUMBRA_INPUT_LIMIT_MIB");
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
    expect_error(R"({"asset":{"version":"2.0"},"meshes":7})", "meshes: expected a list");
    const auto empty = load(R"({"asset":{"version":"2.0"},"meshes":[]})");
    ASSERT_TRUE(empty);
    EXPECT_EQ(empty->warnings, std::vector<std::string>{"there are no triangles"});
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

}  // namespace
}  // namespace penumbra
