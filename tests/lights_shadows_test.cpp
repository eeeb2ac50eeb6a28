// SPDX-License-Identifier: MIT
// lights_shadows.json through the program: light_shadows.json for each light of a shot, in one plan. With a
// budget for each it is that to the bit; what one for all gives is in lights_budget_test.cpp.
#include <fmt/format.h>

#include <map>

#include "tests/cli_run.h"
#include "tests/gpu_test.h"

namespace penumbra::test {
namespace {

class LightsShadows : public Cli {
  protected:
    static constexpr const char* shot =
        " --shot scenes/lights/interior.shot.json --size 64x36 --frames 0..2 --every 2 ";
    void render(const std::string& arguments, const std::string& folder) const {
        const Result result =
            run("render " + arguments + shot + "--out '" + (folder_ / folder).string() + "'");
        ASSERT_EQ(result.code, 0) << result.err;
    }
};

TEST_F(LightsShadows, EachMaskIsTheOneOfItsLightAlone) {
    render(
        "lights_shadows --set nodes.pilots.in.pooled=null --set nodes.allot.in.pooled=null "
        "--set nodes.survey.in.tile_lux=null --set nodes.survey.in.lux_of_all=null",
        "all");
    for (const std::string light : {"bulb", "panel"}) {  // one that moves, one that does not
        render("light_shadows --no-jitter --light " + light, light);
        const std::string alone = read_file(folder_ / light / "visibility.0002.exr");
        EXPECT_GT(alone.size(), 500u);
        EXPECT_EQ(read_file(folder_ / "all" / ("visibility_" + light + ".0002.exr")), alone) << light;
    }
    render("lights_shadows --light tube", "tube");
    EXPECT_TRUE(fs::exists(folder_ / "tube/visibility_tube.0002.exr"));
    EXPECT_FALSE(fs::exists(folder_ / "tube/visibility_bulb.0002.exr"));
}

// Boxes around what tiles show and places of the past are the same for all lights: spots and spheres that end
// before most of what is seen, a camera and a car that move; a panel, a tube and bulbs in a room.
TEST_F(LightsShadows, WhatTheyHaveInCommonChangesNoBit) {
    const auto written = [&](const std::string& settings, const std::string& of, const std::string& folder) {
        const Result result = run("render lights_shadows" + settings + " --shot lights/" + of +
                                  " --size 160x90 --frames 0..5 --every 5 --out '" + in(folder) + "'");
        EXPECT_EQ(result.code, 0) << result.err;
        std::map<std::string, std::string> masks;
        for (const auto& entry : fs::directory_iterator(folder_ / folder))
            if (const std::string name = entry.path().filename(); name.starts_with("visibility_"))
                masks[name] = read_file(entry.path());
        return masks;
    };
    const std::string none =
        " --set nodes.classify.in.tile_boxes=null --set nodes.survey.in.nearest_places=null"
        " --set nodes.worth.in.nearest_places=null";
    for (const auto& [name, lights] : {std::pair{"street", 12u}, {"interior", 4u}}) {
        const std::string of = name;
        const auto together = written("", of, of), apart = written(none, of, of + "_apart");
        EXPECT_EQ(together.size(), 4 * lights) << "two frames of each, EXR and PNG";
        EXPECT_EQ(together, apart) << of;
    }
}

// Where its members are lights of the shot, it is of these, and their facts hold. Those of the pipeline that
// ships only stand for some.
TEST_F(LightsShadows, APipelineMayNameItsLights) {
    const std::string two = R"({ "extends": ")" PENUMBRA_SOURCE_DIR R"(/pipelines/lights_shadows.json",
        "instances": { "tube": { "of": "lights" },
                       "panel": { "of": "lights", "facts": { "sun_disc": false } } } })";
    render("'" + file("two.json", two) + "'", "two");
    EXPECT_TRUE(fs::exists(folder_ / "two/visibility_tube.0002.exr"));
    EXPECT_TRUE(fs::exists(folder_ / "two/visibility_panel.0002.exr"));
    EXPECT_FALSE(fs::exists(folder_ / "two/visibility_bulb.0002.exr"));
    EXPECT_NE(read_file(folder_ / "two/report.json").find("\"hard_panel\""), std::string::npos)
        << "its disc is none";
    // What the last light takes in memory is not said then, since the pipeline is for these alone.
    expect(
        run("bench '" + in("two.json") + "' --shots lights/interior --sizes 32x32 --rounds 1 --frames 0..1"),
        0, "");
    expect(run("render '" + in("two.json") + "' --light bulb" + shot + "--out '" + in("none") + "'"), 2,
           "--light: \"bulb\" is none of the lights that \"lights_shadows\" names");
    expect(run("render lights_shadows --set 'instances={\"pannel\":{\"of\":\"lights\"},"
               "\"tube\":{\"of\":\"lights\"}}'" +
               std::string(shot) + "--out '" + in("mixed") + "'"),
           2,
           "instances.pannel: others here are lights of the shot, and this is none; did you mean \"panel\"?");
}

// The sum of the masks times what each light shines, as `illuminate` has it, on what is drawn.
TEST_F(LightsShadows, ThereIsAPictureUnderAllOfThem) {
    render("lights_shadows --set 'outputs=[\"visibility\",\"lit\"]'", "all");
    EXPECT_GT(read_file(folder_ / "all/lit.0002.exr").size(), 500u);
    EXPECT_TRUE(fs::exists(folder_ / "all/visibility_panel.0002.exr"));
}

TEST_F(LightsShadows, ThePlanSaysWhatTheLastOfThemTakes) {
    const auto number_behind = [](const Result& result, const std::string& words) {
        const size_t at = result.out.find(words);
        EXPECT_NE(at, std::string::npos) << result.out << result.err;
        return at == std::string::npos ? 0 : std::stod(result.out.substr(at + words.size()));
    };
    const Result two = run("plan lights_shadows --size 1920x1080");
    const Result one = run("plan lights_shadows --size 1920x1080 --set instances.second=null");
    const std::string all = "bytes per pixel ";
    EXPECT_NEAR(number_behind(two, ", for the last of 2 lights "),
                number_behind(two, all) - number_behind(one, all), .011);
    EXPECT_EQ(one.out.find("for the last"), std::string::npos);
}

// The plan without the last light may be none: that is said, and is no error of the plan that was asked for.
TEST_F(LightsShadows, ThePlanSaysWhereItDoesNotKnow) {
    const Result result = run("plan lights_shadows --size 640x360 --set 'outputs=[\"visibility_second\"]'");
    EXPECT_EQ(result.code, 0);
    EXPECT_EQ(result.err, "");
    EXPECT_NE(result.out.find(", for the last of 2 lights not known"), std::string::npos) << result.out;
}

// Inputs are named after lights, and "light_prev" is one that the host knows under that name, too.
TEST_F(LightsShadows, ALightMayHaveAnyName) {
    for (const std::string name : {"prev", "bulb"}) {
        const std::string named = file(
            name + ".shot.json",
            R"({"penumbra_shot": 1, "scene": ")" PENUMBRA_SOURCE_DIR
            R"(/scenes/interior.glb", "size": [64, 36], "frames": 1,
        "camera": {"vertical_fov_deg": 60, "near": 0.1, "keys": [{"frame": 0, "position": [0, 1, 3], "target": [0, 1, 0]}]},
        "lights": {")" +
                name +
                R"(": {"kind": "sphere", "radius": 0.2, "luminance": 5, "keys": [{"frame": 0, "position": [0, 2, 0]}]}}})");
        const Result result = run("render lights_shadows --frames 0..0 --shot '" + named + "' --out '" +
                                  (folder_ / name).string() + "'");
        ASSERT_EQ(result.code, 0) << result.err;
    }
    EXPECT_EQ(read_file(folder_ / "prev/visibility_prev.0000.exr"),
              read_file(folder_ / "bulb/visibility_bulb.0000.exr"));
    EXPECT_GT(read_file(folder_ / "bulb/visibility_bulb.0000.exr").size(), 500u);
}

// One that is on in some frame has its passes in all of them, and if all are off each has.
TEST_F(LightsShadows, ALightThatIsNeverOnHasNoPass) {
    const auto members = [&](const std::string& name, const char* bulb, const char* tube) {
        const std::string own = file(
            name + ".shot.json",
            fmt::format(
                R"({{"penumbra_shot": 1, "scene": "{}/scenes/interior.glb", "size": [64, 36], "frames": 2,
        "camera": {{"vertical_fov_deg": 60, "near": 0.1, "keys": [{{"frame": 0, "position": [0, 1, 3], "target": [0, 1, 0]}}]}},
        "lights": {{
          "bulb": {{"kind": "sphere", "radius": 0.2, "luminance": 5, "keys": [{}]}},
          "tube": {{"kind": "tube", "length": 1, "radius": 0.02, "luminance": {}, "keys": [{{"frame": 0, "position": [0, 2, 0]}}]}}}}}})",
                PENUMBRA_SOURCE_DIR, bulb, tube));
        const Result result =
            run("render lights_shadows --frames 0..0 --shot '" + own + "' --out '" + in(name) + "'");
        EXPECT_EQ(result.code, 0) << result.err;
        std::string there;
        for (const std::string light : {"bulb", "tube"})
            if (fs::exists(folder_ / name / ("visibility_" + light + ".0000.exr"))) there += light + " ";
        return there;
    };
    const char *on = R"({"frame": 0, "position": [0, 1, 0]})",
               *off = R"({"frame": 0, "position": [0, 1, 0], "power": 0})",
               *later =
                   R"({"frame": 0, "position": [0, 1, 0], "power": 0}, {"frame": 1, "position": [0, 1, 0]})";
    EXPECT_EQ(members("on", on, "5"), "bulb tube ");
    EXPECT_EQ(members("off", off, "5"), "tube ");
    EXPECT_EQ(members("later", later, "5"), "bulb tube ");
    EXPECT_EQ(members("dark", on, "0"), "bulb ");
    EXPECT_EQ(members("all", off, "0"), "bulb tube ");
}

TEST_F(LightsShadows, ALightIsOfVisibilityAlone) {
    const std::string out = " --out '" + (folder_ / "written").string() + "'";
    const std::string said = "--light: is of visibility alone, and --signal asks for specular";
    expect(run("report --signal specular --light panel --shots lights/interior" + out), 2, said);
    expect(run("reference --signal specular --light panel --shot lights/interior" + out), 2, said);
    EXPECT_FALSE(fs::exists(folder_ / "written"));
}

// Of a pipeline for several lights the frames that are there are those of the light's mask.
TEST_F(LightsShadows, ATruthIsLikeTheMaskOfItsLight) {
    render("lights --no-jitter", "all");
    const std::string like = "reference --like '" + (folder_ / "all").string() + "' --rays 16 --out '" +
                             (folder_ / "truth").string() + "' --light ";
    expect(run(like + "bulbe"), 2, "no masks.bulbe.NNNN.exr in here");
    expect(run("reference --like '" + (folder_ / "all").string() + "' --out '" +
               (folder_ / "truth").string() + "'"),
           2, "--light: there is a mask of each of ");
    EXPECT_FALSE(fs::exists(folder_ / "truth"));
    expect(run(like + "bulb"), 0, "");
    EXPECT_TRUE(fs::exists(folder_ / "truth/visibility.0002.exr"));
}

// A folder says whose mask it has, so that nobody has to say it twice or can say something else.
TEST_F(LightsShadows, ATruthIsOfTheLightThatWasRendered) {
    render("light_shadows --no-jitter --light panel", "panel");
    const auto truth = [&](const std::string& folder, const std::string& light) {
        return run("reference --like '" + (folder_ / "panel").string() + "' --rays 16 --out '" +
                   (folder_ / folder).string() + "'" + light);
    };
    expect(truth("known", ""), 0, "");
    expect(truth("told", " --light panel"), 0, "");
    const std::string known = read_file(folder_ / "known/visibility.0002.exr");
    EXPECT_GT(known.size(), 500u);
    EXPECT_EQ(known, read_file(folder_ / "told/visibility.0002.exr"));
    expect(truth("other", " --light bulb"), 2, "--light: visibility in here is of \"panel\"");
    EXPECT_FALSE(fs::exists(folder_ / "other"));
}

TEST_F(LightsShadows, AShotMustHaveLightsThatNodesCanBeNamedAfter) {
    expect(run("render lights_shadows --shot cards"), 2,
           "the pipeline takes lights that are near, and the shot has none");
    const std::string named =
        file("named.shot.json", R"({"penumbra_shot": 1, "scene": ")" PENUMBRA_SOURCE_DIR
                                R"(/scenes/lights/interior.glb", "size": [8, 8], "frames": 1,
        "camera": {"vertical_fov_deg": 60, "near": 0.1, "keys": [{"frame": 0, "position": [0, 1, 3], "target": [0, 1, 0]}]},
        "lights": {"Desk lamp": {"kind": "point", "intensity": 5, "keys": [{"frame": 0, "position": [0, 2, 0]}]}}})");
    expect(run("render lights_shadows --shot '" + named + "'"), 2,
           "lights.Desk lamp: \"lights_shadows\" has nodes");
}

}  // namespace
}  // namespace penumbra::test
