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
#include <span>

#include "host/generated/colonnade.h"
#include "host/images/image_file.h"
#include "host/models/glb_writer.h"
#include "host/scene/scene_file.h"
#include "tests/gltf_files.h"

namespace penumbra {
namespace {

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
    expect_error(positions_file(9), "there is no mode 9");
}

// Strips are joined by corners that come twice: that is no loss to warn of.
TEST_F(Gltf, JoinsOfStripsAreNoTriangles) {
    Buffer buffer;
    buffer.add(zigzag);
    const std::vector<uint8_t> corners{0, 1, 2, 2, 2, 3, 4};
    const size_t offset = buffer.add(corners);
    const auto model = load(one_primitive(
        buffer, view(0, 60) + "," + view(offset, corners.size()),
        R"({"bufferView":0,"componentType":5126,"count":5,"type":"VEC3"},{"bufferView":1,"componentType":5121,"count":7,"type":"SCALAR"})",
        R"("attributes":{"POSITION":0},"indices":1,"mode":5)"));
    ASSERT_TRUE(model) << diagnostics_.text();
    EXPECT_EQ(model->triangle_count(), 2u);
    EXPECT_EQ(model->dropped_degenerate, 0u);
}

TEST_F(Gltf, BadImageKeepsTheModel) {
    const std::string materials =
        R"(,"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,1,1],"baseColorTexture":{"index":0}}}],"textures":[{"source":0}])";
    for (const auto& [uri, reason] :
         {std::pair{"missing.png", "image \"missing.png\" is not there: the colour factor is used"},
          {"data:image/png;base64,bm90IGFuIGltYWdl", "image 0 cannot be read (neither"},
          {"data:image/webp;base64,bm90IGFuIGltYWdl", "image 0 cannot be read (neither"},
          {"data:image/png,abc", "cannot be read (its data: has no base64): the colour"}}) {
        const auto model =
            load(positions_file(5, fmt::format(R"({},"images":[{{"uri":"{}"}}])", materials, uri)));
        ASSERT_TRUE(model) << uri << diagnostics_.text();
        EXPECT_EQ(model->triangle_count(), 3u);
        EXPECT_EQ(model->materials[0].texture, -1);
        EXPECT_EQ(model->materials[0].base_color[1], 0.25f);
        ASSERT_EQ(model->warnings.size(), 1u) << uri;
        EXPECT_NE(model->warnings[0].find(reason), std::string::npos) << model->warnings[0];
    }
    // A good one is used.
    write_png_color(folder_ / "good.png", 2, 1, std::vector<float>{1, 0, 0, 0, 1, 0});
    const auto model = load(positions_file(5, materials + R"(,"images":[{"uri":"good.png"}])"));
    ASSERT_TRUE(model) << diagnostics_.text();
    EXPECT_EQ(model->materials[0].texture, 0);
    EXPECT_EQ(model->textures[0].rgba, (std::vector<uint8_t>{255, 0, 0, 255, 0, 255, 0, 255}));
    EXPECT_TRUE(model->warnings.empty());
}

// What the name may have meant is told, and not read.
TEST_F(Gltf, ImagesThatAreNotThereAreNamed) {
    fs::create_directory(folder_ / "tex");
    write_png_color(folder_ / "tex/t 1.png", 1, 1, std::vector<float>{1, 0, 0});
    write_png_color(folder_ / "good.png", 1, 1, std::vector<float>{1, 0, 0});
    const std::string materials =
        R"(,"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],"textures":[{"source":0}])";
    for (const auto& [uri, told] :
         {std::pair{"TEX/T%201.PNG", R"(image "TEX/T 1.PNG" is not there (did you mean "tex/t 1.png"?))"},
          {R"(tex\\t 1.png)", R"(image "tex\t 1.png" is not there (did you mean "tex/t 1.png"?))"},
          {R"(C:\\my\\good.png)", R"(image "C:\my\good.png" is not there (did you mean "good.png"?))"},
          {"http://a.org/b.png", R"(image "http://a.org/b.png" is not there)"},
          {"tex", R"(image "tex" is not there)"}}) {
        const auto model =
            load(positions_file(5, fmt::format(R"({},"images":[{{"uri":"{}"}}])", materials, uri)));
        ASSERT_TRUE(model) << uri << diagnostics_.text();
        EXPECT_EQ(model->warnings,
                  std::vector<std::string>{fmt::format("{}: the colour factor is used", told)});
    }
}

// A name is shown in a terminal, which takes some bytes as commands.
TEST_F(Gltf, NamesOfImagesAreShownWithoutControlCharacters) {
    write_png_color(folder_ / "a\x1b[2J.png", 1, 1, std::vector<float>{1, 0, 0});
    const auto model = load(positions_file(
        5,
        R"(,"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}},{"pbrMetallicRoughness":{"baseColorTexture":{"index":1}}}],"textures":[{"source":0},{"source":1}])"
        R"(,"images":[{"uri":"A%1B[2J.png"},{"uri":"\u007f\n.png"}])"));
    ASSERT_TRUE(model) << diagnostics_.text();
    EXPECT_EQ(model->warnings,
              (std::vector<std::string>{
                  R"(image "A?[2J.png" is not there (did you mean "a?[2J.png"?): the colour factor is used)",
                  R"(image "??.png" is not there: the colour factor is used)"}));
}

// tinygltf knows seven.
TEST_F(Gltf, DataMayBeOfAnyType) {
    write_png_color(folder_ / "good.png", 1, 1, std::vector<float>{1, 0, 0});
    std::ifstream stream(folder_ / "good.png", std::ios::binary);
    const std::string png(std::istreambuf_iterator<char>(stream), {});
    const std::string image = base64(std::as_bytes(std::span(png)));
    for (const std::string type : {"", "image/jpg", "image/ktx2", "application/octet-stream;charset=utf-8"}) {
        std::string file = positions_file(
            5,
            fmt::format(
                R"(,"materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],"textures":[{{"source":0}}],"images":[{{"uri":"data:{};base64,{}"}}])",
                type, image));
        const std::string known = "application/octet-stream;base64";
        file.replace(file.find(known), known.size(), type + ";base64");
        const auto model = load(file);
        ASSERT_TRUE(model) << type << diagnostics_.text();
        EXPECT_EQ(model->triangle_count(), 3u);
        EXPECT_TRUE(model->warnings.empty()) << model->warnings[0];
        EXPECT_EQ(model->materials[0].texture, 0);
    }
}

// Those of the core are used beside those of extensions.
TEST_F(Gltf, ImagesOfOtherFormatsMayHaveAFallback) {
    write_png_color(folder_ / "good.png", 1, 1, std::vector<float>{1, 0, 0});
    for (const std::string source : {R"("source":0,)", ""}) {
        const auto model = load(positions_file(
            5, R"(,"extensionsUsed":["EXT_texture_webp"],"images":[{"uri":"good.png"},{"uri":"t.webp"}],)"
               R"("materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],"textures":[{)" +
                   source + R"("extensions":{"EXT_texture_webp":{"source":1}}}])"));
        ASSERT_TRUE(model) << diagnostics_.text();
        EXPECT_EQ(model->materials[0].texture, source.empty() ? -1 : 0);
        EXPECT_EQ(model->warnings.size(), source.empty() ? 1u : 0u);
    }
}

// A file is what it begins with, whatever its name.
TEST_F(Gltf, FilesAreKnownByTheirFirstBytes) {
    const std::vector<std::byte> glb = to_glb(small_model());
    const std::string bytes(reinterpret_cast<const char*>(glb.data()), glb.size());
    EXPECT_TRUE(load(bytes)) << diagnostics_.text();
    EXPECT_TRUE(load("\xEF\xBB\xBF\n " + positions_file(5))) << diagnostics_.text();
    EXPECT_TRUE(load_gltf(save("a.glb", positions_file(5)), diagnostics_)) << diagnostics_.text();
    expect_error("", "is empty");
    expect_error("version https://git-lfs.github.com/spec/v1\noid sha256:1\n",
                 "begins with \"version https://git-lfs.github.com/spec/v1\", which is no glTF");
    expect_error("<html>\n", "begins with \"<html>\", which is no glTF");
    expect_error(std::string(64, '\0'), "is no glTF");
    expect_error(bytes.substr(0, 100),
                 fmt::format("is cut off: 100 bytes of the {} that its header says", bytes.size()));
    expect_error("glTF\2", "is cut off: 5 bytes of the 12");
    expect_error(R"({"asset":{"version":"2.0","minVersion":"2.1"}})",
                 "needs glTF 2.1; this program reads glTF 2.0");
    EXPECT_TRUE(load(R"({"asset":{"version":"2.1","minVersion":"2.0"}})")) << diagnostics_.text();
    for (const std::string least : {"10.0", "2.10", "3", "99999999999.0", "2.0.1", "two"})
        expect_error(R"({"asset":{"version":"2.0","minVersion":")" + least + R"("}})",
                     "needs glTF " + least + ";");
    for (const std::string least : {"", "1.10", "2", "02.0"})
        EXPECT_TRUE(load(R"({"asset":{"version":"2.0","minVersion":")" + least + R"("}})")) << least;
}

// An error is a line to be read, and no place for a buffer.
TEST_F(Gltf, ErrorsAreShort) {
    const std::string cut_off =
        R"({"asset":{"version":"2.0"},"buffers":[{"uri":"data:application/octet-stream;base64,)" +
        std::string(1'000'000, 'A');
    for (const std::string& file : {cut_off, cut_off + R"(","byteLength":7000000}]})"}) {
        expect_error(file, "AAA...");
        EXPECT_LT(diagnostics_.text().size(), 500u);
    }
}

// A buffer's data may be longer than the buffer (glTF 2.0, section 3.6.1.1), and is cut to its length.
TEST_F(Gltf, ABuffersDataMayBeLonger) {
    for (const size_t more : {1, 2, 3, 4, 5, 6}) {
        Buffer buffer;
        buffer.add(zigzag);
        const auto file = [&](const std::string& uri) {
            return R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
                "meshes":[{"primitives":[{"mode":5,"attributes":{"POSITION":0}}]}],
                "buffers":[{"byteLength":60,"uri":")" +
                   uri + R"("}],"bufferViews":[{"buffer":0,"byteLength":60}],
                "accessors":[{"bufferView":0,"componentType":5126,"count":5,"type":"VEC3"}]})";
        };
        buffer.bytes.resize(60 + more, std::byte{7});
        EXPECT_EQ(triangles_of(load(file(buffer.uri()))).size(), 3u) << more << diagnostics_.text();
        save("long.bin", {reinterpret_cast<const char*>(buffer.bytes.data()), buffer.bytes.size()});
        EXPECT_EQ(triangles_of(load(file("long.bin"))).size(), 3u) << more << diagnostics_.text();
        buffer.bytes.resize(60 - more);
        EXPECT_FALSE(load(file(buffer.uri()))) << more;
        save("long.bin", {reinterpret_cast<const char*>(buffer.bytes.data()), buffer.bytes.size()});
        EXPECT_FALSE(load(file("long.bin"))) << more;
    }
    // Of lengths that are no multiple of three.
    for (const size_t length : {1, 2, 3, 4}) {
        Buffer buffer;
        buffer.bytes.resize(8, std::byte{7});
        std::string text = positions_file(5);
        text.insert(text.find("\"buffers\":[") + 11,
                    R"({"byteLength":)" + std::to_string(length) + R"(,"uri":")" + buffer.uri() + "\"},");
        text.replace(text.find("\"buffer\":0"), 10, "\"buffer\":1");
        EXPECT_TRUE(load(text)) << length << diagnostics_.text();
    }
}

// What the parser would leave out as if nobody had written it, so that another picture is drawn.
TEST_F(Gltf, MembersOfAnotherTypeAreRefused) {
    const auto with = [&](std::string before, const std::string& after) {
        std::string text = positions_file(5, R"(,"materials":[{"pbrMetallicRoughness":{}}],"extensions":
            {"KHR_lights_punctual":{"lights":[{"type":"point"}]}})");
        const size_t at = text.find(before);
        EXPECT_NE(at, text.npos) << before;
        return text.replace(at, before.size(), after);
    };
    const std::string node = R"("nodes":[{"mesh":0)", view = R"("bufferView":0)", lamp = R"("type":"point")",
                      surface = R"("materials":[{"pbrMetallicRoughness":{)";
    ASSERT_TRUE(load(with(node, node))) << diagnostics_.text();
    expect_error(with(node, node + R"(,"scale":100)"), "nodes[0].scale: expected a list of 3 numbers");
    expect_error(with(node, node + R"(,"translation":"1,2,3")"),
                 "nodes[0].translation: expected a list of 3");
    expect_error(with(node, node + R"(,"rotation":[0,0,1])"), "nodes[0].rotation: expected a list of 4");
    expect_error(with(node, node + R"(,"children":1)"),
                 "nodes[0].children: expected a list of whole numbers");
    expect_error(with(view, view + R"(,"byteOffset":-4)"),
                 "accessors[0].byteOffset: expected a whole number");
    expect_error(with(view, view + R"(,"byteOffset":"12")"), "accessors[0].byteOffset: expected");
    expect_error(with(R"("byteOffset":0)", R"("byteOffset":-4)"), "bufferViews[0].byteOffset: expected");
    expect_error(with(R"("mode":5)", R"("mode":"TRIANGLES")"), "meshes[0].primitives[0].mode: expected");
    expect_error(with(R"("POSITION":0)", R"("POSITION":4294967296)"),
                 "meshes[0].primitives[0].attributes.POSITION: expected a whole number");
    for (const char* color : {R"("red")", "[1,0,0]"})
        expect_error(with(surface, surface + R"("baseColorFactor":)" + color),
                     "materials[0].pbrMetallicRoughness.baseColorFactor: expected a list of 4 numbers");
    expect_error(with(R"("materials":[{)", R"("materials":[{"doubleSided":"true",)"),
                 "materials[0].doubleSided: expected true or false");
    expect_error(with(R"("materials":[{)", R"("materials":[{"alphaMode":1,)"),
                 "materials[0].alphaMode: expected a string");
    expect_error(with(R"("nodes":[{"mesh":0)", R"("nodes":[7,{"mesh":0)"), "nodes[0]: expected an object");
    expect_error(with(R"("materials":[{"pbrMetallicRoughness":{}}])", R"("materials":{})"),
                 "materials: expected a list");
    expect_error(with(lamp, lamp + R"(,"color":[1,0])"),
                 "extensions.KHR_lights_punctual.lights[0].color: expected a list of 3 numbers");
    expect_error(with(R"("POSITION":0)", R"("POSITION":0,"WEIGHTS_0":0)"), "JOINTS_0 and WEIGHTS_0");
}

// RFC 3986 gives a plus no meaning but its own.
TEST_F(Gltf, APlusInANameIsAPlus) {
    Buffer buffer;
    buffer.add(zigzag);
    const std::string bytes(reinterpret_cast<const char*>(buffer.bytes.data()), buffer.bytes.size());
    std::string text = positions_file(5);
    const size_t from = text.find("data:"), to = text.find('"', from);
    text.replace(from, to - from, "a+b%2B c%20d.bin");
    save("a+b+ c d.bin", bytes);
    EXPECT_EQ(triangles_of(load(text)).size(), 3u) << diagnostics_.text();
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

}  // namespace
}  // namespace penumbra
