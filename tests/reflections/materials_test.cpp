// SPDX-License-Identifier: MIT
// Materials through files, what rays hit, environments, and what is said where they are wrong.
#include <gtest/gtest.h>

#include <bit>
#include <fstream>
#include <limits>

#include "host/images/image_file.h"
#include "host/materials/environment.h"
#include "host/materials/hit_surfaces.h"
#include "host/models/glb_writer.h"
#include "host/models/gltf.h"
#include "host/models/model_builder.h"
#include "tests/test_folder.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

class Materials : public ::testing::Test {
  protected:
    std::optional<Model> read_back(const Model& model) {
        write_file(folder_ / "m.glb", to_glb(model));
        return load_gltf(folder_ / "m.glb", diagnostics_);
    }
    std::optional<Model> read(const std::string& material) {
        std::ofstream(folder_ / "m.gltf")
            << R"({"asset": {"version": "2.0"}, "materials": [)" + material + "]}";
        return load_gltf(folder_ / "m.gltf", diagnostics_);
    }
    std::optional<Shot> shot(const std::string& environment) {
        std::ofstream(folder_ / "s.shot.json") << R"({ "penumbra_shot": 1, "scene": "m.glb",
  "camera": { "keys": [ { "frame": 0, "position": [0, 1, 3], "target": [0, 0, 0] } ] },
  "sun": { "keys": [ { "frame": 0, "to_sun": [0, 1, 0] } ] },
  "environment": )" + environment + " }";
        return read_shot(folder_ / "s.shot.json", diagnostics_);
    }
    void expect_error(const std::string& text) {
        EXPECT_NE(diagnostics_.text().find(text), std::string::npos) << diagnostics_.text();
        diagnostics_ = {};
    }

    test::TestFolder folder_;
    Diagnostics diagnostics_;
};

Texture texture(std::initializer_list<uint32_t> texels, uint32_t width) {
    Texture out{width, static_cast<uint32_t>(texels.size()) / width, {}};
    for (const uint32_t t : texels)
        for (int k = 0; k < 4; ++k) out.rgba.push_back(static_cast<uint8_t>(t >> 8 * k));
    return out;
}

TEST_F(Materials, SurviveAFile) {
    Material metal;
    metal.metallic = 0.75f;
    metal.roughness = 0.125f;
    metal.metallic_roughness_texture = 1;
    metal.texture = 0;
    Material lamp;
    lamp.emissive = {30, 15, 7.5f};
    lamp.emissive_texture = 2;
    ModelBuilder builder({metal, lamp}, {texture({0xff0000ff}, 1), texture({0xff00ff00, 0xff112233}, 2),
                                         texture({0xffff0000}, 1)});
    builder.solid("a", box({0, 0, 0}, {1, 1, 1}), 0);
    builder.solid("b", box({2, 0, 0}, {3, 1, 1}), 1);
    const auto model = read_back(builder.take());
    ASSERT_TRUE(model) << diagnostics_.text();
    EXPECT_EQ(model->materials[0].metallic, 0.75f);
    EXPECT_EQ(model->materials[0].roughness, 0.125f);
    EXPECT_EQ(model->materials[0].metallic_roughness_texture, 1);
    EXPECT_EQ(model->materials[0].emissive, (std::array<float, 3>{}));
    EXPECT_EQ(model->materials[1].emissive, lamp.emissive);
    EXPECT_EQ(model->materials[1].emissive_texture, 2);
    EXPECT_EQ(model->textures[1].rgba[4], 0x33);
    EXPECT_EQ(model->textures.size(), 3u);
}

// glTF 2.0, section 3.9.2: what a file does not say is metal, and rough.
TEST_F(Materials, DefaultsAreTheFormats) {
    const auto model = read("{}");
    ASSERT_TRUE(model) << diagnostics_.text();
    EXPECT_EQ(model->materials[0].metallic, 1);
    EXPECT_EQ(model->materials[0].roughness, 1);
}

TEST_F(Materials, AreChecked) {
    EXPECT_FALSE(read(R"({ "name": "m", "pbrMetallicRoughness": { "roughnessFactor": -0.5 } })"));
    expect_error("material \"m\": roughnessFactor -0.5 is not a number from 0 on");
    EXPECT_FALSE(read(R"({ "name": "m", "pbrMetallicRoughness": { "metallicFactor": -1 } })"));
    expect_error("metallicFactor -1");
    EXPECT_FALSE(read(R"({ "emissiveFactor": [0, -2, 0] })"));
    expect_error("emissiveFactor -2");
    EXPECT_FALSE(
        read(R"({ "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": -3 } } })"));
    expect_error("emissiveStrength -3");
    EXPECT_FALSE(read(
        R"({ "name": "m", "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": "3" } } })"));
    expect_error(
        R"(material "m": KHR_materials_emissive_strength: "emissiveStrength": expected a number, not a string)");
    EXPECT_FALSE(
        read(R"({ "extensions": { "KHR_materials_transmission": { "transmissionFactor": [1] } } })"));
    expect_error(R"("transmissionFactor": expected a number, not an array)");
    EXPECT_FALSE(read(R"({ "emissiveTexture": { "index": 4 } })"));
    expect_error("texture 4 does not exist");
}

TEST_F(Materials, AHitFindsItsTriangle) {
    Material first, second;
    first.base_color = {0.25f, 0.5f, 1, 1};
    second.texture = 0;
    second.emissive = {1, 2, 3};
    ModelBuilder builder({first, second}, {texture({1, 2, 3, 4, 5, 6}, 3)});
    builder.solid("a", box({0, 0, 0}, {1, 1, 1}), 0);
    builder.solid("b", box({2, 0, 0}, {3, 1, 1}), 1);
    Shot moving;
    moving.frames = 2;
    ObjectMotion& motion = moving.objects["b"];
    motion.keys = {{0, {0, 0, 0}, {}}, {1, {0, 0.5, 0}, {}}};
    const Scene scene(builder.take(), moving);
    const std::vector<Triangle> triangles = scene.triangles(1);
    const Bvh bvh = build_bvh(triangles, scene.triangle_objects());
    const std::array<uint32_t, 5> instances{0, 12, 13, 14, 15};
    const SurfaceTexels made = make_surface_texels(scene, 1, 0, &bvh, instances);
    const auto word = [&](uint32_t texel, size_t k) { return made.surfaces[texel + k / 4][k % 4]; };

    // By leaf: the triangle that is named is the one whose corners the leaf holds.
    const uint32_t leaves = made.surfaces[0][0];
    for (size_t leaf = 0; leaf < bvh.corners.size(); ++leaf)
        for (size_t which = 0; which < 2; ++which) {
            const uint32_t t = word(leaves, leaf * 2 + which);
            ASSERT_LT(t, triangles.size());
            const size_t corner = which == 0 ? 0 : 3;  // v0, v3
            const auto at = [&](size_t i) {
                const size_t w = corner * 3 + i;
                return std::bit_cast<float>(bvh.leaves[leaf * 3 + w / 4][w % 4]);
            };
            bool found = false;
            for (size_t k = 0; k < 3; ++k) {
                bool same = true;
                for (size_t i = 0; i < 3; ++i)
                    same = same && std::bit_cast<float>(word(1 + 4 * t, 3 * k + i)) == at(i);
                found = found || same;
            }
            EXPECT_TRUE(found) << "leaf " << leaf << ", triangle " << t;
        }
    for (size_t i = 0; i < instances.size(); ++i) EXPECT_EQ(word(made.surfaces[0][1], i), instances[i]);

    // Material and motion, of a triangle of either box.
    EXPECT_EQ(word(1 + 4 * 3, 15), 1u);
    EXPECT_EQ(word(1 + 4 * 15, 15), 2u | 1u << 31);
    const uint32_t materials = made.surfaces[0][2];
    EXPECT_EQ(std::bit_cast<float>(word(materials + 3, 1)), 0.5f);
    EXPECT_EQ(word(materials + 3, 8), ~0u) << "no texture";
    EXPECT_EQ(std::bit_cast<float>(word(materials + 6, 6)), 3.0f);
    EXPECT_EQ(word(materials + 6, 8), 0u);
    EXPECT_EQ(word(materials + 6, 9), 2u | 1u << 16) << "3x2 texels";
    EXPECT_EQ(made.texels, (std::vector<uint32_t>{1, 2, 3, 4, 5, 6}));

    // Moved, they are what they would be made as; all of the other box stays.
    std::vector<Texel> surfaces = make_surface_texels(scene, 0, 0, &bvh, instances).surfaces;
    const std::vector<Texel> before = surfaces;
    const std::vector<uint32_t> written = move_surface_texels(scene, 1, 0, surfaces);
    EXPECT_EQ(surfaces, made.surfaces);
    std::vector<uint32_t> unlike;
    for (uint32_t i = 0; i < surfaces.size(); ++i)
        if (surfaces[i] != before[i]) unlike.push_back(i);
    EXPECT_EQ(written, unlike);
    ASSERT_FALSE(written.empty());
    EXPECT_GE(written.front(), 1u + 4 * 12);
}

// Where the vertices of a part move its node may stand still.
TEST_F(Materials, WhatDeformsMoves) {
    Part still{.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .indices = {0, 1, 2}}, morphs = still;
    morphs.targets = {{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}}};
    Model model;
    model.meshes.push_back({{still, morphs}});
    model.nodes = {Node{.name = "body", .mesh = 0}};
    AnimationChannel channel;
    channel.node = 0;
    channel.path = AnimationChannel::Path::weights;
    channel.times = channel.values = {0, 1};
    model.animations.push_back({"rises", 1, {channel}});
    Shot shot;
    shot.fps = 10;
    shot.animation = "rises";
    const Scene scene(std::move(model), shot);
    const auto moves = [&](double frame, double previous) {
        const auto surfaces = make_surface_texels(scene, frame, previous, nullptr, {}).surfaces;
        return std::array{surfaces[1 + 3][3] >> 31, surfaces[1 + 4 + 3][3] >> 31};  // of either triangle
    };
    EXPECT_EQ(moves(1, 0), (std::array{0u, 1u}));
    EXPECT_EQ(moves(1, 1), (std::array{0u, 0u}));
}

TEST_F(Materials, EnvironmentsAreRead) {
    PlanarImage image{2, 1, {}};
    for (const char* name : {"R", "G", "B"}) image.planes.push_back({name, PlaneType::real, {1, 3}, {}});
    write_exr(folder_ / "sky.exr", image);
    const auto good = shot(R"({ "file": "sky.exr", "scale": 2 })");
    ASSERT_TRUE(good) << diagnostics_.text();
    const auto map = make_environment(*good, diagnostics_);
    ASSERT_TRUE(map) << diagnostics_.text();
    EXPECT_EQ(map->rgba, (std::vector<float>{2, 2, 2, 1, 6, 6, 6, 1}));

    image.planes[1].values[1] = -1;
    write_exr(folder_ / "sky.exr", image);
    EXPECT_FALSE(make_environment(*good, diagnostics_));
    expect_error("sky.exr: G: -2 at 1, 0 is no radiance");
    image.planes[1].values[1] = std::numeric_limits<float>::infinity();
    write_exr(folder_ / "sky.exr", image);
    EXPECT_FALSE(make_environment(*good, diagnostics_));
    expect_error("is no radiance");
    image.planes.pop_back();
    image.planes[1].values[1] = 0;
    write_exr(folder_ / "sky.exr", image);
    EXPECT_FALSE(make_environment(*good, diagnostics_));
    expect_error("B: an environment needs this channel");
    EXPECT_FALSE(make_environment(*shot(R"({ "file": "none.exr" })"), diagnostics_));
    expect_error("none.exr");

    // The image is within the limit, and not what becomes of it.
    image = {256, 128, {}};
    for (const char* name : {"R", "G", "B"})
        image.planes.push_back({name, PlaneType::real, std::vector<float>(256 * 128), {}});
    write_exr(folder_ / "sky.exr", image);
    EXPECT_TRUE(make_environment(*good, diagnostics_));
    ::setenv("PENUMBRA_INPUT_LIMIT_MIB", "1", 1);
    EXPECT_FALSE(make_environment(*good, diagnostics_));
    ::unsetenv("PENUMBRA_INPUT_LIMIT_MIB");
    expect_error("sky.exr: an environment of 256x128 takes more than 1 MiB");
}

TEST_F(Materials, EnvironmentsOfShotsAreChecked) {
    for (const auto& [json, text] :
         {std::pair{R"({ "file": "a.exr", "up": [1, 1, 1] })", R"(with "file" has no "up")"},
          std::pair{R"({ "up": [1, 1, 1] })", R"("down" is missing)"},
          std::pair{R"({ "down": [0, -1, 0], "up": [1, 1, 1] })", "may not be negative"},
          std::pair{R"({ "flie": "a.exr" })", "did you mean \"file\""},
          std::pair{R"({ "file": "" })", "expected the name of an EXR file"},
          std::pair{R"({ "file": "a.exr", "scale": -1 })", "-1 is not in"},
          std::pair{R"(3)", "expected an object"}}) {
        EXPECT_FALSE(shot(json)) << json;
        expect_error(text);
    }
}

}  // namespace
}  // namespace penumbra
