// SPDX-License-Identifier: MIT
// RELAX as a baseline is a strong one: it has many times fewer errors than its rays, standing and in motion,
// leaves mirrors as they are, and does not care how bright the image is as a whole.
#include <cmath>
#include <numeric>

#include "host/models/model_builder.h"
#include "tests/gpu_test.h"
#include "tests/reflections/radiance_run.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

class Relax : public GpuTest {};

std::array<std::vector<float>, 3> last(const std::string& pipeline, const Shot& shot) {
    const auto session = open_shipped(pipeline, shot);
    for (uint32_t frame = 0; frame < shot.frames; ++frame) session->run_frame(frame, frame == 0);
    return colors(*session);
}

// A floor that mirrors coloured walls and a sky, which shine so many times as bright.
Shot court(const std::vector<float>& roughness, uint32_t frames, float brightness = 1) {
    Model model = striped_floor(roughness);
    for (int i = 0; i < 6; ++i) {
        const float r = i % 2 ? 3.0f : 0.2f;
        model.materials.push_back(shining({brightness * r, brightness, brightness * (3.2f - r)}));
        const double x = -3 + i;
        model.meshes.push_back(
            {{to_part(box({x, 0, -1.7}, {x + 1, 1.2, -1.6}), static_cast<int>(model.materials.size()) - 1)}});
        Node node;
        node.mesh = static_cast<int>(model.meshes.size()) - 1;
        node.name = "wall" + std::to_string(i);
        model.nodes.push_back(node);
    }
    Shot shot = night_shot(model, {64, 36}, frames);
    shot.camera = {{0, {0, 1.2, 2.2}, {0, 0, -0.4}, {0, 1, 0}}};
    shot.environment = linear_sky(0.3 * brightness, 1.5 * brightness);
    return shot;
}

double squared_error(const std::array<std::vector<float>, 3>& image, const PlanarImage& truth) {
    const std::array<const char*, 3> names{"R", "G", "B"};
    const auto& receiver = truth.find("receiver")->values;
    double sum = 0;
    for (size_t c = 0; c < 3; ++c) {
        const auto& plane = truth.find(names[c])->values;
        for (size_t i = 0; i < plane.size(); ++i)
            if (receiver[i] > 0) sum += std::pow(double(image[c][i]) - plane[i], 2);
    }
    return sum;
}

double gain(const std::string& pipeline, const std::string& rays, const std::string& signal,
            const Shot& shot) {
    const PlanarImage truth = truth_of(shot, signal, 1024, shot.frames - 1);
    return squared_error(last(rays, shot), truth) / squared_error(last(pipeline, shot), truth);
}

TEST_F(Relax, StandingItsErrorsAreManyTimesLess) {
    EXPECT_GT(gain("relax", "raw_reflections", "specular", court({0.1f, 0.2f, 0.4f, 0.7f}, 16)), 55);
    EXPECT_GT(gain("relax_indirect", "raw_indirect", "diffuse", court({0.5f}, 16)), 40);
}

TEST_F(Relax, InMotionItsErrorsAreManyTimesLess) {
    Shot shot = court({0.1f, 0.2f, 0.4f, 0.7f}, 12);
    shot.camera.push_back({12, {0.3, 1.2, 2.2}, {0.2, 0, -0.4}, {0, 1, 0}});
    EXPECT_GT(gain("relax", "raw_reflections", "specular", shot), 20);
}

TEST_F(Relax, AMirrorThatStandsIsLeftAlone) {
    const Shot shot = court({0.0f}, 6);
    const auto rays = last("raw_reflections", shot), image = last("relax", shot);
    for (size_t c = 0; c < 3; ++c)
        for (size_t i = rays[c].size() / 2; i < rays[c].size(); ++i)  // below the walls
            ASSERT_NEAR(image[c][i], rays[c][i], 2e-3 * rays[c][i]) << "pixel " << i;
}

// A plate that hovers over a floor of its own kind moves on: what it covered has no past, though both are
// level and alike.
TEST_F(Relax, WhatComesIntoViewHasNoPast) {
    for (const char* pipeline : {"relax", "relax_indirect"}) {
        Model model = striped_floor({0.4f});
        model.meshes.push_back({{to_part(box({-0.8, 0.3, -0.6}, {0.2, 0.31, 0.4}), 0)}});
        Node node;
        node.mesh = static_cast<int>(model.meshes.size()) - 1;
        node.name = "plate";
        model.nodes.push_back(node);
        Shot shot = night_shot(model, {64, 36}, 6);
        shot.environment = linear_sky(0.3, 1.5);
        shot.objects["plate"].keys = {{4, {0, 0, 0}, {}}, {5, {0.6, 0, 0}, {}}};
        const auto session = open_shipped(pipeline, shot, {}, {"view_depth", "frames"}, {}, false);
        std::vector<float> before;
        for (uint32_t frame = 0; frame < 6; ++frame) {
            session->run_frame(frame, frame == 0);
            if (frame == 4) before = captured<float>(session->view(), "view_depth");
        }
        const auto depth = captured<float>(session->view(), "view_depth");
        const auto frames = captured<uint8_t>(session->view(), "frames");
        size_t uncovered = 0, unmoved = 0;
        for (size_t i = 0; i < depth.size(); ++i) {
            if (depth[i] > before[i] + 0.1f && before[i] > 0) {
                ++uncovered;
                EXPECT_EQ(frames[i], 1) << pipeline << i;
            }
            unmoved += depth[i] == before[i] && frames[i] > 4;
        }
        EXPECT_GT(uncovered, 15u);
        EXPECT_GT(unmoved, 500u);
    }
}

// All that shines leaves at once: every ray says so, and no noise excuses a past that says otherwise. In the
// first frame without it .80 and .61 of the light is left; .82 and .63 where the past is not clamped, .82 and
// .68 where that does not send it on towards the frame, .88 and .74 where what differs by more than noise
// does not.
TEST_F(Relax, WhatNoRayShowsAnyMoreIsDoubtedAtOnce) {
    for (const auto& [pipeline, most_left] : {std::pair{"relax", 0.806}, {"relax_indirect", 0.62}}) {
        Model model = striped_floor({0.5f});
        model.materials.push_back(shining({1, 1, 1}));
        model.meshes.push_back({{to_part(box({-40, 3, -40}, {40, 3.1, 40}), 1)}});
        Node node;
        node.mesh = static_cast<int>(model.meshes.size()) - 1;
        node.name = "ceiling";
        model.nodes.push_back(node);
        constexpr uint32_t leaves = 16;
        Shot shot = night_shot(model, {64, 36}, leaves + 1);
        shot.environment = linear_sky(0, 0);
        shot.objects["ceiling"].keys = {{leaves - 1, {0, 0, 0}, {}}, {leaves, {0, -500, 0}, {}}};
        const auto session = open_shipped(pipeline, shot);
        double before = 0, after = 0;
        for (uint32_t frame = 0; frame <= leaves; ++frame) {
            session->run_frame(frame, frame == 0);
            const auto image = colors(*session);
            before = after;
            after = std::accumulate(image[1].begin(), image[1].end(), 0.0);
        }
        EXPECT_LT(after / before, most_left) << pipeline;
    }
}

// The published acceleration is a radiance; here it is a share.
TEST_F(Relax, ABrighterImageIsTheSameImage) {
    const auto run = [](float brightness) {
        Shot shot = court({0.1f, 0.3f, 0.7f}, 16, brightness);
        for (const char* wall : {"wall2", "wall3", "wall4"})  // which leave
            shot.objects[wall].keys = {{9, {0, 0, 0}}, {10, {0, -500, 0}}};
        return last("relax", shot);
    };
    const auto image = run(1), brighter = run(8);
    size_t off = 0;  // numbers round otherwise at the ends of a half float's range, of a pixel here and there
    for (size_t i = 0; i < image[1].size(); ++i) {
        ASSERT_NEAR(brighter[1][i], 8 * image[1][i], 5e-3 * brighter[1][i]) << "pixel " << i;
        off += std::abs(brighter[1][i] - 8 * image[1][i]) > 1e-3f * brighter[1][i];
    }
    EXPECT_LE(off, 2u);
}

}  // namespace
}  // namespace penumbra::test
