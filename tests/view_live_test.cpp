// SPDX-License-Identifier: MIT
// What `penumbra view` shows, without its window: pictures, splits, the truth as it converges, and files that
// change while it runs.
#include "tests/view_live.h"

#include <algorithm>
#include <cmath>

#include "app/outputs.h"
#include "host/models/glb_writer.h"
#include "tests/scene_file.h"
#include "tests/shot_run.h"

namespace penumbra::viewer {
namespace {

// Nobody has touched anything: the shot plays as `render` renders it.
TEST_F(ViewLive, UntouchedItIsTheShot) {
    Live l = live("raw");
    ASSERT_TRUE(l.open()) << l.error();
    Stage& stage = const_cast<Stage&>(l.stage());
    SessionOptions options;
    options.size = size;
    options.captures = {"visibility", "lit"};
    const auto rendered = test::open_session(stage.pipeline, shot_, options, stage.nodes);
    for (uint32_t frame = 0; frame < 4; ++frame) {
        l.frame({}, 0);
        rendered->run_frame(frame, frame == 0);
        EXPECT_EQ(l.picture().rgba, picture_of(captured_image(*rendered, "lit")).rgba) << "frame " << frame;
        EXPECT_EQ(rgba(l, "motion"), picture_of(host_image(test::gpu(), *rendered, "motion")).rgba) << frame;
        l.show("");
    }
}

// Nothing moves and the pasts have settled: no frame is run, and what is seen stays. Until something changes.
TEST_F(ViewLive, WhatHasSettledIsNotRunAgain) {
    Live l = live("hybrid_shadows");
    ASSERT_TRUE(l.open()) << l.error();
    l.flight().play(false);
    const Session& session = *l.stage().session;
    ASSERT_TRUE(l.plan().settles);
    const int frames = int(*l.plan().settles);
    // The first has no past, and in the second what comes from its last one is still another.
    run(l, frames + 1);
    EXPECT_FALSE(l.held());
    EXPECT_FALSE(session.view().settled());
    run(l, 1);
    EXPECT_TRUE(session.view().settled());
    EXPECT_FALSE(l.held());
    const auto seen = rgba(l, "color"), mask = rgba(l, "visibility");
    const double cpu_ms = l.cpu_ms();
    run(l, 5);
    EXPECT_EQ(l.cpu_ms(), cpu_ms) << "what was not run counts as cheap";
    EXPECT_TRUE(l.held());
    EXPECT_EQ(rgba(l, "color"), seen);
    EXPECT_EQ(rgba(l, "visibility"), mask);

    FlightInput right;
    right.look = {0.02, 0};
    l.frame(right, 0);
    EXPECT_FALSE(l.held()) << "the camera has turned";
    EXPECT_FALSE(session.view().settled());
    run(l, frames);
    EXPECT_FALSE(l.held()) << "it has settled before its time";
    run(l, 5);
    EXPECT_TRUE(l.held());
    EXPECT_NE(rgba(l, "color"), seen);

    const auto exposure =
        std::ranges::find(l.stage().controls, std::string("shade.exposure"), &Control::name);
    ASSERT_NE(exposure, l.stage().controls.end());
    l.turn_control(static_cast<size_t>(exposure - l.stage().controls.begin()), ParamValue(0.1f));
    run(l, 1);
    EXPECT_FALSE(l.held()) << "a parameter is another";
    run(l, 3);
    EXPECT_FALSE(l.held()) << "what it changes has to settle";
}

// The camera and the sun stand still from the first frame on, the block moves until the sixteenth.
TEST_F(ViewLive, AnObjectThatMovesKeepsItRunning) {
    shot_.camera.resize(1);
    shot_.sun.resize(1);
    shot_.frames = 512;
    Live l = live("hybrid_shadows");
    ASSERT_TRUE(l.open()) << l.error();
    run(l, 17 + int(*l.plan().settles));
    EXPECT_FALSE(l.stage().session->view().settled());
    run(l, 3);
    EXPECT_TRUE(l.held());
}

// Frames go on, for noise and history, while the shot's own time stands still.
TEST_F(ViewLive, AHeldMomentStandsStillAndMotionIsThatOfTheHands) {
    Live l = live("raw");
    ASSERT_TRUE(l.open()) << l.error();
    l.flight().play(false);
    run(l, 1);
    const auto depth = rgba(l, "depth"), noise = rgba(l, "visibility");
    run(l, 6);
    EXPECT_EQ(rgba(l, "depth"), depth) << "an object, the camera or the sun moved on";
    EXPECT_NE(rgba(l, "visibility"), noise) << "the same noise again";
    EXPECT_TRUE(l.still());
    const PlanarImage rest = host_image(test::gpu(), *l.stage().session, "motion");
    for (const float v : rest.planes[0].values) ASSERT_EQ(v, 0);
    FlightInput right;
    right.look = {0.02, 0};
    l.frame(right, 0);
    EXPECT_FALSE(l.still());
    const PlanarImage turned = host_image(test::gpu(), *l.stage().session, "motion");
    // What is seen goes to the left by the angle; it came from further right.
    const double fov = shot_.vertical_fov_deg / 180 * 3.14159265358979;
    const glm::dvec3 ahead = glm::normalize(l.stance().camera.target - l.stance().camera.position);
    const double angle = 0.02 * std::hypot(ahead.x, ahead.z);  // the head turns about the vertical
    const double uv = std::tan(angle) / (2 * std::tan(fov / 2) * size[0] / size[1]);
    EXPECT_NEAR(turned.planes[0].values[size[1] / 2 * size[0] + size[0] / 2], uv, 0.05 * uv);
    run(l, 1);
    EXPECT_EQ(host_image(test::gpu(), *l.stage().session, "motion").planes[0].values, rest.planes[0].values);
}

TEST_F(ViewLive, AnyResourceIsSeenAndAWrongNameIsSaid) {
    Live l = live("one_ray");
    ASSERT_TRUE(l.open()) << l.error();
    run(l, 2);
    for (const std::string& name : resources_of(l.stage())) {
        l.show(name);
        ASSERT_EQ(l.error(), "") << name;
        run(l, 1);
        EXPECT_GT(l.picture().rgba.size(), 0u) << name;
    }
    const std::string before = l.shown();
    l.show("visibilty");
    EXPECT_NE(l.error().find("did you mean \"visibility\"?"), std::string::npos) << l.error();
    EXPECT_EQ(l.shown(), before);
}

// As one of the host's is: what the pipeline makes is seen, and listed once.
TEST_F(ViewLive, AResourceNamedAsAHostImageIsThePipelines) {
    fs::copy(PENUMBRA_SOURCE_DIR "/examples/invert/nodes", folder_ / "nodes");
    std::vector<uint8_t> seen[2];
    for (const bool of_host : {false, true}) {
        const char* const name = of_host ? "albedo" : "mask";
        const std::string out = R"("out": { "shadow": ")" + std::string(name) + R"(" })",
                          outputs = R"("outputs": [")" + std::string(name) + R"(", "visibility"])";
        Live l = live(write("mine.json", R"({ "extends": ")" PENUMBRA_SOURCE_DIR
                                         R"(/pipelines/raw.json", "name": "mine", )" +
                                             outputs + R"(, "inputs": { "albedo": null },
            "nodes": { "shade": null, "again": { "type": "invert", )" +
                                             out + " } } }"));
        ASSERT_TRUE(l.open()) << l.error();
        l.show(name);
        run(l, 1);
        seen[of_host] = rgba(l, name);
        EXPECT_EQ(std::ranges::count(resources_of(l.stage()), name), 1);
    }
    EXPECT_EQ(seen[0], seen[1]);
}

TEST_F(ViewLive, TheTruthConvergesWhileNothingMovesAndJudges) {
    Live good = live("hybrid_shadows"), noisy = live("raw");
    for (Live* l : {&good, &noisy}) {
        ASSERT_TRUE(l->open()) << l->error();
        l->flight().play(false);
        run(*l, 2);
        l->compare(Beside::error);
        ASSERT_EQ(l->error(), "");
        EXPECT_FALSE(l->judgement());
        for (int i = 0; i < 40 && (!l->judgement() || l->judgement()->rays < 64); ++i) l->frame({}, 1e9);
        ASSERT_TRUE(l->judgement());
        ASSERT_GE(l->judgement()->rays, 64u);
    }
    // One ray per pixel is one effective ray per pixel, by the definition.
    EXPECT_NEAR(*noisy.judgement()->n_eff, 1, 0.35);
    EXPECT_GT(*good.judgement()->n_eff, 50);
    noisy.choose_pipeline((fs::path(PENUMBRA_SOURCE_DIR) / "pipelines/one_ray.json").string());
    EXPECT_FALSE(noisy.judgement()) << "of a pipeline that has not drawn a frame";
    run(noisy, 1);
    EXPECT_TRUE(noisy.judgement()) << "the truth is the same";
    const uint32_t rays = good.judgement()->rays;
    good.frame({}, 1e9);
    EXPECT_GT(good.judgement()->rays, rays);
    FlightInput nudge;
    nudge.look = {0.01, 0};
    good.frame(nudge, 1e9);
    EXPECT_FALSE(good.judgement()) << "a truth of where nobody stands any more";
    run(good, 1);
    good.frame({}, 1e9);
    ASSERT_TRUE(good.judgement());
    EXPECT_LT(good.judgement()->rays, rays) << "from the start again";
}

TEST_F(ViewLive, TheSplitShowsTwoMasksOfOnePlace) {
    Live l = live("covered");
    ASSERT_TRUE(l.open()) << l.error();
    l.flight().play(false);
    run(l, 2);
    const auto alone = rgba(l, "visibility");
    l.compare(Beside::raw);
    ASSERT_EQ(l.beside(), Beside::raw) << l.error();
    run(l, 1);
    l.split_share = 1;
    EXPECT_EQ(l.picture().rgba.size(), alone.size());
    const Picture left = l.picture();
    l.split_share = 0;
    const Picture right = l.picture();
    size_t grey_left = 0, grey_right = 0, differ = 0;
    for (size_t i = 0; i < left.rgba.size(); i += 4) {
        grey_left += left.rgba[i] > 0 && left.rgba[i] < 255;
        grey_right += right.rgba[i] > 0 && right.rgba[i] < 255;
        differ += left.rgba[i] != right.rgba[i];
    }
    EXPECT_GT(grey_left, 50u) << "a penumbra";
    EXPECT_EQ(grey_right, 0u) << "one ray is 0 or 1";
    EXPECT_LE(differ, grey_left + left.rgba.size() / 400) << "where the mask is certain, so is the ray";
    // What puts out no mask has nothing to be compared, and says so.
    l.choose_pipeline("denoise_nothing");
    EXPECT_NE(l.error(), "");
    EXPECT_EQ(l.stage().pipeline.name, "covered");
    EXPECT_EQ(l.beside(), Beside::raw);
    run(l, 1);
    l.choose_pipeline("raw_reflections");
    EXPECT_EQ(l.stage().pipeline.name, "raw_reflections") << l.error();
    EXPECT_EQ(l.beside(), Beside::nothing);
    EXPECT_NE(l.error().find("visibility"), std::string::npos) << l.error();
    run(l, 1);
}

constexpr const char* declaration = R"({
  "node": "dim", "doc": "A mask, dimmed.", "shader": "dim.comp",
  "inputs":  { "visibility": { "kind": "image", "format": ["r8", "r16f"] } },
  "outputs": { "dimmed": { "kind": "image", "format": "r16f" } },
  "params":  { "gain": { "type": "float", "default": 1, "range": [0, 4], "doc": "factor" } },
  "dispatch": { "over": "frame", "group": [8, 8] }
})";
std::string shader(const std::string& value) {
    return "#include \"node.glsl\"\nvoid main() {\n    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);\n"
           "    if (any(greaterThanEqual(p, imageSize(dimmed)))) return;\n    imageStore(dimmed, p, vec4(" +
           value + "));\n}\n";
}

// An editor saves, the view follows; a mistake is shown with its place, and the last good state goes on with
// the parameters as they were turned.
TEST_F(ViewLive, WhatIsSavedIsTakenOverAndMistakesAreShown) {
    write("nodes/dim.json", declaration);
    write("nodes/dim.comp", shader("0.25 * params.gain"));
    const std::string raw = (fs::path(PENUMBRA_SOURCE_DIR) / "pipelines/raw.json").string();
    const std::string pipeline = write("mine.json", R"({ "extends": ")" + raw + R"(", "name": "mine",
        "outputs": ["visibility", "dimmed"], "nodes": { "dim": { "type": "dim" } } })");
    Live l = live(pipeline);
    ASSERT_TRUE(l.open()) << l.error();
    const auto middle = [&] {
        l.frame({}, 0);
        return int{l.picture().rgba[4 * (size[1] / 2 * size[0] + size[0] / 2)]};
    };
    EXPECT_EQ(middle(), 64);
    size_t gain = 0;
    while (gain < l.stage().controls.size() && l.stage().controls[gain].name() != "dim.gain") ++gain;
    ASSERT_LT(gain, l.stage().controls.size());
    l.turn_control(gain, ParamValue(2.0f));
    EXPECT_EQ(middle(), 128);
    l.turn_control(gain, ParamValue(9.0f));
    EXPECT_NE(l.error(), "") << "out of the declared range";
    EXPECT_EQ(middle(), 128);

    l.reload_changed();
    EXPECT_EQ(l.reloads(), 0u) << "nothing has changed";
    write("nodes/dim.comp", shader("0.1 * params.gain"));
    l.reload_changed();
    EXPECT_EQ(l.reloads(), 1u) << l.error();
    EXPECT_EQ(l.error(), "");
    EXPECT_EQ(middle(), 51) << "the new shader with the turned parameter";

    write("nodes/dim.comp", shader("nonsense"));
    l.reload_changed();
    EXPECT_NE(l.error().find("dim.comp"), std::string::npos) << l.error();
    EXPECT_EQ(middle(), 51);
    l.reload_changed();
    EXPECT_NE(l.error(), "") << "it is still wrong, and nothing has been saved since";

    write("mine.json", "{ not JSON");
    write("nodes/dim.comp", shader("0.3 * params.gain"));
    l.reload_changed();
    EXPECT_NE(l.error().find("mine.json:1"), std::string::npos) << l.error();
    EXPECT_EQ(middle(), 51);
    write("mine.json", R"({ "extends": ")" + raw + R"(", "name": "mine", "outputs": ["visibility", "dimmed"],
        "nodes": { "dim": { "type": "dim", "params": { "gain": 3 } } } })");
    l.reload_changed();
    EXPECT_EQ(l.error(), "");
    EXPECT_EQ(middle(), 153) << "what hands have turned outlives the file's own value";

    // What is looked at, and what was turned, may be gone from what is saved.
    l.show("dimmed");
    write("mine.json", R"({ "extends": ")" + raw + R"(", "name": "mine" })");
    l.reload_changed();
    EXPECT_NE(l.error().find("\"dimmed\""), std::string::npos) << l.error();
    EXPECT_NE(l.error().find("dim.gain"), std::string::npos) << l.error();
    middle();
    EXPECT_EQ(l.shown(), "lit");
}

TEST_F(ViewLive, ACoarserPictureIsOfTheSamePlace) {
    Live l = live("hybrid_shadows");
    ASSERT_TRUE(l.open()) << l.error();
    l.flight().play(false);
    run(l, 2);
    l.reduce(2);
    ASSERT_EQ(l.error(), "");
    run(l, 2);
    EXPECT_EQ(l.picture().width, size[0] / 2);
    l.compare(Beside::truth);
    l.reduce(4);
    ASSERT_EQ(l.error(), "");
    EXPECT_EQ(l.beside(), Beside::truth);
    for (int i = 0; i < 4; ++i) l.frame({}, 1e9);
    EXPECT_EQ(l.picture().width, size[0] / 4);
    ASSERT_TRUE(l.judgement());
    l.reduce(0);
    EXPECT_EQ(l.size(), size);
}

// A camera that flies may come to look along several cascades of shadow maps, and a sun may set.
TEST_F(ViewLive, CameraAndSunMayGoAnywhere) {
    for (const char* name : {"hybrid_cascades", "shadows"}) {
        Live l = live(name);
        ASSERT_TRUE(l.open()) << l.error();
        FlightInput input;
        input.move = {0, 1, -1};
        input.hurry = true;
        input.seconds = 0.5;
        input.sun = {0.1, -0.25};
        for (int i = 0; i < 12; ++i) l.frame(input, 0);
        EXPECT_LT(l.stance().sun.to_sun.y, 0) << "set";
        l.show("visibility");
        const PlanarImage mask = captured_image(*l.stage().session, "visibility");
        for (const float v : mask.planes[0].values) ASSERT_TRUE(v >= 0 && v <= 1) << name << ": " << v;
    }
}

// What the shot's own course takes of shadow maps is no bound for hands.
TEST_F(ViewLive, ACameraThatLandsHasItsCascades) {
    shot_.camera = {{0, {0, 60, 1}, {0, 0, 0}, {0, 1, 0}}};
    Live l = live("hybrid_cascades");
    ASSERT_TRUE(l.open()) << l.error();
    const auto cascades = [&] { return l.stage().session->host().cascade_fit(l.frames() - 1).count; };
    run(l, 1);
    const uint32_t from_above = cascades();
    FlightInput down;
    down.move = {0, -1, 0};
    down.look = {0, 1.2};
    down.seconds = 59.7 / l.flight().speed_m_per_s();
    l.frame(down, 0);
    run(l, 1);
    EXPECT_NEAR(l.stance().camera.position.y, 0.3, 0.01);
    EXPECT_GT(cascades(), from_above);
    EXPECT_LE(cascades(), l.stage().session->cascade_maps()->maps().layers);
}

// Whatever is thrown while another pipeline or what is beside it is made, here by the tree of triangles,
// whose alpha masks are at most 65536 texels wide. What runs needs no tree.
TEST_F(ViewLive, WhatCannotBeMadeIsSaidAndWhatRanBeforeGoesOn) {
    Model model;
    model.textures = {{65537, 1, std::vector<uint8_t>(size_t{4} * 65537)}};
    model.materials = {{{1, 1, 1, 1}, 0, 0.5}};
    Shape card = ground(1, 1, 1, 1);
    card.uv.resize(card.positions.size());
    test::add(model, "card", card, 0);
    const test::SceneFile file("wide_mask.glb", to_glb(model));
    shot_.model = file.path();
    shot_.objects.clear();
    const fs::path near_light = fs::path(PENUMBRA_SOURCE_DIR) / "pipelines/light_raw.json";
    Live l = live(write("flat.json", R"({ "extends": ")" + near_light.string() + R"(", "name": "flat",
        "inputs": { "scene": null },
        "nodes": { "classify": null, "trace": null, "resolve": null, "night": null, "open": { "if": null } }
    })"));
    ASSERT_TRUE(l.open()) << l.error();
    run(l, 1);
    const auto seen = rgba(l, "visibility");
    const auto goes_on = [&](const char* what) {
        EXPECT_NE(l.error().find("an alpha mask has more than 65536 texels"), std::string::npos)
            << what << ": " << l.error();
        EXPECT_EQ(l.stage().pipeline.name, "flat") << what;
        EXPECT_EQ(l.beside(), Beside::nothing) << what;
        run(l, 1);
        EXPECT_EQ(rgba(l, "visibility"), seen) << what;
    };
    l.choose_pipeline(near_light.string());
    goes_on("another pipeline");
    for (const Beside beside : {Beside::raw, Beside::published, Beside::truth, Beside::error}) {
        l.compare(beside);
        goes_on(beside_names[static_cast<size_t>(beside)]);
    }
}

// The model is read once: another pipeline, size or comparison finds it where its file is gone, and draws
// what a view that has just been opened draws.
TEST_F(ViewLive, WhatChangesThePlanKeepsTheModelAndItsTree) {
    const fs::path given = shot_.model;
    shot_.model = folder_ / given.filename();
    fs::copy_file(given, shot_.model);
    Live changed = live("covered");
    ASSERT_TRUE(changed.open()) << changed.error();
    changed.flight().play(true);
    run(changed, 5);  // the plaza moves, and the tree with it
    fs::remove(shot_.model);
    const std::string raw = (fs::path(PENUMBRA_SOURCE_DIR) / "pipelines/raw.json").string();
    changed.choose_pipeline(raw);
    ASSERT_EQ(changed.stage().pipeline.name, "raw") << changed.error();
    run(changed, 1);
    const auto seen = changed.picture().rgba;
    changed.compare(Beside::published);
    changed.compare(Beside::truth);
    changed.reduce(2);
    EXPECT_EQ(changed.error(), "");
    run(changed, 1);
    EXPECT_EQ(changed.picture().width, size[0] / 2);

    fs::copy_file(given, shot_.model);
    Live fresh = live("raw");
    ASSERT_TRUE(fresh.open()) << fresh.error();
    fresh.flight().play(true);
    run(fresh, 6);
    EXPECT_EQ(fresh.picture().rgba, seen);
}

}  // namespace
}  // namespace penumbra::viewer
