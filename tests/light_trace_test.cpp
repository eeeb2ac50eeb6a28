// SPDX-License-Identifier: MIT
// Lights that are near, on a floor below a plate that hangs: the truth by rays is the closed form, the rays
// of trace are samples of it, what the light cannot reach is no receiver, and what knows the sun alone says
// so.
#include "tests/light_plate.h"

namespace penumbra::test {
namespace {

class NearLights : public GpuTest, public ::testing::WithParamInterface<LightKind> {};

TEST_P(NearLights, TheTruthIsTheClosedForm) {
    const Shot shot = shot_with(GetParam(), {40, 24});
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto session = open_light_truth(gpu(), shot, "lamp", diagnostics, warnings, false);
    ASSERT_TRUE(session) << diagnostics.text();
    const Truth truth = counted_light_truth(*session, 0, 16384);
    const NearLight light(light_block(shot.lights.at("lamp"), 0, glm::dvec3(0)));
    const auto points = floor_points(shot);
    double sum = 0, squares = 0;
    size_t soft = 0, unreached = 0, lit = 0;
    for (size_t i = 0; i < points.size(); ++i) {
        if (!points[i]) continue;
        const bool reached = light.reaches(*points[i]);
        unreached += !reached;
        if (std::abs(glm::length(*points[i] - light.centre()) - 3.4) > 0.01 &&
            GetParam() != LightKind::spot) {
            EXPECT_EQ(truth.receiver[i] > 0, reached) << i;
        }
        if (!reached || truth.receiver[i] == 0) continue;
        const double exact = light.visibility(*points[i], plate), error = double(truth.visibility[i]) - exact;
        if (exact == 1) {
            ++lit;
            EXPECT_EQ(truth.visibility[i], 1) << i;
        }
        if (!(exact > 0.02 && exact < 0.98)) continue;
        ++soft;
        sum += error;
        squares += error * error;
    }
    std::printf("%s: %zu soft pixels, bias %.6f, RMSE %.6f, %zu unreached\n", name_of(GetParam()), soft,
                sum / double(soft), std::sqrt(squares / double(soft)), unreached);
    EXPECT_GT(soft, 20u);
    EXPECT_GT(lit, 50u);
    EXPECT_GT(unreached, 50u);
    EXPECT_LT(std::abs(sum) / double(soft), 2e-4);
    EXPECT_LT(std::sqrt(squares / double(soft)), 8e-4);
}

// One ray is one sample: its mean square error is v (1 - v), and its mean is v.
TEST_P(NearLights, ARayIsASampleOfIt) {
    const Shot shot = shot_with(GetParam(), {192, 108});
    Diagnostics diagnostics;
    const auto session = open(shot, "light_raw", {}, diagnostics);
    ASSERT_TRUE(session) << diagnostics.text();
    const NearLight light(light_block(shot.lights.at("lamp"), 0, glm::dvec3(0)));
    const auto points = floor_points(shot);
    double expected = 0, squares = 0, sum = 0, soft = 0;
    for (uint32_t frame = 0; frame < 4; ++frame) {
        session->run_frame(frame, frame == 0);
        const std::vector<float> v = captured_planes(session->view(), "visibility")[0];
        for (size_t i = 0; i < points.size(); ++i) {
            if (!points[i] || !light.reaches(*points[i])) continue;
            const double exact = light.visibility(*points[i], plate), error = double(v[i]) - exact;
            if (exact == 1) {
                EXPECT_EQ(v[i], 1) << i;
            }
            if (!(exact > 0.02 && exact < 0.98)) continue;
            expected += exact * (1 - exact);
            squares += error * error;
            sum += error;
            ++soft;
        }
    }
    std::printf("%s: N_eff %.3f, bias %.4f of %.0f\n", name_of(GetParam()), expected / squares, sum / soft,
                soft);
    EXPECT_GT(soft, 1000);
    EXPECT_NEAR(expected / squares, 1, 0.08);
    EXPECT_LT(std::abs(sum / soft), 0.01);
}

INSTANTIATE_TEST_SUITE_P(Kinds, NearLights,
                         ::testing::Values(LightKind::point, LightKind::sphere, LightKind::disc,
                                           LightKind::rectangle, LightKind::tube, LightKind::spot),
                         [](const auto& test) { return std::string(name_of(test.param)); });

class NearLightsRefused : public GpuTest {};

TEST_F(NearLightsRefused, ByWhatKnowsTheSunAlone) {
    const Shot shot = shot_with(LightKind::rectangle, {32, 18});
    Diagnostics whole, node;
    EXPECT_EQ(open(shot, "raw", {}, whole), nullptr);
    EXPECT_NE(whole.text().find("\"raw\" knows the sun alone, and the shot's light is \"lamp\", a rectangle"),
              std::string::npos)
        << whole.text();
    EXPECT_EQ(open(shot, "many_rays", {"inputs.light={}"}, node), nullptr);
    EXPECT_NE(node.text().find("nodes.beams: \"beams\" knows the sun alone"), std::string::npos)
        << node.text();
}

TEST_F(NearLightsRefused, OffIsNoRayAndNoShadow) {
    Shot shot = shot_with(LightKind::rectangle, {96, 54});
    shot.lights["lamp"].keys[0].power = 0;
    Diagnostics diagnostics;
    const auto session = open(shot, "light_raw", {}, diagnostics);
    ASSERT_TRUE(session) << diagnostics.text();
    session->run_frame(0, true);
    const auto planes = captured_planes(session->view(), "visibility");
    for (const float v : planes.at(0)) ASSERT_EQ(v, 1);
    EXPECT_EQ(counters_of(session->view(), "trace").at("rays"), 0u);
    EXPECT_EQ(counters_of(session->view(), "classify").at("receivers"), 0u);
}

}  // namespace
}  // namespace penumbra::test
