// SPDX-License-Identifier: MIT
// shadows.json on shots that come with the project. Standing still: what many rays per pixel say is reached,
// also where gathering the neighbours' rays has a bias (leaves in several layers, curved surfaces): a pixel's
// own rays know. Without that, trees at 192x108 read 64 after 64 frames instead of 257.
#include <cmath>

#include "host/models/glb_writer.h"
#include "tests/gpu_test.h"
#include "tests/scene_file.h"
#include "tests/shot_run.h"
#include "tests/test_scene.h"

namespace penumbra::test {
namespace {

Shot still_shot(const std::string& name) {
    Shot shot = shot_named(name, {{128, 72}});
    shot.camera.resize(1);
    return shot;
}

// Of the last of 48 frames, every eighth: one frame is as good as its luck. `facts`: what the pipeline is
// told whatever the scene says.
double n_eff(const Shot& shot, const Truth& truth, const Facts& facts, const char* pipeline) {
    constexpr uint32_t frames = 48, judged = 16;
    ShotRun run(pipeline, shot, {.facts = facts});
    double errors = 0;
    for (uint32_t frame = 0; frame < frames; ++frame) {
        const std::vector<float> image = run.frame(frame, frame == 0);
        if (frame >= frames - judged && frame % 8 == 7) errors += 1 / n_eff_of_receivers(image, truth);
    }
    return judged / 8 / errors;
}

class ShadowsOfShots : public GpuTest {};

TEST_F(ShadowsOfShots, StandingStillReachWhatManyRaysSay) {
    const Shot shot = still_shot("trees");
    const Truth truth = truth_of(shot, 0, 400);
    for (const char* pipeline : {"one_ray", "shadows_fast"}) {
        SCOPED_TRACE(pipeline);
        const double still = n_eff(shot, truth, {}, pipeline),
                     may_move = n_eff(shot, truth, {{"moves", true}}, pipeline);
        RecordProperty(std::string(pipeline) + "_still", std::to_string(still));
        RecordProperty(std::string(pipeline) + "_may_move", std::to_string(may_move));
        EXPECT_GT(still, 100);
        // The drift test doubts nothing; but where things may move, frames of many rays ask the past for
        // less.
        EXPECT_GT(may_move, pipeline == std::string("one_ray") ? 100 : 30);
    }
}

// Where a wide penumbra is softened, and the own rays' mean is mixed in besides.
TEST_F(ShadowsOfShots, AreVisibilitiesUnderAWideSun) {
    for (const char* name : {"lamp", "colonnade"}) {
        Shot shot = still_shot(name);
        shot.objects.clear();
        shot.sun_angular_radius_deg = 20;
        ShotRun run("one_ray", shot);
        size_t outside = 0;
        for (uint32_t frame = 0; frame < 32; ++frame)
            outside += count_if(run.frame(frame, frame == 0), [](float v) { return !(v >= 0 && v <= 1); });
        EXPECT_EQ(outside, 0u) << name;
    }
}

// Frames 32 to 39 under jitter, of a camera and things that stand still.
std::vector<float> jittered(const Shot& shot, const char* pipeline, bool& moves) {
    ShotRun run(pipeline, shot, {.jitter = true});
    moves = run.session().plan().facts.at("moves");
    std::vector<float> out;
    for (uint32_t frame = 0; frame < 40; ++frame) {
        const std::vector<float> image = run.frame(frame, frame == 0);
        if (frame >= 32) out.insert(out.end(), image.begin(), image.end());
    }
    return out;
}

// A pixel at an outline shows one surface in one frame and another one in the next: each is lit or dark as it
// is, which the mask of coverage has no past to confuse.
TEST_F(ShadowsOfShots, AnOutlineUnderJitterIsOfWhatItShows) {
    Model model;
    model.materials = {{}};
    add(model, "floor", ground(8, 8, 4, 4), 0);
    for (int i = 0; i < 12; ++i) {
        const double x = -3 + 2 * (i % 4) + 0.3 * (i / 4), z = -3 + 2.5 * (i / 4), h = 0.6 + 0.15 * (i % 5);
        add(model, "box", box({x, 0, z}, {x + 0.9, h, z + 0.8}), 0);
    }
    const SceneFile file("boxes.glb", to_glb(model));
    Shot shot;
    shot.name = "boxes";
    shot.model = file.path();
    shot.size = {160, 90};
    shot.camera = {{0, {1, 4, 9}, {0, 0, 0}, {0, 1, 0}}};
    shot.sun_angular_radius_deg = 0.5;
    shot.sun = {{0, {-0.4, 1, -0.7}}};
    bool moves = false;
    const std::vector<float> exact = jittered(shot, "hybrid_shadows", moves);
    EXPECT_FALSE(moves);
    const auto error = [&](const std::vector<float>& mask) {
        double sum = 0;
        for (size_t i = 0; i < mask.size(); ++i) sum += (mask[i] - exact[i]) * (mask[i] - exact[i]);
        return sum;
    };
    const double squared = error(jittered(shot, "shadows_fast", moves));
    EXPECT_TRUE(moves);
    std::printf("squared error: %.3g\n", squared);
    EXPECT_LT(squared, 8) << "of a past per pixel 189";
}

// A part of the sun is below the floor, whose rays to it are dark here and there although nothing is in
// their way: no sign that anything has changed, where it may, nor that all is lit, where they happen to
// agree.
TEST_F(ShadowsOfShots, ASunThatTheFloorCutsIsNoChange) {
    Shot shot = plaza_shot({96, 54}, 1);
    shot.camera.resize(1);
    shot.objects.clear();
    shot.sun_angular_radius_deg = 2;
    shot.sun = {{0, {1, 0.03, 0.2}}};  // 1.7 degrees
    const Facts may_change{{"moves", true}, {"sun_moves", true}};
    const Truth truth = truth_of(shot, 0, 400);
    for (const char* pipeline : {"one_ray", "shadows_fast"})
        EXPECT_GT(n_eff(shot, truth, may_change, pipeline), 80) << pipeline;
}

// A camera that moves resamples the past of edges that are narrower than a pixel, and a shadow that moves
// leaves its past behind: engine has the one, lamp the other.
double moving_error(const Shot& shot, const char* pipeline) {
    constexpr uint32_t last = 15;
    const Truth truth = truth_of(shot, last, 144);
    const std::vector<float> image = ShotRun(pipeline, shot).up_to(last);
    double error = 0;
    for (size_t i = 0; i < image.size(); ++i)
        if (truth.receiver[i] > 0) error += std::pow(double(image[i]) - truth.visibility[i], 2);
    return error;
}

class ShadowsOfMovingShots : public GpuTest,
                             public ::testing::WithParamInterface<std::pair<const char*, double>> {};

// Summed squared error: 18 and 21 while the past of a hard edge was taken at its word.
TEST_P(ShadowsOfMovingShots, DoNotTrustThePastOfAHardEdge) {
    const auto& [shot, most] = GetParam();
    EXPECT_LT(moving_error(shot_named(shot, {{192, 108}}), "shadows_fast"), most);
}

INSTANTIATE_TEST_SUITE_P(Shots, ShadowsOfMovingShots,
                         ::testing::Values(std::pair{"engine", 15.5}, std::pair{"lamp", 16.5}),
                         [](const auto& test) { return std::string(test.param.first); });

// A deck with a plate above it goes ahead with the camera, along its own plane or also across it: all of the
// picture stands still, and is where nothing that stands still in the world would have been. In the last one
// the camera stands, and the deck comes nearer, to end where it is in the others.
TEST_F(ShadowsOfShots, KeepThePastOfWhatMoves) {
    Model model;
    model.materials = {{{0.8f, 0.8f, 0.8f, 1}, -1}};
    add(model, "deck", ground(10, 10, 4, 4), 0);
    add(model, "plate", ground(0.4, 0.3, 1, 1), 0);
    model.nodes.back().translation = {0, 1, 0};
    const SceneFile file("deck.glb", to_glb(model));
    const auto shot_going = [&](glm::dvec3 way, glm::dvec3 camera) {  // per frame
        Shot shot;
        shot.name = "deck";
        shot.model = file.path();
        shot.size = {96, 54};
        shot.frames = 16;
        const glm::dvec3 eye(0, 1.5, 2.5);
        shot.camera = {{0, eye, {0, 0, 0}, {0, 1, 0}}, {15, eye + 15.0 * camera, 15.0 * camera, {0, 1, 0}}};
        shot.sun = {{0, {0.2, 1, 0.3}}};
        shot.sun_angular_radius_deg = 5;
        for (const Node& node : model.nodes)
            shot.objects[node.name].keys = {{0, node.translation - 15.0 * (way - camera), {}},
                                            {15, node.translation + 15.0 * camera, {}}};
        return shot;
    };
    for (const char* pipeline : {"shadows_still", "one_ray"}) {
        const double still = moving_error(shot_going({0, 0, 0}, {0, 0, 0}), pipeline);
        for (const glm::dvec3 way : {glm::dvec3(0, 0, -0.8), {0, -0.2, -0.8}})
            EXPECT_LT(moving_error(shot_going(way, way), pipeline), 1.1 * still) << pipeline << way.y;
    }
    const double still = moving_error(shot_going({0, 0, 0}, {0, 0, 0}), "one_ray");
    EXPECT_LT(moving_error(shot_going({0, 0.2, 0.34}, {0, 0, 0}), "one_ray"),
              9 * still);  // 16 without the motion's third component
}

// 16 frames of a scene under a small sun.
Shot under_a_small_sun(const SceneFile& file, std::array<uint32_t, 2> size, std::vector<CameraKey> camera,
                       glm::dvec3 to_sun) {
    Shot shot;
    shot.name = "scene";
    shot.model = file.path();
    shot.size = size;
    shot.frames = 16;
    shot.camera = std::move(camera);
    shot.sun = {{0, to_sun}};
    shot.sun_angular_radius_deg = 0.5;
    return shot;
}

// Poles of a pixel's width, seen from a camera that goes by: their texels show other parts of them in each
// frame, so that a pixel has no past that could stand for the ray that it does not get. Nothing stands before
// the sun.
TEST_F(ShadowsOfShots, AreRightOfPolesThatArePixelsWide) {
    Model model;
    model.materials = {{{0.8f, 0.8f, 0.8f, 1}, -1}};
    for (int i = 0; i < 7; ++i) {
        add(model, ("pole" + std::to_string(i)).c_str(), rod({0, -1.5, 0}, {0, 1.5, 0}, 0.04, 24), 0);
        model.nodes.back().translation = {0.7 * i - 2.1, 0, 0};
    }
    const SceneFile file("poles.glb", to_glb(model));
    const Shot shot = under_a_small_sun(
        file, {96, 54},
        {{0, {-0.25, 0, 6}, {-0.25, 0, 0}, {0, 1, 0}}, {15, {0.4, 0, 6}, {0.4, 0, 0}, {0, 1, 0}}},
        {0.7, 0.5, 1});
    for (const char* pipeline : {"shadows_fast", "shadows_still"})
        EXPECT_LT(moving_error(shot, pipeline), 0.01) << pipeline;
}

// Lit specks that go by a wall in shadow, by more per frame than rays are asked from: where one is, the wall
// and all around were dark. One whose turn it is not is what it was, not what the wall is.
TEST_F(ShadowsOfShots, KeepTheLightOfSpecksBeforeAWallInShadow) {
    Model model;
    model.materials = {{{0.8f, 0.8f, 0.8f, 1}, -1}};
    add(model, "wall", box({-10, -1, -0.1}, {10, 1, 0}), 0);
    add(model, "roof", box({-20, 3, 1}, {20, 3.1, 5}), 0);
    Shape specks;
    for (int i = 0; i < 15; ++i)
        for (const double y : {-0.3, 0.0, 0.3})
            specks.append(box({0.8 * i - 9, y - 0.02, 3.99}, {0.8 * i - 8.96, y + 0.02, 4}));
    add(model, "specks", specks, 0);
    const SceneFile file("specks.glb", to_glb(model));
    Shot shot = under_a_small_sun(file, {192, 108}, {{0, {0, 0, 7}, {0, 0, 0}, {0, 1, 0}}}, {0, 1, 1});
    shot.objects["specks"].keys = {{0, {0, 0, 0}, {}}, {15, {5.8, 0, 0}, {}}};
    EXPECT_LT(moving_error(shot, "shadows_fast"), 0.1);
}

// Kerbs that keep the sun from less than a pixel before them, below a camera that rises: the row of pixels at
// a kerb's foot is lit in most frames and dark in some, and nothing of that was there in the frame before.
TEST_F(ShadowsOfShots, SeeTheShadowAtTheFootOfAKerb) {
    Model model;
    model.materials = {{{0.8f, 0.8f, 0.8f, 1}, -1}};
    add(model, "road", ground(20, 20, 4, 4), 0);
    for (int i = 0; i < 8; ++i) {
        add(model, ("kerb" + std::to_string(i)).c_str(), box({-20, 0, -0.3}, {20, 0.05, 0}), 0);
        model.nodes.back().translation = {0, 0, 1.5 - i * 0.77};
    }
    const SceneFile file("kerbs.glb", to_glb(model));
    const Shot shot = under_a_small_sun(
        file, {192, 108}, {{0, {0, 2, 5}, {0, 0, 0}, {0, 1, 0}}, {15, {0, 2.1, 5}, {0, 0.1, 0}, {0, 1, 0}}},
        {0, 1, -1});
    EXPECT_LT(moving_error(shot, "shadows_fast"), 10);  // 214 where a past beside a kerb is one of a plane
}

// A strip of road two rows high, seen through a slit in what turns its back to the sun. A shadow comes in
// that was hidden behind that in the frame before.
TEST_F(ShadowsOfShots, SeeWhatComesFromBehindWhatHasNoRays) {
    Model model;
    model.materials = {{{0.8f, 0.8f, 0.8f, 1}, -1}};
    add(model, "road", ground(20, 20, 4, 4), 0);
    add(model, "below", box({-20, 0, 0}, {20, 1, 0.1}), 0);
    add(model, "above", box({-20, 1.12, 0}, {20, 3, 0.1}), 0);
    add(model, "roof", box({-20, 3, -20}, {20, 3.1, -9.8}), 0);
    const SceneFile file("slit.glb", to_glb(model));
    Shot shot = under_a_small_sun(file, {192, 108}, {{0, {0, 2, 5}, {0, 0, -5}, {0, 1, 0}}}, {0, 1, -1});
    shot.objects["roof"].keys = {{14, {0, 0, 0}, {}}, {15, {0, 0, 1.1}, {}}};
    EXPECT_LT(moving_error(shot, "shadows_fast"), 1);  // 192 where it waits for a turn
}

}  // namespace
}  // namespace penumbra::test
