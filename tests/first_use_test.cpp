// SPDX-License-Identifier: MIT
// What somebody types on the first day: names instead of paths, a model instead of a shot, and README's own
// sequence.
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "app/shipped_files.h"
#include "host/images/image_decode.h"
#include "host/images/image_file.h"
#include "tests/cli_run.h"
#include "tests/gltf_glb.h"

namespace penumbra::test {
namespace {

using Json = nlohmann::json;

class FirstUse : public Cli {};

// A frame is rasterised off its pixels' centres where anti-aliasing asks for it. Judged by the truth of the
// centres, a pipeline as good as this one has the error of a few rays.
TEST_F(FirstUse, RenderReferenceCompareAgreeOnTheirPoints) {
    const std::string small = " --size 160x90 --frames 3";
    ASSERT_EQ(run("render hybrid_shadows --shot colonnade --out " + in("image") + small).code, 0);
    const Json report = Json::parse(read_file(folder_ / "image/report.json"));
    const Json jitter = report["by_frame"][3]["jitter"];
    EXPECT_GT(std::abs(jitter[0].get<double>()) * 160, 0.1);
    ASSERT_EQ(run("reference --like " + in("image") + " --rays 256 --out " + in("truth")).code, 0);
    const Result good = run("compare " + in("image") + " " + in("truth") + " --json");
    ASSERT_EQ(good.code, 0) << good.err;
    EXPECT_LT(Json::parse(good.out)["rmse"]["penumbra"].get<double>(), 0.05);

    ASSERT_EQ(run("reference --shot colonnade --rays 64 --out " + in("centres") + small).code, 0);
    const Result refused = run("compare " + in("image") + " " + in("centres"));
    expect(refused, 2, "reference --like");
    ASSERT_EQ(run("render hybrid_shadows --no-jitter --shot colonnade --out " + in("still") + small).code, 0);
    EXPECT_EQ(run("compare " + in("still") + " " + in("centres")).code, 0);
    expect(run("compare " + in("still") + " " + in("truth")), 2, "pixel centres");
    // Further frames of the same truth; of another one, alone.
    const auto frames_of = [&](const std::string& rays) {
        EXPECT_EQ(
            run("reference --shot colonnade --size 160x90 --frames 4 --out " + in("centres") + rays).code, 0);
        return Json::parse(read_file(folder_ / "centres/reference.json"))["frames"].size();
    };
    EXPECT_EQ(frames_of(" --rays 64"), 2u);
    EXPECT_EQ(frames_of(" --rays 100"), 1u);
}

TEST_F(FirstUse, ReferenceLikeAFolderTakesItsFrames) {
    ASSERT_EQ(run("render raw --shot colonnade --size 48x32 --frames 1..5 --every 2 --out " + in("a")).code,
              0);
    ASSERT_EQ(run("reference --like " + in("a") + " --rays 16 --out " + in("t")).code, 0);
    for (int frame = 0; frame < 6; ++frame)
        EXPECT_EQ(fs::exists(folder_ / "t" / ("visibility.000" + std::to_string(frame) + ".exr")),
                  frame % 2 == 1);
    // The truth of radiance beside it leaves what is said of its frames, however the shot's path is spelled.
    const std::string frames = read_file(folder_ / "t/reference.json");
    expect(run("reference --shot scenes/colonnade.shot.json --size 48x32 --frames 1 --rays 16 "
               "--signal specular --out " +
               in("t")),
           0, "");
    EXPECT_TRUE(fs::exists(folder_ / "t/specular.0001.exr"));
    EXPECT_EQ(read_file(folder_ / "t/reference.json"), frames);
    expect(run("reference --like " + in("a") + " --shot colonnade --out " + in("u")), 2, "--like");
    expect(run("reference --like " + folder_.string() + " --out " + in("u")), 2, "report.json");
    expect(run("reference --like " + in("a") + " --frames 2 --out " + in("u")), 2, "--frames");
    for (const char* frame : {"1", "3", "5"})
        fs::rename(in("a") + "/visibility.000" + frame + ".exr", in("a") + "/specular.000" + frame + ".exr");
    expect(run("reference --like " + in("a") + " --out " + in("u")), 2,
           "--signal: no visibility.NNNN.exr in here, but lit, specular: the truth of what?");
    EXPECT_FALSE(fs::exists(in("u")));
    expect(run("reference --like " + in("a") + " --signal specular --rays 16 --out " + in("u")), 0, "");
    EXPECT_TRUE(fs::exists(folder_ / "u/specular.0005.exr"));
    EXPECT_FALSE(fs::exists(folder_ / "u/specular.0004.exr"));
    const Json said = Json::parse(read_file(folder_ / "u/reference.json"));
    EXPECT_EQ(fs::path(said["shot"].get<std::string>()).filename(), "colonnade.shot.json");
}

TEST_F(FirstUse, NamesOfShippedFilesAreLookedUp) {
    EXPECT_EQ(run("check raw").code, 0);
    EXPECT_EQ(run("plan fidelityfx --size 64x64").code, 0);
    expect(run("check hybrid_shadow"), 2, "did you mean \"hybrid_shadows\"?");
    expect(run("check sky.json"), 2, "sky.json: no such file, and no pipeline of that name is shipped\n");
    expect(run("check hybrid"), 2, "; there are hybrid_cascades, ");
    EXPECT_EQ(run("check hybrid").err.find("covered"), std::string::npos) << "names that hold the word";
    expect(run("render raw --shot lamp --capture depht --out " + in("o")), 2, "did you mean \"depth\"?");
    expect(run("render raw --shot colonade --out " + in("o")), 2, "did you mean \"colonnade\"?");
    expect(run("render raw one_ray --shot colonnade --out " + in("o")), 2, "one pipeline");
    EXPECT_FALSE(fs::exists(folder_ / "o"));
}

// As the output of `render raw --out raw` is.
TEST_F(FirstUse, AFolderOfAPipelinesNameDoesNotHideIt) {
    const fs::path before = fs::current_path();
    fs::create_directory(folder_ / "raw");
    fs::current_path(folder_);
    Diagnostics diagnostics;
    const auto found = shipped_file("raw", PENUMBRA_SOURCE_DIR, shipped_pipelines, diagnostics);
    fs::current_path(before);
    ASSERT_TRUE(found) << diagnostics.text();
    EXPECT_EQ(found->filename(), "raw.json");
}

// Its sessions run the judged frame once more, for the pictures.
TEST_F(FirstUse, AReportIsMeasuredWhereTheCameraMoves) {
    expect(run("report --front --rounds 1 --rays 16 --size 48x27 --shots colonnade --pipelines raw --out " +
               in("r")),
           0, "");
    EXPECT_TRUE(fs::exists(folder_ / "r/index.html"));
}

TEST_F(FirstUse, FramesBeyondAShotAreRefused) {
    expect(run("render raw --shot colonnade --frames 5..99 --out " + in("o")), 2, "whose frames are 0..63");
    expect(run("reference --shot colonnade --frames 64 --out " + in("o")), 2, "whose frames are 0..63");
    EXPECT_FALSE(fs::exists(folder_ / "o"));
}

// The shot that was made up is written beside the picture, and renders the same picture by itself.
TEST_F(FirstUse, AModelIsEnough) {
    const std::string model = "scenes/lamp.glb";
    const Result first = run("render " + model + " raw --ground --size 96x54 --out " + in("a"));
    ASSERT_EQ(first.code, 0) << first.err;
    EXPECT_NE(first.err.find("triangles, x "), std::string::npos) << "its bounds are told: " << first.err;
    const Json report = Json::parse(read_file(folder_ / "a/report.json"));
    EXPECT_EQ(report["frames"], (Json{15, 15})) << "a still model is one picture";
    EXPECT_GT(report["counts"]["receivers"].get<int>(), 96 * 54 / 2);
    ASSERT_EQ(
        run("render raw --shot " + in("a/lamp.shot.json") + " --size 96x54 --frames 15 --out " + in("b"))
            .code,
        0);
    EXPECT_EQ(read_file(folder_ / "a/visibility.0015.exr"), read_file(folder_ / "b/visibility.0015.exr"));

    const Result shot = run("shot " + model + " --ground --out " + in("c/mine.shot.json"));
    ASSERT_EQ(shot.code, 0) << shot.err;
    EXPECT_NE(read_file(in("c/mine.shot.json")).find("\n        \"position\": ["), std::string::npos)
        << "a vector is a line";
    ASSERT_EQ(
        run("render raw --shot " + in("c/mine.shot.json") + " --size 96x54 --frames 15 --out " + in("d"))
            .code,
        0);
    EXPECT_EQ(read_file(folder_ / "a/visibility.0015.exr"), read_file(folder_ / "d/visibility.0015.exr"));
    expect(run("shot " + model + " --out " + in("c/mine.shot.json")), 2, "is there already");
    expect(run("render raw --shot colonnade --ground --out " + in("e")), 2, "--ground");
    expect(run("render raw --out " + in("e")), 2, "give a model, or a shot");
    expect(run("render raw " + model + " --shot lamp --out " + in("e")), 2, "one of the two");
}

// All frames of a model's own animation are written, though neither camera nor objects of the shot have keys.
TEST_F(FirstUse, AnAnimatedModelIsAllItsFrames) {
    Glb glb = square_file();
    const int input = glb.floats({0, 2}, "SCALAR", 1), output = glb.floats({0, 0, 0, 0.5, 0, 0}, "VEC3", 3);
    glb.json["animations"] = {
        {{"samplers", {{{"input", input}, {"output", output}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
    const Result moving = run("render raw --size 48x32 --capture depth --out " + in("a") + " " +
                              glb.save("slides.glb").string());
    ASSERT_EQ(moving.code, 0) << moving.err;
    const Json shot = Json::parse(read_file(in("a/slides.shot.json")));
    EXPECT_GT(shot["frames"], 16);
    EXPECT_EQ(Json::parse(read_file(in("a/report.json")))["frames"], (Json{0, int(shot["frames"]) - 1}));
    EXPECT_FALSE(read_file(in("a/depth.0001.exr")) == read_file(in("a/depth.0031.exr")));
}

// What a name can be: avatars are .glb files under another ending, a shot needs no --shot, shots in folders
// are known with them, and whatever is none of these is told what it could have been.
TEST_F(FirstUse, FilesAreTakenForWhatTheyAre) {
    const std::string small = " --size 48x32 --frames 0 --out " + in("o");
    fs::copy_file(PENUMBRA_SOURCE_DIR "/scenes/lamp.glb", folder_ / "avatar.vrm");
    const Result avatar = run("render raw " + in("avatar.vrm") + small);
    expect(avatar, 0, in("avatar.vrm") + ": 5");
    ASSERT_EQ(run("render raw scenes/lamp.shot.json" + small).code, 0);
    ASSERT_EQ(run("render raw lamp" + small).code, 0) << "a shipped shot needs no --shot either";
    ASSERT_EQ(run("render light --light panel --shot lights/interior" + small).code, 0);
    fs::remove_all(folder_ / "o");
    expect(run("render README.md" + small), 2, "README.md: is neither a pipeline or a shot");
    const Result unknown = run("render nosuch" + small);
    expect(unknown, 2, "nosuch: no such file, and no pipeline of that name is shipped; there are ");
    EXPECT_EQ(unknown.err.find("give a model"), std::string::npos)
        << "of one mistake one line: " << unknown.err;
    expect(run("render raw --shot interieur" + small), 2, "lights/interior");
    EXPECT_FALSE(fs::exists(folder_ / "o"));
    const std::string away = file("away.gltf", R"({"asset": {"version": 0.8}, "meshes": {}})");
    expect(run("render raw " + away + small), 2, away + ": is glTF 0.8; this program reads glTF 2.0");
    expect(run("render raw " + file("older.gltf", R"({"meshes": {}})") + small), 2, "is glTF 1.0 or older");
}

// A shot may leave its camera and its sun to the model, and mistakes in what it does say keep their places.
TEST_F(FirstUse, AShotWithoutACameraOrASunGetsTheModels) {
    const std::string scene = "\"scene\": \"" PENUMBRA_SOURCE_DIR "/scenes/lamp.glb\"";
    const std::string shot =
        file("bare.shot.json", "{ \"penumbra_shot\": 1, " + scene + ",\n  \"frames\": 16 }");
    ASSERT_EQ(run("render scenes/lamp.glb raw --size 96x54 --out " + in("a")).code, 0);
    const Result bare = run("render raw --shot " + shot + " --size 96x54 --frames 15 --out " + in("b"));
    ASSERT_EQ(bare.code, 0) << bare.err;
    EXPECT_EQ(read_file(folder_ / "a/visibility.0015.exr"), read_file(folder_ / "b/visibility.0015.exr"));
    ASSERT_EQ(run("reference --like " + in("b") + " --rays 16 --out " + in("t")).code, 0);

    const std::string own =
        file("own.shot.json",
             "{ \"penumbra_shot\": 1, " + scene +
                 ",\n  \"camera\": { \"keys\": [{ \"frame\": 0, \"position\": [0, 9, 1], \"target\": "
                 "[0, 0, 0] }] } }");
    ASSERT_EQ(run("render raw --shot " + own + " --size 96x54 --out " + in("c")).code, 0);
    EXPECT_NE(read_file(folder_ / "c/visibility.0000.exr"), read_file(folder_ / "b/visibility.0015.exr"));
    // Where there is no sun either, lamps light it: hybrid_shadows, which is taken else, knows none.
    const std::string lamps =
        file("lamps.shot.json", "{ \"penumbra_shot\": 1, " + scene +
                                    R"(, "lights": {"l": {"kind": "point", "intensity": 90,
                                    "keys": [{"frame": 0, "position": [0, 4, 4]}]}}})");
    expect(run("render --shot " + lamps + " --size 48x32 --out " + in("l")), 0, "");
    EXPECT_EQ(Json::parse(read_file(folder_ / "l/report.json"))["pipeline"], "lights");
    expect(run("render raw --shot " +
               file("wrong.shot.json", "{ \"penumbra_shot\": 1, " + scene + ",\n  \"frames\": -1 }") +
               " --out " + in("d")),
           2, "wrong.shot.json:2:13: frames");
    expect(run("render raw --shot " +
               file("gone.shot.json", R"({ "penumbra_shot": 1, "scene": "nowhere.glb" })") + " --out " +
               in("d")),
           2, "\"camera\" is missing");
}

// Models of a list stand where they say, and are moved and lit by names of their own. The naive join forgets
// that a second model's indices start anew: its nodes would hang below the first one's.
TEST_F(FirstUse, AShotMayShowSeveralModels) {
    const std::string lamp = PENUMBRA_SOURCE_DIR "/scenes/lamp.glb",
                      fan = PENUMBRA_SOURCE_DIR "/scenes/fan.glb";
    const std::string camera =
        R"("camera": {"keys": [{"frame": 0, "position": [0, 4, 14], "target": [0, 1, 0]}]},
        "sun": {"keys": [{"frame": 0, "to_sun": [0.4, 0.8, 0.3]}]})";
    const auto render = [&](const std::string& name, const std::string& scene, const std::string& more = "") {
        const std::string shot = file(
            name + ".shot.json", "{ \"penumbra_shot\": 1, \"scene\": " + scene + ", " + camera + more + " }");
        const Result r = run("render raw --no-jitter --shot " + shot +
                             " --size 96x54 --capture depth --out " + in(name.c_str()));
        EXPECT_EQ(r.code, 0) << r.err;
        return read_file(folder_ / name / "visibility.0000.exr") +
               read_file(folder_ / name / "depth.0000.exr");
    };
    const auto entry = [](const std::string& path, const std::string& more) {
        return "{ \"file\": \"" + path + "\"" + more + " }";
    };
    const auto differing = [&](const std::string& a, const std::string& b) {
        Diagnostics diagnostics;
        const auto one = read_exr(folder_ / a / "visibility.0000.exr", diagnostics),
                   other = read_exr(folder_ / b / "visibility.0000.exr", diagnostics);
        if (!one || !other) return size_t(-1);
        const auto &v = one->planes.front().values, &w = other->planes.front().values;
        size_t n = 0;
        for (size_t i = 0; i < v.size(); ++i) n += v[i] != w.at(i);
        return n;
    };
    const std::string alone = render("alone", "\"" + fan + "\"");
    EXPECT_TRUE(render("list", "[" + entry(fan, "") + "]") == alone);
    // Out of sight behind the camera, a second model changes nothing, whichever comes first; but of two
    // triangles that a ray meets within rounding of their edge, the tree's order chooses one.
    const std::string away = entry(lamp, R"(, "translation": [0, -1000, 1000], "scale": 0.01)");
    render("behind", "[" + entry(fan, "") + ", " + away + "]");
    render("before", "[" + away + ", " + entry(fan, "") + "]");
    for (const std::string name : {"behind", "before"}) {
        EXPECT_TRUE(read_file(folder_ / name / "depth.0000.exr") ==
                    read_file(folder_ / "alone/depth.0000.exr"));
        EXPECT_LE(differing(name, "alone"), 10u);
    }
    // A place in the list and a key of the node that stands above the model are the same.
    const std::string both =
        render("both", "[" + entry(fan, "") + ", " + entry(lamp, R"(, "name": "l", "translation": [1, 0.5, 2],
                                                    "rotation_deg": [10, 20, 30])") +
                           "]");
    EXPECT_FALSE(both == alone);
    EXPECT_TRUE(render("moved", "[" + entry(fan, "") + ", " + entry(lamp, R"(, "name": "l")") + "]",
                       R"(, "objects": {"l": {"keys": [{"frame": 0, "translation": [1, 0.5, 2],
                         "rotation_deg": [10, 20, 30]}]}})") == both);

    // What is said of a file is said once, however often it stands in the list.
    const std::string stick =
        file("stick.gltf", R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "scene": 0,
        "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"mode": 1, "attributes": {}}]}]})");
    const std::string sticks =
        file("sticks.shot.json", "{ \"penumbra_shot\": 1, \"scene\": [" + entry(fan, "") + ", " +
                                     entry(stick, R"(, "name": "a")") + ", " +
                                     entry(stick, R"(, "name": "b")") + "], " + camera + " }");
    const Result warned = run("render raw --shot " + sticks + " --size 96x54 --out " + in("s"));
    expect(warned, 0, "points and lines");
    EXPECT_EQ(warned.err.find("points and lines"), warned.err.rfind("points and lines")) << warned.err;

    // The command writes such a shot, which renders, and whose camera sees both.
    ASSERT_EQ(run("shot " + lamp + " " + fan + " " + fan + " --out " + in("made.shot.json")).code, 0);
    const Json made = Json::parse(read_file(folder_ / "made.shot.json"));
    ASSERT_EQ(made["scene"].size(), 3u);
    EXPECT_EQ(made["scene"][2]["name"], "fan 2");
    EXPECT_EQ(run("render raw --shot " + in("made.shot.json") + " --size 96x54 --out " + in("m")).code, 0);
    EXPECT_EQ(run("render raw " + lamp + " " + fan + " " + fan + " --size 96x54 --out " + in("n")).code, 0);
    EXPECT_EQ(read_file(folder_ / "m/visibility.0015.exr"), read_file(folder_ / "n/visibility.0015.exr"));
    expect(run("render raw --shot " +
               file("gone.shot.json", "{ \"penumbra_shot\": 1, \"scene\": [" + entry("nowhere.glb", "") +
                                          "], " + camera + " }") +
               " --out " + in("o")),
           2, "nowhere.glb");
}

// All of the model is in the picture: nothing of it at the border, and not a speck in the middle.
TEST_F(FirstUse, AModelIsFramed) {
    for (const char* name : {"lamp", "2CylinderEngine", "trees"}) {
        const std::string out = in(name);
        ASSERT_EQ(run(std::string("render scenes/") + name + ".glb raw --size 96x54 --out " + out).code, 0);
        const Json report = Json::parse(read_file(fs::path(out) / "report.json"));
        EXPECT_GT(report["counts"]["receivers"].get<int>(), 96 * 54 / 20) << name;
    }
}

// Of white in the sun nothing is left where a picture is cut off at 1, and where the sun stands at equal
// angles to two sides of a box the edge between them is gone.
TEST_F(FirstUse, TheSidesOfAWhiteBoxAreToldApart) {
    const auto box_of = [&](double half, const char* name, const std::string& more) {
        std::vector<float> at;
        for (int i = 0; i < 8; ++i)
            for (int axis = 0; axis < 3; ++axis) at.push_back(float(half * ((i >> axis & 1) ? 1 : -1)));
        Glb glb;
        const std::vector<uint16_t> sides{0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                          2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
        const int indices = glb.accessor(glb.view(sides.data(), 72), 5123, 36, "SCALAR");
        glb.json["meshes"] = {
            {{"primitives",
              {{{"attributes", {{"POSITION", glb.floats(at, "VEC3", 3)}}}, {"indices", indices}}}}}};
        glb.json["nodes"] = {{{"mesh", 0}}};
        if (!more.empty()) glb.json.merge_patch(Json::parse(more));
        return glb.save(name).string();
    };
    ASSERT_EQ(run("render " + box_of(1, "box.glb", "") + " --size 96x54 --out " + in("a")).code, 0);
    const std::string png = read_file(folder_ / "a/color.0015.png");
    const RgbaImage picture = decode_png(std::as_bytes(std::span(png)), 1 << 20);
    std::map<int, int> greys;  // to eight levels
    for (size_t p = 0; p < picture.rgba.size(); p += 4)
        if (std::abs(picture.rgba[p] - picture.rgba[p + 2]) < 24) ++greys[picture.rgba[p] / 8];
    std::erase_if(greys, [](const auto& grey) { return grey.second < 40; });
    EXPECT_GE(greys.size(), 3u);
    EXPECT_LT(greys.rbegin()->first, 31) << "none is cut off";

    for (const double half : {1e-14, 3e11})
        expect(run("render " + box_of(half, "far.glb", "") + " --out " + in("b")), 2, "scale the model");
    const std::string lamp = box_of(1, "lamp.glb", R"({"extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "name": "bulb"}]}},
        "nodes": [{"mesh": 0, "children": [1]}, {"translation": [2, 3, 2],
                   "extensions": {"KHR_lights_punctual": {"light": 0}}}]})");
    const std::string left_out = R"(the light of "bulb" is left out)";
    expect(run("render raw " + lamp + " --size 48x32 --out " + in("c")), 0, left_out);
    const Result lit = run("render lights " + lamp + " --size 48x32 --out " + in("d"));
    ASSERT_EQ(lit.code, 0) << lit.err;
    EXPECT_EQ(lit.err.find(left_out), std::string::npos);
    Json seven = {{"extensionsUsed", {"KHR_lights_punctual"}}};
    seven["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"name", "bulb"}}};
    seven["nodes"] = {{{"mesh", 0}, {"children", {1, 2, 3, 4, 5, 6, 7}}}};
    for (int i = 0; i < 7; ++i)
        seven["nodes"].push_back(
            {{"translation", {2, 3, i}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    expect(run("render raw " + box_of(1, "lamps.glb", seven.dump()) + " --size 48x32 --out " + in("e")), 0,
           "and 2 more is left out");
}

TEST_F(FirstUse, FilesWithoutAPictureAreRefused) {
    const std::string empty =
        file("empty.gltf", R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": []}], "scene": 0})");
    expect(run("render " + empty + " --out " + in("o")), 2, "there are no triangles");
    const std::string old =
        file("old.gltf", R"({"asset": {"version": "1.0"}, "scenes": {"s": {"nodes": ["n"]}},
        "scene": "s", "nodes": {"n": {"meshes": []}}})");
    expect(run("render " + old + " --out " + in("o")), 2, "glTF 1.0");
    EXPECT_FALSE(fs::exists(folder_ / "o"));
}

// Every command tells by example, and shells complete what is there.
TEST_F(FirstUse, HelpAndCompletionFollowTheCommands) {
    const Result all = run("--help");
    ASSERT_EQ(all.code, 0);
    const Result script = run("completion bash");
    ASSERT_EQ(script.code, 0) << script.err;
    size_t commands = 0;
    for (const char* name : {"render", "shot", "reference", "compare", "report", "plan", "check", "nodes",
                             "gates", "bench", "explain", "statics", "devices", "completion"}) {
        const Result help = run(std::string(name) + " --help");
        EXPECT_EQ(help.code, 0);
        EXPECT_NE(help.out.find("Examples:\n  penumbra " + std::string(name)), std::string::npos) << help.out;
        EXPECT_NE(all.out.find(std::string("  ") + name), std::string::npos) << name;
        EXPECT_NE(script.out.find(std::string("        ") + name + ") words="), std::string::npos) << name;
        ++commands;
    }
    EXPECT_EQ(commands, 14u);
    const std::string file_name = file("completion", script.out);
    const auto completed = [&](const std::string& line, const std::string& to) {
        const std::string ask =
            "bash -c 'source " + file_name + "; COMP_WORDS=(penumbra " + line +
            "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _penumbra; test \"${COMPREPLY[*]}\" = \"" + to + "\"'";
        EXPECT_EQ(std::system(ask.c_str()), 0) << line;
    };
    completed("reference --lik", "--like");
    completed("render many", "many_rays");
    completed("render raw --shot la", "lamp");
    completed("render --shot lights/int", "lights/interior");
    completed("render --shot lamp many", "many_rays");
    completed("view --ground many", "many_rays");
    completed("report --signal s", "specular");
    completed("render --out many", "");  // a folder, which the shell knows
    completed("devices many", "");
    expect(run("completion csh"), 2, "csh");
    const std::string zsh = run("completion zsh").out;
    EXPECT_LT(zsh.find("&& compinit -i"), zsh.find("&& bashcompinit"))
        << "without the first the second fails";
    EXPECT_EQ(run("completion fish").out.find("complete -c penumbra -n __fish_use_subcommand -a") ==
                  std::string::npos,
              false);
}

TEST_F(FirstUse, MisspeltWordsAreGuessed) {
    expect(run("rendr raw"), 2, "rendr: no such command; did you mean \"render\"?");
    expect(run("render raw --shot lamp --fremes 2"), 2, "did you mean \"--frames\"?");
    expect(run("plan raw --sise=64x64 --size 64x64"), 2, "did you mean \"--size\"?");
    expect(run("engine.glb"), 2, "penumbra render engine.glb");
    expect(run("qqqqqq"), 2, "--help");
    const Result nothing = run("");
    expect(nothing, 2, "write the shot that");
    expect(run("--vesion"), 2, "--help");
}

TEST_F(FirstUse, ErrorsAreColouredOnATerminalAlone) {
    EXPECT_EQ(run("check nosuch").err.find('\x1b'), std::string::npos);
    const std::string seen = in("seen");
    const auto on_terminal = [&](const std::string& before) {
        const std::string command = before +
                                    " script -qec \"'" PENUMBRA_PROGRAM "' check nosuch\" /dev/null >'" +
                                    seen + "' </dev/null";
        EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 2);
        return read_file(seen);
    };
    EXPECT_NE(on_terminal("").find("\x1b[31mnosuch"), std::string::npos) << read_file(seen);
    EXPECT_EQ(on_terminal("NO_COLOR=1").find('\x1b'), std::string::npos) << read_file(seen);
}

// Where the bar and a table are on one terminal, no row begins behind the bar.
TEST_F(FirstUse, RowsBeginOnALineOfTheirOwn) {
    for (const auto& [arguments, row] :
         {std::pair{"gates raw --parts still --seeds 1", "| 8 |"},
          {"gates raw_reflections --signal specular --parts furnace --seeds 1", "| white furnace"}}) {
        const std::string command = std::string("script -qec \"'" PENUMBRA_PROGRAM "' ") + arguments +
                                    "\" /dev/null >'" + in("seen") + "' </dev/null";
        ASSERT_EQ(WEXITSTATUS(std::system(command.c_str())), 0);
        const std::string seen = read_file(in("seen"));
        const size_t at = seen.find(row);
        ASSERT_NE(at, std::string::npos) << seen;
        EXPECT_EQ(seen.substr(at - 3, 3), "\x1b[K")
            << "nothing is left before it: " << seen.substr(at - 20, 40);
        EXPECT_NE(seen.rfind(" %", at), std::string::npos) << "how far it has come is told: " << seen;
    }
}

// What is being done and how far it has come is said on a terminal, also before the first frame.
TEST_F(FirstUse, ProgressIsShownOnATerminalAlone) {
    const std::string command = "render raw --shot lamp --size 48x32 --frames 2 --out " + in("a");
    EXPECT_EQ(run(command).err, "");
    const auto on_terminal = [&](const std::string& arguments) {
        const std::string line = "script -qec \"cd '" PENUMBRA_SOURCE_DIR "' && '" PENUMBRA_PROGRAM "' " +
                                 arguments + "\" /dev/null >'" + in("seen") + "' </dev/null";
        EXPECT_EQ(WEXITSTATUS(std::system(line.c_str())), 0);
        return read_file(in("seen"));
    };
    const std::string seen = on_terminal(command);
    size_t at = 0;
    for (const char* what : {"reading the model ...", "packing memory ...", "compiling shaders ...",
                             "building the tree of triangles ...", "building the tree of triangles ... 16 %",
                             "raw [", "] 100 %"}) {
        at = seen.find(what, at);
        EXPECT_NE(at, std::string::npos) << what << " in " << seen;
    }
    EXPECT_NE(on_terminal("view raw --shot lamp --size 48x32 --frames 2 --headless " + in("view.png"))
                  .find("building the tree of triangles ... 16 %"),
              std::string::npos);
    const std::string explained = on_terminal("explain --shot lamp --size 48x32 --out " + in("sun.svg"));
    for (const char* what : {"rendering the frame ...", "reading the scene back ...", "explain ["})
        EXPECT_NE(explained.find(what), std::string::npos) << what;
    ASSERT_EQ(run("reference --like " + in("a") + " --rays 16 --out " + in("t")).err, "");
    EXPECT_NE(on_terminal("compare " + in("a") + " " + in("t")).find("compare ["), std::string::npos);
}

}  // namespace
}  // namespace penumbra::test
