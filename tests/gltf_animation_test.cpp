// SPDX-License-Identifier: MIT
// What moves in a glTF file: animations of nodes, and skins that follow their joints.
#include <algorithm>
#include <array>
#include <cmath>

#include "host/scene/scene.h"
#include "tests/gltf_glb.h"

namespace penumbra {
namespace {

// Node 0 turns, node 1 hangs on it.
Glb animated_file(const char* path, const char* interpolation, const std::vector<float>& times,
                  const std::vector<float>& values, const char* type, size_t width) {
    Glb glb = square_file();
    const int input = glb.floats(times, "SCALAR", 1), output = glb.floats(values, type, width);
    glb.json["animations"] = {
        {{"name", "go"},
         {"samplers", {{{"input", input}, {"output", output}, {"interpolation", interpolation}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}}}}};
    return glb;
}

double x_at(const Model& model, double seconds) {
    return pose_at(model, 0, seconds)[0].translation.x;
}

// All of whose vertices hang on the first joint of a skin.
Glb square_of_one_joint() {
    Glb glb = square_file();
    const std::array<std::array<uint8_t, 4>, 4> joints{};
    primitive(glb)["attributes"]["JOINTS_0"] = glb.accessor(glb.view(joints.data(), 16), 5121, 4, "VEC4");
    primitive(glb)["attributes"]["WEIGHTS_0"] =
        glb.floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 4);
    return glb;
}

TEST(GltfFeatures, AnimationsInterpolateAndHold) {
    Glb linear = animated_file("translation", "LINEAR", {1, 3}, {0, 0, 0, 4, 0, 0}, "VEC3", 3),
        step = animated_file("translation", "STEP", {1, 3}, {0, 0, 0, 4, 0, 0}, "VEC3", 3),
        // Tangents of 1 per second out of the first key and into the second.
        cubic = animated_file("translation", "CUBICSPLINE", {1, 3},
                              {0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 4, 0, 0, 0, 0, 0}, "VEC3", 3),
        turning = animated_file("rotation", "LINEAR", {0, 1}, {0, 0, 0, 1, 0, 0, -1, 0}, "VEC4", 4);
    const Model a = loaded(linear, "linear.glb"), b = loaded(step, "step.glb"),
                c = loaded(cubic, "cubic.glb"), d = loaded(turning, "turning.glb");
    EXPECT_EQ(a.animations[0].duration_s, 3);
    EXPECT_DOUBLE_EQ(x_at(a, 0), 0);
    EXPECT_DOUBLE_EQ(x_at(a, 1.5), 1);
    EXPECT_DOUBLE_EQ(x_at(a, 9), 4);
    EXPECT_DOUBLE_EQ(x_at(b, 2.999), 0);
    EXPECT_DOUBLE_EQ(x_at(b, 3), 4);
    // p = (t3 - 2 t2 + t) 2 + (3 t2 - 2 t3) 4 + (t3 - t2) 2 at t = 1/4.
    EXPECT_NEAR(x_at(c, 1.5),
                2 * (1 / 64. - 2 / 16. + 1 / 4.) + 4 * (3 / 16. - 2 / 64.) + 2 * (1 / 64. - 1 / 16.), 1e-12);
    const glm::dquat half = pose_at(d, 0, 0.5)[0].rotation;  // of half a turn about z, the shorter way
    EXPECT_NEAR(std::abs(half.w), std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(std::abs(half.z), std::sqrt(0.5), 1e-12);
}

TEST(GltfFeatures, BrokenAnimationsAreErrorsByName) {
    for (const auto& [times, values] : {std::pair<std::vector<float>, std::vector<float>>{{0, 1}, {0, 0, 0}},
                                        {{0, 1}, {0, 0, 0, NAN, 0, 0}}}) {
        Glb glb = animated_file("translation", "LINEAR", times, values, "VEC3", 3);
        Diagnostics diagnostics;
        EXPECT_FALSE(load_gltf(glb.save("broken.glb"), diagnostics));
        EXPECT_NE(diagnostics.text().find("animation \"go\""), std::string::npos) << diagnostics.text();
    }
}

// Two keys at one time are a jump; what goes back in time is left out.
TEST(GltfFeatures, TimesOfKeysThatDoNotRise) {
    for (const char* how : {"LINEAR", "STEP"}) {
        Glb jump =
            animated_file("translation", how, {0, 1, 1, 2}, {0, 0, 0, 2, 0, 0, 5, 0, 0, 7, 0, 0}, "VEC3", 3);
        const Model model = loaded(jump, "jump.glb");
        EXPECT_TRUE(model.warnings.empty());
        EXPECT_DOUBLE_EQ(x_at(model, 0.5), *how == 'L' ? 1 : 0);
        EXPECT_DOUBLE_EQ(x_at(model, 1), 5);
        EXPECT_DOUBLE_EQ(x_at(model, 1.5), *how == 'L' ? 6 : 5);
    }
    for (const std::vector<float>& times : {std::vector<float>{0, 2, 1}, {-1, 0, 1}}) {
        Glb back = animated_file("translation", "LINEAR", times, {0, 0, 0, 1, 0, 0, 2, 0, 0}, "VEC3", 3);
        const Model model = loaded(back, "back.glb");
        EXPECT_TRUE(model.animations.at(0).channels.empty());
        EXPECT_EQ(model.warnings,
                  std::vector<std::string>{
                      "animation \"go\": keys whose times do not rise from 0 on are not played"});
    }
}

// As nodes and keys have to be.
TEST(GltfFeatures, InstancesSkinsAndMorphsHaveFiniteNumbers) {
    Glb instances = square_file(), skin = square_of_one_joint(), morph = square_file();
    const int scales = instances.floats({1, 1, 1, 1, NAN, 1}, "VEC3", 3);
    instances.json["nodes"][0]["name"] = "row";
    instances.json["nodes"][0]["extensions"] = {
        {"EXT_mesh_gpu_instancing", {{"attributes", {{"SCALE", scales}}}}}};
    std::vector<float> bind(16, 0);
    for (size_t k = 0; k < 4; ++k) bind[5 * k] = 1;
    bind[12] = INFINITY;
    skin.json["nodes"] = {{{"mesh", 0}, {"skin", 0}}, {{"name", "root"}}};
    skin.json["scenes"] = {{{"nodes", {0, 1}}}};
    skin.json["skins"] = {
        {{"name", "bones"}, {"joints", {1}}, {"inverseBindMatrices", skin.floats(bind, "MAT4", 16)}}};
    primitive(morph)["targets"] = {
        {{"POSITION", morph.floats({0, 0, 3, 0, 0, NAN, 0, 0, 3, 0, 0, 3}, "VEC3", 3)}}};
    for (const auto& [file, text] :
         {std::pair<Glb*, const char*>{&instances,
                                       "EXT_mesh_gpu_instancing: SCALE of node \"row\" is not finite"},
          {&skin, "skin \"bones\" has inverse bind matrices that are not finite"},
          {&morph, "primitive 0: a morph target is not finite"}}) {
        Diagnostics diagnostics;
        EXPECT_FALSE(load_gltf(file->save("not_finite.glb"), diagnostics)) << text;
        EXPECT_NE(diagnostics.text().find(text), std::string::npos) << diagnostics.text();
    }
}

// Two bones: the square's upper edge follows the second, which moves; the mesh's own node does not matter.
TEST(GltfFeatures, SkinsFollowTheirJoints) {
    Glb glb = square_file();
    const std::array<std::array<uint8_t, 4>, 4> joints{
        {{0, 1, 0, 0}, {0, 1, 0, 0}, {0, 1, 0, 0}, {0, 1, 0, 0}}};
    primitive(glb)["attributes"]["JOINTS_0"] = glb.accessor(glb.view(joints.data(), 16), 5121, 4, "VEC4");
    primitive(glb)["attributes"]["WEIGHTS_0"] =
        glb.floats({1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}, "VEC4", 4);
    glb.json["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"translation", {50, 0, 0}}},
                         {{"name", "root"}},
                         {{"name", "tip"}, {"translation", {0, 1, 0}}}};
    glb.json["scenes"] = {{{"nodes", {0, 1, 2}}}};
    std::vector<float> bind(32, 0);
    for (size_t i = 0; i < 2; ++i)
        for (size_t k = 0; k < 4; ++k) bind[16 * i + 5 * k] = 1;
    bind[16 + 13] = -1;  // the second joint's rest is one metre up
    glb.json["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", glb.floats(bind, "MAT4", 16)}}};
    const int input = glb.floats({0, 1}, "SCALAR", 1), output = glb.floats({0, 1, 0, 0, 1, 3}, "VEC3", 3);
    glb.json["animations"] = {
        {{"samplers", {{{"input", input}, {"output", output}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 2}, {"path", "translation"}}}}}}}};
    Shot shot;
    shot.fps = 10;
    shot.animation = "0";
    const Scene scene(loaded(glb, "skin.glb"), shot);
    EXPECT_TRUE(scene.animated());
    EXPECT_TRUE(scene.moved(0, 1));
    const auto positions = scene.positions(scene.instances()[0], scene.model().meshes[0].parts[0], 5);
    EXPECT_NEAR(glm::length(positions[0] - glm::vec3(0, 0, 0)), 0, 1e-6);
    EXPECT_NEAR(glm::length(positions[2] - glm::vec3(1, 1, 1.5)), 0, 1e-6);
    const auto box = scene.box(10);
    EXPECT_NEAR(box[1].z, 3, 1e-6);
    EXPECT_NEAR(box[1].x, 1, 1e-6);
    double highest = -1;
    for (const Triangle& t : scene.triangles(10))
        for (const auto& v : t.v) highest = std::max(highest, v[2] + scene.bvh_origin().z);
    EXPECT_NEAR(highest, 3, 1e-6);
}

// Where an instance stands its own transform says, which a skin would override: it is in its rest pose.
TEST(GltfFeatures, InstancesHaveNoSkin) {
    Glb glb = square_of_one_joint();
    const int translations = glb.floats({0, 0, 0, 5, 0, 0}, "VEC3", 3);
    glb.json["nodes"] = {
        {{"mesh", 0},
         {"skin", 0},
         {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", translations}}}}}}}},
        {{"name", "root"}}};
    glb.json["scenes"] = {{{"nodes", {0, 1}}}};
    glb.json["skins"] = {{{"joints", {1}}}};
    const Model model = loaded(glb, "skinned_instances.glb");
    EXPECT_EQ(model.warnings, std::vector<std::string>{"instances with a skin are in their rest pose"});
    EXPECT_EQ(Scene(model, Shot{}).bounds()[1].x, 6);
}

TEST(GltfFeatures, JointsThatAreNotThereAreErrors) {
    Glb glb = square_file();
    const std::array<std::array<uint8_t, 4>, 4> joints{
        {{7, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}}};
    primitive(glb)["attributes"]["JOINTS_0"] = glb.accessor(glb.view(joints.data(), 16), 5121, 4, "VEC4");
    primitive(glb)["attributes"]["WEIGHTS_0"] =
        glb.floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 4);
    glb.json["nodes"] = {{{"mesh", 0}, {"skin", 0}}, {{"name", "root"}}};
    glb.json["scenes"] = {{{"nodes", {0, 1}}}};
    glb.json["skins"] = {{{"joints", {1}}}};
    Diagnostics diagnostics;
    EXPECT_FALSE(load_gltf(glb.save("joints.glb"), diagnostics));
    EXPECT_NE(diagnostics.text().find("joint 7 of 1"), std::string::npos) << diagnostics.text();
}

// A node that an animation makes of nothing is there from the first frame on, with triangles of no area.
TEST(GltfFeatures, WhatIsNothingAtFirstMayGrow) {
    for (const int nothing : {0, 1}) {  // which key
        std::vector<float> scales(6, 1);
        for (size_t axis = 0; axis < 3; ++axis) scales[size_t(nothing) * 3 + axis] = 0;
        Glb glb = animated_file("scale", "LINEAR", {0, 1}, scales, "VEC3", 3);
        const Model model = loaded(glb, "grows.glb");
        Shot shot;
        shot.fps = 10;
        shot.animation = "0";
        const Scene scene(model, shot);
        EXPECT_EQ(scene.dropped_instances(), 0);
        ASSERT_EQ(scene.triangles(0).size(), 2u);
        EXPECT_NEAR(scene.box(0)[1].x, nothing == 0 ? 0 : 1, 1e-12);
        EXPECT_NEAR(scene.box(5)[1].x, 0.5, 1e-6);
        shot.animation.clear();
        EXPECT_EQ(Scene(model, shot).dropped_instances(), 0) << "at rest it has its own scale";
        Model gone = model;
        gone.nodes[0].scale = glm::dvec3(0);
        EXPECT_EQ(Scene(gone, shot).dropped_instances(), 1) << "what never moves stays nothing";
    }
}

// Morph weights are the node's, and those of each of its instances; so are their keys.
TEST(GltfFeatures, InstancesHaveTheirNodesMorphs) {
    Glb glb = animated_file("weights", "LINEAR", {0, 1}, {0, 1}, "SCALAR", 1);
    primitive(glb)["targets"] = {{{"POSITION", glb.floats({0, 0, 3, 0, 0, 3, 0, 0, 3, 0, 0, 3}, "VEC3", 3)}}};
    const int translations = glb.floats({0, 0, 0, 5, 0, 0}, "VEC3", 3);
    glb.json["nodes"][0]["extensions"] = {
        {"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", translations}}}}}};
    glb.json["nodes"][0]["weights"] = {0.25};
    Shot shot;
    shot.fps = 10;
    const Model model = loaded(glb, "morphs.glb");
    const Part& part = model.meshes[0].parts[0];
    const Scene still(model, shot);
    ASSERT_EQ(still.instances().size(), 2u);
    shot.animation = "0";
    const Scene moving(model, shot);
    for (size_t i = 0; i < 2; ++i) {
        EXPECT_NEAR(still.positions(still.instances()[i], part, 0)[0].z, 0.75, 1e-6) << i;
        EXPECT_NEAR(moving.positions(moving.instances()[i], part, 5)[0].z, 1.5, 1e-6) << i;
    }
}

// A skin's vertices are told from its first joint: fp32 in the scene's frame would lose the millimetre.
TEST(GltfFeatures, SkinsFarAwayKeepTheirShape) {
    Glb glb = square_of_one_joint();
    glb.json["nodes"] = {
        {{"mesh", 0}, {"skin", 0}},
        {{"name", "root"}, {"translation", {5e5, 50, 5.4e6}}, {"scale", {1e-3, 1e-3, 1e-3}}}};
    glb.json["scenes"] = {{{"nodes", {0, 1}}}};
    glb.json["skins"] = {{{"joints", {1}}}};
    const Scene scene(loaded(glb, "far.glb"), Shot{});
    double area = 0;
    for (const Triangle& t : scene.triangles(0)) {
        const auto corner = [&](size_t i) { return glm::dvec3(t.v[i][0], t.v[i][1], t.v[i][2]); };
        area += 0.5 * glm::length(glm::cross(corner(1) - corner(0), corner(2) - corner(0)));
    }
    EXPECT_NEAR(area, 1e-6, 1e-9);
    EXPECT_NEAR(scene.bounds()[0].x, 5e5, 1e-9);
    EXPECT_NEAR(scene.bounds()[1].z, 5.4e6, 1e-9);
}

}  // namespace
}  // namespace penumbra
