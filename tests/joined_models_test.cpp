// SPDX-License-Identifier: MIT
// Several models as one: whatever one of them refers to by an index is its own afterwards. Of every list that
// indices lead into, a model here has two, so that none is right by chance, and each element tells whose it
// is.
#include "host/models/joined_models.h"

#include <gtest/gtest.h>

namespace penumbra {
namespace {

// `tag` below 100. The second of each is what the first refers to.
Model model_of(int tag) {
    Model m;
    const std::string name = std::to_string(tag);
    const auto width = [&](uint32_t n) { return Texture{uint32_t(10 * tag) + n, 1, {}}; };
    for (uint32_t n = 0; n < 4; ++n) m.textures.push_back(width(n));
    m.materials.resize(2);
    m.materials[1].base_color[0] = float(tag);
    m.materials[1].texture = 1;
    m.materials[1].metallic_roughness_texture = 2;
    m.materials[1].emissive_texture = 3;
    m.meshes.resize(2);
    Part part;
    part.origin.x = tag;
    part.material = 1;
    part.indices = {0, 1, 2};
    m.meshes[1].parts = {part, part};
    m.meshes[1].parts[1].material = -1;
    m.nodes.resize(3);
    m.nodes[0].name = "root " + name;
    m.nodes[1].name = "shown " + name;
    m.nodes[1].parent = 0;
    m.nodes[1].mesh = 1;
    m.nodes[1].skin = 1;
    m.nodes[2].name = "joint " + name;
    m.nodes[2].parent = 1;
    m.nodes[2].weights_of = 1;
    m.skins.resize(2);
    m.skins[1].joints = {2, 1};
    m.animations.push_back({"turn", 1, {{}, {}}});
    m.animations[0].channels[0].node = 1;
    m.animations[0].channels[1].node = 2;
    m.cameras.push_back({1, double(tag), 0.1});
    m.suns = {2};
    m.lights.push_back({1, "lamp"});
    m.warnings = {"odd"};
    m.dropped_degenerate = 3;
    m.dropped_nonfinite = 5;
    return m;
}

TEST(JoinedModels, EachKeepsWhatItRefersTo) {
    Model all;
    for (const int tag : {1, 2, 3}) {
        PlacedModel place;
        place.file = "file" + std::to_string(tag);
        place.name = "m" + std::to_string(tag);
        place.place.translation = {tag, 0, 0};
        place.scale = tag;
        join_model(all, model_of(tag), place);
    }
    ASSERT_EQ(all.nodes.size(), 12u);
    ASSERT_EQ(all.meshes.size(), 6u);
    ASSERT_EQ(all.skins.size(), 6u);
    ASSERT_EQ(all.animations.size(), 3u);
    ASSERT_EQ(all.cameras.size(), 3u);
    ASSERT_EQ(all.suns.size(), 3u);
    ASSERT_EQ(all.lights.size(), 3u);
    EXPECT_EQ(all.dropped_degenerate, 9u);
    EXPECT_EQ(all.dropped_nonfinite, 15u);
    for (size_t i = 0; i < 3; ++i) {
        const int tag = int(i) + 1;
        const std::string name = std::to_string(tag), before = "m" + name + "/";
        const auto node = [&](int index) { return all.nodes.at(size_t(index)).name; };
        const Node *root = &all.nodes[4 * i], *shown = root + 2, *joint = root + 3;
        EXPECT_EQ(root->name, "m" + name);
        EXPECT_EQ(root->parent, -1);
        EXPECT_EQ(root->translation.x, tag);
        EXPECT_EQ(root->scale, glm::dvec3(tag));
        EXPECT_EQ(node(root[1].parent), root->name) << "a root hangs below the place";
        EXPECT_EQ(root[1].mesh, -1);
        EXPECT_EQ(root[1].skin, -1);
        EXPECT_EQ(node(shown->parent), before + "root " + name);
        EXPECT_EQ(node(joint->parent), before + "shown " + name);
        EXPECT_EQ(node(joint->weights_of), before + "shown " + name);
        EXPECT_EQ(shown->weights_of, -1) << "none stays none";
        for (size_t n = 1; n < 4; ++n) EXPECT_LT(root[n].parent, int(4 * i + n)) << "parents first";

        const Mesh& mesh = all.meshes.at(size_t(shown->mesh));
        ASSERT_EQ(mesh.parts.size(), 2u);
        EXPECT_EQ(mesh.parts[0].origin.x, tag);
        EXPECT_EQ(mesh.parts[1].material, -1) << "none stays none";
        const Material& material = all.materials.at(size_t(mesh.parts[0].material));
        EXPECT_EQ(material.base_color[0], float(tag));
        const auto width = [&](int index) { return all.textures.at(size_t(index)).width; };
        EXPECT_EQ(width(material.texture), 10u * tag + 1);
        EXPECT_EQ(width(material.metallic_roughness_texture), 10u * tag + 2);
        EXPECT_EQ(width(material.emissive_texture), 10u * tag + 3);

        const Skin& skin = all.skins.at(size_t(shown->skin));
        ASSERT_EQ(skin.joints.size(), 2u);
        EXPECT_EQ(node(skin.joints[0]), before + "joint " + name);
        EXPECT_EQ(node(skin.joints[1]), before + "shown " + name);
        EXPECT_EQ(all.animations[i].name, before + "turn");
        EXPECT_EQ(node(all.animations[i].channels[0].node), before + "shown " + name);
        EXPECT_EQ(node(all.animations[i].channels[1].node), before + "joint " + name);
        EXPECT_EQ(node(all.cameras[i].node), before + "shown " + name);
        EXPECT_EQ(all.cameras[i].vertical_fov_deg, tag);
        EXPECT_EQ(node(all.suns[i]), before + "joint " + name);
        EXPECT_EQ(node(all.lights[i].node), before + "shown " + name);
        EXPECT_EQ(all.lights[i].name, before + "lamp");
        EXPECT_EQ(all.warnings[i], "file" + name + ": odd");
    }
}

// Degrees about x, then y, then z of the axes that the turn before has left: the quaternion's own product.
TEST(JoinedModels, StandTurnedAsTheyAreTold) {
    Model all;
    PlacedModel place;
    place.name = "m";
    place.place.rotation_deg = {90, 90, 0};
    join_model(all, model_of(1), place);
    const glm::dvec3 z = all.nodes[0].rotation * glm::dvec3(0, 0, 1);  // y turns it to x, which x leaves
    EXPECT_NEAR(z.x, 1, 1e-12);
    EXPECT_NEAR(z.y, 0, 1e-12);
    EXPECT_NEAR(z.z, 0, 1e-12);
}

}  // namespace
}  // namespace penumbra
