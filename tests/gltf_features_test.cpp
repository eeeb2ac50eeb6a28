// SPDX-License-Identifier: MIT
// glTF as users have it: compressed meshes, transformed and coloured textures, instances.
// Files are made here, with the compressors' own encoders.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/models/gltf.h"
#include "host/scene/scene.h"
#include "tests/gltf_glb.h"

namespace penumbra {
namespace {

void expect_square(const Model& model, double tolerance) {
    ASSERT_EQ(model.triangle_count(), 2u);
    const Part& part = model.meshes[0].parts[0];
    double area = 0;
    for (size_t i = 0; i < 6; i += 3) {
        const glm::vec3 a = part.positions[part.indices[i]], b = part.positions[part.indices[i + 1]],
                        c = part.positions[part.indices[i + 2]];
        area += glm::length(glm::cross(b - a, c - a)) / 2;
        EXPECT_GT(glm::cross(b - a, c - a).z, 0) << "the winding is kept";
    }
    EXPECT_NEAR(area, 1, tolerance);
}

TEST(GltfFeatures, DracoHoldsTheSameSquare) {
    draco::TriangleSoupMeshBuilder builder;
    builder.Start(2);
    const int attribute = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    for (int face = 0; face < 2; ++face) {
        const auto corner = [&](size_t k) { return &square[3 * square_indices[size_t(face) * 3 + k]]; };
        builder.SetAttributeValuesForFace(attribute, draco::FaceIndex(static_cast<uint32_t>(face)), corner(0),
                                          corner(1), corner(2));
    }
    const auto mesh = builder.Finalize();
    ASSERT_TRUE(mesh);
    draco::EncoderBuffer encoded;
    draco::Encoder encoder;
    ASSERT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &encoded).ok());

    Glb glb;
    glb.json["nodes"] = {{{"mesh", 0}}};
    const int view = glb.view(encoded.data(), encoded.size());
    const int position = glb.accessor(-1, 5126, mesh->num_points(), "VEC3"),
              indices = glb.accessor(-1, 5125, 6, "SCALAR");
    glb.json["extensionsRequired"] = glb.json["extensionsUsed"] = {"KHR_draco_mesh_compression"};
    const uint32_t id = mesh->attribute(attribute)->unique_id();
    glb.json["meshes"] = {{{"primitives",
                            {{{"attributes", {{"POSITION", position}}},
                              {"indices", indices},
                              {"extensions",
                               {{"KHR_draco_mesh_compression",
                                 {{"bufferView", view}, {"attributes", {{"POSITION", id}}}}}}}}}}}};
    expect_square(loaded(glb, "draco.glb"), 1e-3);

    glb.bytes[glb.bytes.size() / 2] ^= 0x55;
    glb.bytes[1] ^= 0x55;
    Diagnostics diagnostics;
    EXPECT_FALSE(load_gltf(glb.save("draco.glb"), diagnostics));
    EXPECT_NE(diagnostics.text().find("KHR_draco_mesh_compression"), std::string::npos) << diagnostics.text();
}

// Views of a buffer that holds nothing until they are decoded, as gltfpack writes them.
TEST(GltfFeatures, MeshoptHoldsTheSameSquare) {
    std::vector<float> padded;  // 16 bytes a vertex
    for (size_t i = 0; i < 4; ++i)
        padded.insert(padded.end(), {square[3 * i], square[3 * i + 1], square[3 * i + 2], 0});
    std::vector<unsigned char> vertices(meshopt_encodeVertexBufferBound(4, 16)),
        indices(meshopt_encodeIndexBufferBound(6, 4));
    vertices.resize(meshopt_encodeVertexBuffer(vertices.data(), vertices.size(), padded.data(), 4, 16));
    indices.resize(meshopt_encodeIndexBuffer(indices.data(), indices.size(), square_indices.data(), 6));
    Glb glb;
    glb.json["nodes"] = {{{"mesh", 0}}};
    const auto compressed = [&](const std::vector<unsigned char>& data, size_t stride, size_t count,
                                const char* mode) {
        glb.bytes.resize((glb.bytes.size() + 3) / 4 * 4);
        glb.json["bufferViews"].push_back({{"buffer", 1},
                                           {"byteOffset", 0},
                                           {"byteLength", stride * count},
                                           {"extensions",
                                            {{"EXT_meshopt_compression",
                                              {{"buffer", 0},
                                               {"byteOffset", glb.bytes.size()},
                                               {"byteLength", data.size()},
                                               {"byteStride", stride},
                                               {"count", count},
                                               {"mode", mode}}}}}});
        glb.bytes.append(reinterpret_cast<const char*>(data.data()), data.size());
        return static_cast<int>(glb.json["bufferViews"].size()) - 1;
    };
    const int position_view = compressed(vertices, 16, 4, "ATTRIBUTES"),
              index_view = compressed(indices, 4, 6, "TRIANGLES");
    glb.json["bufferViews"][0]["byteStride"] = 16;
    const int position = glb.accessor(position_view, 5126, 4, "VEC3"),
              index = glb.accessor(index_view, 5125, 6, "SCALAR");
    glb.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", position}}}, {"indices", index}}}}}};
    glb.json["extensionsRequired"] = glb.json["extensionsUsed"] = {"EXT_meshopt_compression"};
    glb.json["buffers"] = {
        Json::object(),
        {{"byteLength", 100000}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
    expect_square(loaded(glb, "meshopt.glb"), 1e-6);

    glb.bytes[0] ^= 0x55;
    Diagnostics diagnostics;
    EXPECT_FALSE(load_gltf(glb.save("meshopt.glb"), diagnostics));
    EXPECT_NE(diagnostics.text().find("EXT_meshopt_compression"), std::string::npos) << diagnostics.text();
}

TEST(GltfFeatures, TextureCoordinatesAreTransformedAndColoursRead) {
    Glb glb = square_file();
    primitive(glb)["attributes"]["TEXCOORD_1"] = glb.floats({0, 0, 1, 0, 1, 1, 0, 1}, "VEC2", 2);
    primitive(glb)["attributes"]["COLOR_0"] = glb.floats({0, .5, 1, 0, .5, 1, 0, .5, 1, 0, .5, 1}, "VEC3", 3);
    primitive(glb)["material"] = 0;
    glb.json["images"] = {{{"uri", "data:image/png;base64,AAAA"}}};
    glb.json["textures"] = {{{"source", 0}}};
    const double turn = std::acos(0.0);
    glb.json["materials"] = {
        {{"pbrMetallicRoughness",
          {{"baseColorTexture",
            {{"index", 0},
             {"extensions",
              {{"KHR_texture_transform",
                {{"offset", {.25, .5}}, {"scale", {2, 4}}, {"rotation", turn}, {"texCoord", 1}}}}}}}}}}};
    glb.json["extensionsRequired"] = {"KHR_texture_transform"};
    const Model model = loaded(glb, "transform.glb");
    ASSERT_EQ(model.triangle_count(), 2u);
    const Part& part = model.meshes[0].parts[0];
    // Section "Overview" of the extension: translation * rotation * scale, the rotation counter-clockwise.
    EXPECT_NEAR(part.uv[1].x, .25, 1e-6);
    EXPECT_NEAR(part.uv[1].y, .5 - 2, 1e-6);
    EXPECT_NEAR(part.uv[3].x, .25 + 4, 1e-6);
    EXPECT_NEAR(part.uv[3].y, .5, 1e-6);
    EXPECT_EQ(part.colors[2], (std::array<uint8_t, 4>{0, 128, 255, 255}));
}

// They are those of the first texture that the material has, which may be that of its transmission.
TEST(GltfFeatures, TextureCoordinatesMayBeThoseOfTransmission) {
    Glb glb = square_file();
    primitive(glb)["attributes"]["TEXCOORD_1"] = glb.floats({0, 0, 1, 0, 1, 1, 0, 1}, "VEC2", 2);
    primitive(glb)["material"] = 0;
    glb.json["images"] = {{{"uri", "data:image/png;base64,AAAA"}}};
    glb.json["textures"] = {{{"source", 0}}};
    glb.json["materials"] = {
        {{"extensions",
          {{"KHR_materials_transmission", {{"transmissionTexture", {{"index", 0}, {"texCoord", 1}}}}}}}}};
    const Model model = loaded(glb, "transmission.glb");
    ASSERT_EQ(model.triangle_count(), 2u);
    const Part& part = model.meshes[0].parts[0];
    ASSERT_EQ(part.uv.size(), 4u);
    EXPECT_EQ(part.uv[1], glm::vec2(1, 0));
    ASSERT_EQ(model.warnings.size(), 1u);
    EXPECT_TRUE(model.warnings[0].starts_with("image 0 cannot be read")) << model.warnings[0];
}

// Section 3.9.6; a primitive without a material has the default one, which is single-sided.
TEST(GltfFeatures, SidesAreTheMaterials) {
    for (const int material : {-1, 0, 1}) {
        Glb glb = square_file();
        glb.json["materials"] = {{{"doubleSided", true}}, {{"name", "one"}}};
        if (material >= 0) primitive(glb)["material"] = material;
        EXPECT_EQ(loaded(glb, "sides.glb").meshes[0].parts[0].single_sided, material != 0) << material;
    }
}

TEST(GltfFeatures, InstancesAreNodes) {
    Glb glb = square_file();
    const int translations = glb.floats({0, 0, 0, 5, 0, 0, 9, 0, 0}, "VEC3", 3);
    glb.json["nodes"][0]["extensions"] = {
        {"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", translations}}}}}};
    const Scene scene(loaded(glb, "instances.glb"), Shot{});
    EXPECT_EQ(scene.instances().size(), 3u);
    EXPECT_EQ(scene.bounds()[1].x, 10);
}

TEST(GltfFeatures, FactorsBeyondTheirBoundsAreTakenAtThem) {
    Glb glb = square_file();
    glb.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorFactor", {1.0000001, 0.5, 1, 1}}}}}};
    const Model rounded = loaded(glb, "rounded.glb");
    EXPECT_EQ(rounded.materials[0].base_color[0], 1);
    EXPECT_TRUE(rounded.warnings.empty());
    glb.json["materials"] = {{{"name", "hot"}, {"emissiveFactor", {5, 0, 0}}}};
    const Model hot = loaded(glb, "hot.glb");
    EXPECT_EQ(hot.materials[0].emissive[0], 1);
    EXPECT_EQ(hot.warnings, std::vector<std::string>{"material \"hot\": emissiveFactor 5 is taken as 1"});
    glb.json["materials"] = {{{"emissiveFactor", {-1, 0, 0}}}};
    Diagnostics diagnostics;
    EXPECT_FALSE(load_gltf(glb.save("dark.glb"), diagnostics));
    EXPECT_NE(diagnostics.text().find("emissiveFactor -1 is not a number from 0 on"), std::string::npos);
}

// Those of very many materials are one line.
TEST(GltfFeatures, FactorsBeyondTheirBoundsAreToldOnce) {
    Glb glb = square_file();
    for (int i = 0; i < 60; ++i)
        glb.json["materials"].push_back({{"name", fmt::format("m{}", i)},
                                         {"emissiveFactor", {2, 2, 2}},
                                         {"pbrMetallicRoughness", {{"metallicFactor", i == 7 ? 1.5 : 1}}}});
    EXPECT_EQ(
        loaded(glb, "many.glb").warnings,
        (std::vector<std::string>{
            "material \"m0\": emissiveFactor 2 is taken as 1 (one of 60 materials where it is too large)",
            "material \"m7\": metallicFactor 1.5 is taken as 1"}));
}

// As a surface that is no metal; what the core says of its colour comes first.
TEST(GltfFeatures, SpecularGlossinessHasAColour) {
    Glb glb = square_file();
    glb.json["images"] = {{{"uri", "data:image/png;base64,AAAA"}}};
    glb.json["textures"] = {{{"source", 0}}};
    const Json gloss = {{"diffuseFactor", {0.5, 0.25, 0.125, 1}}, {"glossinessFactor", 0.75}};
    Json textured = gloss;
    textured["diffuseTexture"] = {{"index", 0}};
    const auto material = [](const Json& extension, const Json& core) {
        return Json{{"extensions", {{"KHR_materials_pbrSpecularGlossiness", extension}}},
                    {"pbrMetallicRoughness", core}};
    };
    const Json red = {{"baseColorFactor", {1, 0, 0, 1}}};
    glb.json["materials"] = {material(gloss, Json::object()), material(gloss, red), material(textured, red)};
    const Model model = loaded(glb, "gloss.glb");
    EXPECT_EQ(model.materials[0].base_color, (std::array<float, 4>{0.5f, 0.25f, 0.125f, 1}));
    EXPECT_EQ(model.materials[0].metallic, 0);
    EXPECT_EQ(model.materials[0].roughness, 0.25f);
    EXPECT_EQ(model.materials[1].base_color, (std::array<float, 4>{1, 0, 0, 1}));
    EXPECT_EQ(model.materials[2].base_color, model.materials[0].base_color);
    ASSERT_EQ(model.warnings.size(), 1u);
    EXPECT_TRUE(model.warnings[0].starts_with("image 0 cannot be read")) << model.warnings[0];
    glb.json["materials"] = Json::array({material({{"glossinessFactor", 4}}, Json::object())});
    const Model mirror = loaded(glb, "gloss.glb");
    EXPECT_EQ(mirror.materials[0].roughness, 0);
    EXPECT_EQ(mirror.warnings, std::vector<std::string>{"material \"\": glossinessFactor 4 is taken as 1"});
    glb.json["materials"] = Json::array({material({{"glossinessFactor", -3}}, Json::object())});
    Diagnostics diagnostics;
    EXPECT_FALSE(load_gltf(glb.save("gloss.glb"), diagnostics));
    EXPECT_NE(diagnostics.text().find("glossinessFactor -3 is not a number from 0 on"), std::string::npos)
        << diagnostics.text();
}

TEST(GltfFeatures, WhatIsHiddenIsNotThere) {
    Glb glb = square_file();
    const Json hidden = {{"KHR_node_visibility", {{"visible", false}}}};
    glb.json["extensionsRequired"] = {"KHR_node_visibility"};
    glb.json["nodes"] = {{{"mesh", 0}, {"extensions", {{"KHR_node_visibility", {{"visible", true}}}}}},
                         {{"translation", {9, 0, 0}}, {"children", {2}}, {"extensions", hidden}},
                         {{"mesh", 0}, {"extensions", {{"KHR_node_visibility", {{"visible", true}}}}}}};
    glb.json["scenes"] = {{{"nodes", {0, 1}}}};
    const Scene scene(loaded(glb, "hidden.glb"), Shot{});
    EXPECT_EQ(scene.instances().size(), 1u);
    EXPECT_EQ(scene.bounds()[1].x, 1);
    glb.json["nodes"][1]["extensions"]["KHR_node_visibility"]["visible"] = 0;
    Diagnostics diagnostics;
    EXPECT_FALSE(load_gltf(glb.save("hidden.glb"), diagnostics));
    EXPECT_NE(diagnostics.text().find("\"visible\" is no boolean"), std::string::npos) << diagnostics.text();
}

TEST(GltfFeatures, WhatIsNotDrawnIsTold) {
    for (const char* mode : {"OPAQUE", "MASK"}) {
        Glb glb = square_file();
        primitive(glb)["attributes"]["COLOR_0"] =
            glb.floats({1, 1, 1, 0.5, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1}, "VEC4", 4);
        primitive(glb)["material"] = 0;
        glb.json["materials"] = {{{"alphaMode", mode}}};
        const std::vector<std::string> told = loaded(glb, "clear.glb").warnings;
        EXPECT_EQ(told, *mode == 'O' ? std::vector<std::string>{}
                                     : std::vector<std::string>{"the alpha of vertex colours is ignored"});
    }
    Glb glb = square_file();
    glb.json["images"] = {{{"uri", "data:image/png;base64,AAAA"}}};
    glb.json["textures"] = {{{"source", 0}}};
    glb.json["materials"] = {{{"normalTexture", {{"index", 0}}}}};
    const std::vector<std::string> told = loaded(glb, "bumps.glb").warnings;
    ASSERT_EQ(told.size(), 1u);
    EXPECT_TRUE(told[0].starts_with("normal maps are not drawn")) << told[0];
}

// Section 3.6.2.1: numbers that are not stored are zeros.
TEST(GltfFeatures, AccessorsWithoutDataAreZeros) {
    Glb glb = square_file();
    primitive(glb)["targets"] = {{{"POSITION", glb.accessor(-1, 5126, 4, "VEC3")}}};
    const Model model = loaded(glb, "zeros.glb");
    EXPECT_EQ(model.meshes.at(0).parts.at(0).targets.at(0), std::vector<glm::vec3>(4, glm::vec3(0)));
}

// What was translation, rotation and scale comes apart again, mirrored or not.
TEST(GltfFeatures, NodesWithAMatrixCanBeMoved) {
    for (const double mirror : {1.0, -1.0}) {
        Model model;
        model.meshes.push_back(
            {{Part{.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 1}}, .indices = {0, 1, 2}}}});
        Node plain{.name = "thing",
                   .mesh = 0,
                   .translation = {3, 1, 2},
                   .rotation = glm::normalize(glm::dquat(1, .3, -.2, .5)),
                   .scale = {mirror * 2, .5, 1.5}};
        Model with_matrix = model;
        model.nodes = {plain};
        Shot still;
        Node matrix{.name = "thing", .mesh = 0};
        matrix.matrix = Scene(model, still).transforms(0)[0];
        with_matrix.nodes = {matrix};
        Shot shot;
        shot.objects["thing"].keys = {{.frame = 0},
                                      {.frame = 4, .translation = {1, 2, 3}, .rotation_deg = {0, 0, 40}}};
        const glm::dmat4 a = Scene(model, shot).transforms(4)[0],
                         b = Scene(with_matrix, shot).transforms(4)[0];
        EXPECT_NEAR(glm::length(a[3] - b[3]), 0, 1e-12);
        if (mirror > 0) {
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(glm::length(a[c] - b[c]), 0, 1e-9) << c;
        }
        EXPECT_NEAR(glm::determinant(a), glm::determinant(b), 1e-9);
        EXPECT_NEAR(glm::length(Scene(with_matrix, shot).transforms(0)[0][0] -
                                Scene(with_matrix, still).transforms(0)[0][0]),
                    0, 1e-12);
    }
}

}  // namespace
}  // namespace penumbra
