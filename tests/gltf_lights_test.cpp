// SPDX-License-Identifier: MIT
// Lights and cameras of glTF files, and what of them is in a shot that is made for the model.
#include <chrono>
#include <cmath>
#include <regex>
#include <set>

#include "app/view_source.h"
#include "host/scene/scene.h"
#include "host/shots/model_lights.h"
#include "host/shots/model_shot.h"
#include "tests/gltf_glb.h"

namespace penumbra {
namespace {

// A square, and a node 3 m up that looks down with this light.
Glb lamp_file(const Json& light) {
    Glb glb = square_file();
    const double h = std::sqrt(0.5);
    glb.json["extensionsUsed"] = {"KHR_lights_punctual"};
    glb.json["extensions"] = {{"KHR_lights_punctual", {{"lights", Json::array({light})}}}};
    glb.json["nodes"].push_back({{"name", "holder"},
                                 {"translation", {1, 3, 2}},
                                 {"rotation", {-h, 0, 0, h}},
                                 {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    glb.json["scenes"] = {{{"nodes", {0, 1}}}};
    return glb;
}

// A shot made from the model names the light, and so may any other, with a size of its own.
TEST(GltfFeatures, AShotTakesTheFilesLamps) {
    const Json spot = {{"type", "spot"},
                       {"name", "desk"},
                       {"intensity", 40},
                       {"range", 7},
                       {"color", {1, 0.5, 0.25}},
                       {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.5}}},
                       {"extras", {{"radius", 0.03}}}};
    Glb file = lamp_file(spot);
    const Model model = loaded(file, "spot.glb");
    const std::string made = make_model_shot(model, "spot.glb", "", false).text;
    Diagnostics diagnostics;
    auto shot = parse_shot(made, "spot.shot.json", diagnostics);
    ASSERT_TRUE(shot) << diagnostics.text();
    ASSERT_TRUE(shot->lights.contains("desk"));
    ASSERT_TRUE(place_model_lights(*shot, Scene(model, *shot), diagnostics)) << diagnostics.text();
    const ShotLight& light = shot->lights.at("desk");
    EXPECT_EQ(light.kind, LightKind::spot);
    EXPECT_EQ(light.radius, 0.03);
    EXPECT_EQ(light.strength, 40);
    EXPECT_EQ(light.range, 7);
    EXPECT_EQ(light.color, glm::dvec3(1, 0.5, 0.25));
    EXPECT_NEAR(light.inner_deg, glm::degrees(0.1), 1e-9);
    EXPECT_NEAR(light.outer_deg, glm::degrees(0.5), 1e-9);
    ASSERT_EQ(light.keys.size(), 1u);
    EXPECT_EQ(light.keys[0].position, glm::dvec3(1, 3, 2));
    EXPECT_NEAR(glm::length(light.keys[0].direction - glm::dvec3(0, -1, 0)), 0, 1e-9);

    std::string other = made;
    const std::string name = "\"light\": \"desk\"";
    other.replace(other.find(name), name.size(), name + ", \"radius\": 0.2");
    auto sized = parse_shot(other, "spot.shot.json", diagnostics);
    ASSERT_TRUE(sized && place_model_lights(*sized, Scene(model, *sized), diagnostics)) << diagnostics.text();
    EXPECT_EQ(sized->lights.at("desk").radius, 0.2);

    other.replace(other.find(name), name.size(), "\"light\": \"dask\"");
    auto unknown = parse_shot(other, "spot.shot.json", diagnostics);
    ASSERT_TRUE(unknown);
    EXPECT_FALSE(place_model_lights(*unknown, Scene(model, *unknown), diagnostics));
    EXPECT_NE(diagnostics.text().find("no light named \"dask\"; did you mean \"desk\"?"), std::string::npos)
        << diagnostics.text();

    Model many = model;
    for (int i = 0; i < 1000; ++i) many.lights.push_back(model.lights[0]);
    Diagnostics short_of;
    EXPECT_FALSE(place_model_lights(*unknown, Scene(many, *unknown), short_of));
    EXPECT_NE(short_of.text().find("desk and 969 more"), std::string::npos) << short_of.text();
}

TEST(GltfFeatures, LampsWithoutANameHaveTheirNodesAndWrongOnesAreErrors) {
    Glb unnamed = lamp_file({{"type", "point"}});
    EXPECT_EQ(loaded(unnamed, "point.glb").lights.at(0).name, "holder");
    const auto refused = [&](const Json& light, const std::string& why) {
        Diagnostics diagnostics;
        EXPECT_FALSE(load_gltf(lamp_file(light).save("wrong.glb"), diagnostics));
        EXPECT_NE(diagnostics.text().find(why), std::string::npos) << diagnostics.text();
    };
    refused({{"type", "area"}}, "light \"holder\": no type is named \"area\"");
    refused({{"type", "point"}, {"intensity", -1}},
            "light \"holder\": intensity -1 is not a number from 0 on");
    refused({{"type", "point"}, {"color", {1, -1, 0}}}, "light \"holder\": color -1");
    refused({{"type", "point"}, {"extras", {{"radius", "big"}}}}, "the radius of its extras is not a number");
    refused({{"type", "spot"}, {"spot", {{"innerConeAngle", -1.0}, {"outerConeAngle", 0.5}}}}, "a cone from");
    refused({{"type", "spot"}, {"spot", {{"innerConeAngle", 0.0}, {"outerConeAngle", 0.0}}}}, "a cone from");
}

// What files have a little, or without meaning it, beyond what glTF allows.
TEST(GltfFeatures, LampsBeyondTheirBoundsAreTakenAtThem) {
    const auto lamp = [](const Json& light, std::vector<std::string>& warnings) {
        Glb glb = lamp_file(light);
        const Model model = loaded(glb, "bounds.glb");
        warnings = model.warnings;
        return model.lights.at(0);
    };
    const auto spot = [](double inner, double outer) {
        return Json{{"type", "spot"}, {"spot", {{"innerConeAngle", inner}, {"outerConeAngle", outer}}}};
    };
    std::vector<std::string> warnings;
    const ModelLight sharp = lamp(spot(0.4, 0.4), warnings);
    EXPECT_EQ(sharp.inner_deg, sharp.outer_deg);
    EXPECT_TRUE(warnings.empty());
    EXPECT_EQ(lamp(spot(0, 2), warnings).outer_deg, 90);
    EXPECT_EQ(warnings.size(), 1u);
    const ModelLight turned = lamp(spot(1, 0.5), warnings);
    EXPECT_EQ(turned.inner_deg, turned.outer_deg);
    EXPECT_EQ(warnings.size(), 1u);
    EXPECT_EQ(lamp({{"type", "point"}, {"range", 1e30}}, warnings).range, 0) << "it ends nowhere";
    EXPECT_TRUE(warnings.empty());
    EXPECT_EQ(lamp({{"type", "point"}, {"intensity", 1e30}}, warnings).intensity, 1e12);
    EXPECT_EQ(warnings.size(), 1u);
}

// Nodes may share a light, and lights a name: each is there, by a name of its own.
TEST(GltfFeatures, EachLampHasANameOfItsOwn) {
    Glb glb = lamp_file({{"type", "point"}, {"name", "Point"}});
    glb.json["extensions"]["KHR_lights_punctual"]["lights"].push_back({{"type", "point"}, {"name", "Point"}});
    glb.json["extensions"]["KHR_lights_punctual"]["lights"].push_back({{"type", "point"}, {"name", "hall"}});
    const auto node = [&](const char* name, int light, double x) {
        glb.json["nodes"].push_back(
            {{"translation", {x, 0, 0}}, {"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}});
        if (*name) glb.json["nodes"].back()["name"] = name;
        glb.json["scenes"][0]["nodes"].push_back(glb.json["nodes"].size() - 1);
    };
    node("stairs", 0, 10);
    node("hall", 0, 11);  // which is another's name
    node("", 1, 12);
    node("any", 2, 13);
    node("stairs", 0, 14);
    const Model model = loaded(glb, "shared.glb");
    std::vector<std::string> names;
    for (const ModelLight& light : model.lights) names.push_back(light.name);
    EXPECT_EQ(names, (std::vector<std::string>{"Point", "stairs", "Point_2", "Point_3", "hall", "Point_4"}));
    Diagnostics diagnostics;
    auto shot = parse_shot(make_model_shot(model, "a.glb", "", false).text, "a.shot.json", diagnostics);
    ASSERT_TRUE(shot && place_model_lights(*shot, Scene(model, *shot), diagnostics)) << diagnostics.text();
    std::multiset<double> x;
    for (const auto& [key, light] : shot->lights) x.insert(light.keys.at(0).position.x);
    EXPECT_EQ(x, (std::multiset<double>{1, 10, 11, 12, 13, 14}));
}

// Files and nodes are called by a light's key, whatever its name in the model is.
TEST(GltfFeatures, KeysOfLampsAreWords) {
    Glb glb = lamp_file({{"type", "point"}});
    Model model = loaded(glb, "keys.glb");
    const std::vector<std::string> names{"mA/Lamp", "mB/Lamp", "Point.001", "../../evil",
                                         "sun",     "\n",      " ",         "L\xc3\xa4mpe",
                                         "A b",     "a_B",     "7",         std::string(300, 'x')};
    const ModelLight lamp = model.lights.at(0);
    model.lights.clear();
    for (const std::string& name : names) {
        model.lights.push_back(lamp);
        model.lights.back().name = name;
    }
    const ModelShot made = make_model_shot(model, "keys.glb", "", false);
    Diagnostics diagnostics;
    auto shot = parse_shot(made.text, "keys.shot.json", diagnostics);
    ASSERT_TRUE(shot && place_model_lights(*shot, Scene(model, *shot), diagnostics)) << diagnostics.text();
    std::set<std::string> named;
    for (const auto& [key, light] : shot->lights) {
        EXPECT_TRUE(std::regex_match(key, std::regex("[a-z][a-z0-9_]{0,63}"))) << key;
        named.insert(light.in_model);
    }
    EXPECT_EQ(named, std::set<std::string>(names.begin(), names.end()));
    EXPECT_EQ(shot->lights.at("ma_lamp").in_model, "mA/Lamp");
    EXPECT_EQ(shot->lights.at("sun_2").in_model, "sun");
    EXPECT_TRUE(made.warnings.empty());

    while (model.lights.size() < 300) {
        model.lights.push_back(lamp);
        model.lights.back().name += std::to_string(model.lights.size());
    }
    const ModelShot many = make_model_shot(model, "keys.glb", "", false);
    EXPECT_TRUE(parse_shot(many.text, "keys.shot.json", diagnostics)) << diagnostics.text();
    EXPECT_EQ(many.warnings.count("lights"), 1u);
}

// Thousands of lights that point nowhere, in hundreds of frames, for each of which all nodes are put in
// place.
TEST(GltfFeatures, AShotLooksForItsSunInAllLightsAtOnce) {
    constexpr size_t lights = 4000;
    Glb glb = square_file();
    const int input = glb.floats({0, 10}, "SCALAR", 1), output = glb.floats({0, 0, 0, 0, 0, 0}, "VEC3", 3);
    glb.json["animations"] = {
        {{"samplers", {{{"input", input}, {"output", output}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
    glb.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}};
    glb.json["extensions"] = {{"KHR_lights_punctual", {{"lights", {{{"type", "directional"}}}}}}};
    const Json nowhere = {
        {"scale", {0, 0, 0}}, {"camera", 0}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}};
    for (size_t i = 1; i <= lights; ++i) {
        glb.json["nodes"].push_back(nowhere);
        glb.json["scenes"][0]["nodes"].push_back(i);
    }
    const Model model = loaded(glb, "nowhere.glb");
    ASSERT_EQ(model.suns.size(), lights);
    const auto start = std::chrono::steady_clock::now();
    const ModelShot made = make_model_shot(model, "nowhere.glb", "", false);
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
    EXPECT_EQ(made.warnings.count("sun"), lights);
    EXPECT_EQ(made.warnings.count("camera"), lights);
}

// A pose takes no time; what moves is played, and of several it is told which.
TEST(GltfFeatures, AShotPlaysTheFirstAnimationThatMoves) {
    Glb glb = square_file();
    const auto animation = [&](const char* name, const std::vector<float>& times) {
        std::vector<float> places(3 * times.size());
        const int input = glb.floats(times, "SCALAR", 1), output = glb.floats(places, "VEC3", 3);
        return Json{{"name", name},
                    {"samplers", {{{"input", input}, {"output", output}}}},
                    {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}};
    };
    glb.json["animations"] = {animation("TPose", {0})};
    const Json still = Json::parse(make_model_shot(loaded(glb, "pose.glb"), "pose.glb", "", false).text);
    EXPECT_FALSE(still.contains("animation"));
    EXPECT_EQ(still["frames"], 16);
    glb.json["animations"].push_back(animation("Walk", {0, 1}));
    const ModelShot made = make_model_shot(loaded(glb, "walk.glb"), "walk.glb", "", false);
    EXPECT_EQ(Json::parse(made.text)["animation"], 1);
    EXPECT_EQ(Json::parse(made.text)["frames"], 31);
    ASSERT_EQ(made.warnings.count("animation"), 1u);
    EXPECT_EQ(made.warnings.find("animation")->second, "of 2 animations \"Walk\" is played");
}

// The model's own camera goes as its node does in the animation and at the frames per second of the shot that
// it completes, and stands where that plays none.
TEST(GltfFeatures, AShotIsCompletedAsItIsPlayed) {
    Glb glb = square_file();
    const int input = glb.floats({0, 2}, "SCALAR", 1), output = glb.floats({0, 0, 3, 0, 0, 9}, "VEC3", 3);
    glb.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}};
    glb.json["nodes"].push_back({{"camera", 0}, {"translation", {0, 0, 3}}});
    glb.json["scenes"] = {{{"nodes", {0, 1}}}};
    glb.json["animations"] = {
        {{"samplers", {{{"input", input}, {"output", output}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "translation"}}}}}}}};
    const fs::path model = glb.save("played.glb"), file = fs::path(model).replace_extension(".shot.json");
    const auto completed = [&](const std::string& played) {
        std::ofstream(file) << R"({"penumbra_shot": 1, "scene": "played.glb", "frames": 121)" << played
                            << "}";
        Diagnostics diagnostics;
        auto shot = read_completed_shot(file, diagnostics);
        EXPECT_TRUE(shot) << diagnostics.text();
        return shot.value_or(Shot{});
    };
    const Shot at_60 = completed(R"(, "animation": 0)");
    EXPECT_NEAR(camera_at(at_60, 60, 1).position[2], 6, 1e-3);
    EXPECT_NEAR(camera_at(at_60, 120, 1).position[2], 9, 1e-3);
    EXPECT_NEAR(camera_at(completed(R"(, "animation": 0, "fps": 120)"), 120, 1).position[2], 6, 1e-3);
    EXPECT_EQ(completed("").camera.size(), 1u);
    EXPECT_EQ(completed(R"(, "animation": "none such")").camera.size(), 1u) << "told where it is opened";
}

TEST(GltfFeatures, AShotTellsWhatIsNotDrawn) {
    Glb glb = square_file();
    glb.json["materials"] = {
        {{"alphaMode", "BLEND"}, {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.5}}}}}};
    primitive(glb)["material"] = 0;
    glb.json["nodes"] = {{{"mesh", 0}, {"name", "glass"}}};
    const ModelShot made = make_model_shot(loaded(glb, "glass.glb"), "glass.glb", "", false);
    ASSERT_EQ(made.warnings.count("scene"), 1u);
    EXPECT_EQ(made.warnings.find("scene")->second,
              "2 triangles of \"glass\" let light through and are not drawn");
    glb.json["accessors"][primitive(glb)["indices"].get<size_t>()]["count"] = 3;
    const ModelShot one = make_model_shot(loaded(glb, "pane.glb"), "pane.glb", "", false);
    ASSERT_EQ(one.warnings.count("scene"), 1u);
    EXPECT_EQ(one.warnings.find("scene")->second,
              "1 triangle of \"glass\" lets light through and is not drawn");
}

// A node that turns takes the sun along; what points nowhere is neither sun nor camera, and that is told.
TEST(GltfFeatures, AShotsSunAndCameraGoWithTheirNodes) {
    Glb glb = square_file();
    const float h = std::sqrt(0.5f);
    const int input = glb.floats({1, 2}, "SCALAR", 1),
              turned = glb.floats({0, 0, 0, 1, -h, 0, 0, h}, "VEC4", 4);
    glb.json["animations"] = {
        {{"samplers", {{{"input", input}, {"output", turned}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 2}, {"path", "rotation"}}}}}}}};
    glb.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}};
    glb.json["extensions"] = {
        {"KHR_lights_punctual",
         {{"lights", {{{"type", "directional"}}, {{"type", "directional"}, {"intensity", 0}}}}}}};
    const auto light = [](int index) { return Json{{"KHR_lights_punctual", {{"light", index}}}}; };
    glb.json["nodes"] = {{{"mesh", 0}},
                         {{"name", "gone"}, {"scale", {0, 0, 0}}, {"camera", 0}, {"extensions", light(0)}},
                         {{"name", "noon"}, {"extensions", light(0)}},
                         {{"name", "off"}, {"extensions", light(1)}},
                         {{"camera", 0}, {"translation", {5e5, 50.25, 5.4e6}}}};
    glb.json["scenes"] = {{{"nodes", {0, 3, 1, 2, 4}}}};
    const Model model = loaded(glb, "turns.glb");
    ASSERT_EQ(model.suns.size(), 2u) << "one is off";
    EXPECT_EQ(model.warnings.size(), 1u);
    const ModelShot made = make_model_shot(model, "turns.glb", "", false);
    EXPECT_EQ(made.warnings.count("camera"), 1u);
    EXPECT_EQ(made.warnings.count("sun"), 2u) << "it points nowhere; the second of two is the sun";
    Diagnostics diagnostics;
    const auto shot = parse_shot(made.text, "turns.shot.json", diagnostics);
    ASSERT_TRUE(shot) << diagnostics.text();
    EXPECT_NEAR(sun_at(*shot, 15).to_sun.z, 1, 1e-9) << "before the first key";
    EXPECT_NEAR(sun_at(*shot, 45).to_sun.y, std::sqrt(0.5), 1e-4);
    EXPECT_NEAR(sun_at(*shot, 60).to_sun.y, 1, 1e-9);
    EXPECT_LT(shot->sun.size(), 40u) << "keys that say nothing are left out";
    ASSERT_EQ(shot->camera.size(), 1u);
    const glm::dvec3 ahead = shot->camera[0].target - shot->camera[0].position;
    EXPECT_NEAR(glm::length(glm::normalize(ahead) - glm::dvec3(0, 0, -1)), 0, 1e-9) << "as far off as it is";
}

TEST(GltfFeatures, AShotTakesTheFilesCameraAndSun) {
    Glb glb = square_file();
    glb.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.25}}}}};
    const double h = std::sqrt(0.5);
    glb.json["extensionsUsed"] = {"KHR_lights_punctual"};
    glb.json["extensions"] = {
        {"KHR_lights_punctual", {{"lights", {{{"type", "directional"}}, {{"type", "point"}}}}}}};
    glb.json["nodes"].push_back({{"camera", 0}, {"translation", {1, 2, 8}}});
    glb.json["nodes"].push_back(
        {{"rotation", {-h, 0, 0, h}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    glb.json["nodes"].push_back({{"extensions", {{"KHR_lights_punctual", {{"light", 1}}}}}});
    glb.json["scenes"] = {{{"nodes", {0, 1, 2, 3}}}};
    const Model model = loaded(glb, "camera.glb");
    EXPECT_EQ(model.warnings, std::vector<std::string>{});
    Diagnostics diagnostics;
    const auto shot =
        parse_shot(make_model_shot(model, "camera.glb", "", false).text, "camera.shot.json", diagnostics);
    ASSERT_TRUE(shot) << diagnostics.text();
    EXPECT_NEAR(shot->vertical_fov_deg, glm::degrees(0.5), 1e-3);
    EXPECT_EQ(shot->near, 0.25);
    EXPECT_NEAR(glm::length(shot->camera[0].position - glm::dvec3(1, 2, 8)), 0, 1e-4);
    const glm::dvec3 to_sun = sun_at(*shot, 0).to_sun;  // it shines along its -z, which the turn points down
    EXPECT_NEAR(to_sun.y, 1, 1e-4);
}

}  // namespace
}  // namespace penumbra
