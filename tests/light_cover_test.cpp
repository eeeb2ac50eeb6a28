// SPDX-License-Identifier: MIT
// Exact coverage of lights that are near: what a plate hides of each kind of light against closed forms, and
// what only a light that ends somewhere can get wrong: blockers beyond it, through its plane, and its
// housing.
#include <bit>
#include <set>

#include "app/captured_values.h"
#include "tests/light_plate.h"

namespace penumbra::test {
namespace {

struct Against {
    double expected = 0, squares = 0, sum = 0;  // of one ray's variance; of errors
    size_t soft = 0, wrong_whole = 0;           // pixels that see all or nothing and say else
    double n_eff() const { return expected / squares; }
    double bias() const { return sum / double(soft); }
};

Against against_closed_form(const Shot& shot, std::span<const glm::dvec3> blocker, uint32_t frames,
                            const std::vector<std::string>& settings = {}) {
    Diagnostics diagnostics;
    const auto session = open(shot, "light", settings, diagnostics);
    if (!session) throw std::runtime_error(diagnostics.text());
    const NearLight light(light_block(shot.lights.at("lamp"), 0, glm::dvec3(0)));
    const auto points = floor_points(shot);
    Against result;
    for (uint32_t frame = 0; frame < frames; ++frame) {
        session->run_frame(frame, frame == 0);
        const std::vector<float> v = captured_planes(session->view(), "visibility")[0];
        for (size_t i = 0; i < points.size(); ++i) {
            if (!points[i] || !light.reaches(*points[i])) continue;
            const double exact = light.visibility(*points[i], blocker), error = double(v[i]) - exact;
            if ((exact == 0 || exact == 1) && error != 0) ++result.wrong_whole;
            if (!(exact > 0.02 && exact < 0.98)) continue;
            result.expected += exact * (1 - exact);
            result.squares += error * error;
            result.sum += error;
            ++result.soft;
        }
    }
    return result;
}

class NearLightsCovered : public GpuTest, public ::testing::WithParamInterface<LightKind> {};

TEST_P(NearLightsCovered, AreTheClosedForm) {
    const Against plate_alone = against_closed_form(shot_with(GetParam(), {192, 108}), plate, 4);
    std::printf("%s: N_eff %.0f, bias %.5f of %zu, %zu whole ones wrong\n", name_of(GetParam()),
                plate_alone.n_eff(), plate_alone.bias(), plate_alone.soft, plate_alone.wrong_whole);
    EXPECT_GT(plate_alone.soft, 1000u);
    EXPECT_GT(plate_alone.n_eff(), 2000);
    EXPECT_LT(std::abs(plate_alone.bias()), 5e-4);
    EXPECT_EQ(plate_alone.wrong_whole, 0u);
}

INSTANTIATE_TEST_SUITE_P(Kinds, NearLightsCovered,
                         ::testing::Values(LightKind::point, LightKind::sphere, LightKind::disc,
                                           LightKind::rectangle, LightKind::tube, LightKind::spot),
                         [](const auto& test) { return std::string(name_of(test.param)); });

// Where a light that ends somewhere differs from the sun: the plate passes through the light's plane or the
// light itself, lies behind it, or all but closes the way; the floor is nearly in its plane, or lies at it.
struct Awkward {
    const char* name;
    LightKind kind;
    LightKey at;
    double radius, length, height;
    double
        least;  // N_eff; 0 where everybody sees all or nothing, but for a sample beside a plate seen edge-on
};

std::vector<Awkward> awkward() {
    const glm::dvec3 down(0, -1, 0), x(1, 0, 0);
    return {
        {"plate_through_plane",
         LightKind::rectangle,
         {0, {0.1, 1.1, 0.1}, {-1, -0.4, 0}, {0, 0, 1}, 1, 1},
         0,
         1,
         0.8,
         500},
        {"plate_through_disc", LightKind::disc, {0, {0.2, 1.0, 0}, {-1, -0.2, 0}, x, 1, 1}, 0.5, 0, 0, 500},
        {"plate_behind", LightKind::disc, {0, {0, 0.9, 0}, {0.1, -1, 0}, x, 1, 1}, 0.3, 0, 0, 0},
        {"plate_through_sphere", LightKind::sphere, {0, {0.45, 1.1, 0.1}, down, x, 1, 1}, 0.35, 0, 0, 500},
        {"plate_within_sphere", LightKind::sphere, {0, {0, 1.0, 0}, down, x, 1, 1}, 0.6, 0, 0, 0},
        {"cap_of_60_degrees", LightKind::sphere, {0, {0, 2.4, 0}, down, x, 1, 1}, 1.35, 0, 0, 500},
        {"wide_and_near", LightKind::rectangle, {0, {0, 1.02, 0}, {0, -1, 0}, x, 1, 1}, 0, 2, 2, 500},
        {"upright", LightKind::rectangle, {0, {-1.5, 0.9, 0}, {1, 0, 0}, {0, 1, 0}, 1, 1}, 0, 1.8, 1, 500},
        {"along_the_tube", LightKind::tube, {0, {0, 2, 0}, down, {0, 1, 0}, 1, 1}, 0.05, 1.5, 0, 300},
        {"tiny", LightKind::sphere, {0, {0.2, 2.6, 0.1}, down, x, 1, 1}, 1e-4, 0, 0, 0},
    };
}

void PrintTo(const Awkward& a, std::ostream* out) {
    *out << a.name;
}

class NearLightsAwkward : public GpuTest, public ::testing::WithParamInterface<Awkward> {};

TEST_P(NearLightsAwkward, AreTheTruth) {
    Shot shot = shot_with(GetParam().kind, {64, 36});
    ShotLight& light = shot.lights.at("lamp");
    light.radius = GetParam().radius;
    light.length = GetParam().length;
    light.height = GetParam().height;
    light.range = 20;
    light.keys = {GetParam().at};
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto truth_session = open_light_truth(gpu(), shot, "lamp", diagnostics, warnings, false);
    ASSERT_TRUE(truth_session) << diagnostics.text();
    const Truth truth = counted_light_truth(*truth_session, 0, 4096);
    const auto session = open(shot, "light", {}, diagnostics);
    ASSERT_TRUE(session) << diagnostics.text();
    double expected = 0, squares = 0, sum = 0, worst = 0;
    size_t receivers = 0, soft = 0, leaks = 0, wrong = 0;
    for (uint32_t frame = 0; frame < 4; ++frame) {
        session->run_frame(frame, frame == 0);
        const std::vector<float> v = captured_planes(session->view(), "visibility")[0];
        for (size_t i = 0; i < v.size(); ++i) {
            if (truth.receiver[i] == 0) continue;
            const double exact = truth.visibility[i], error = double(v[i]) - exact;
            ++receivers;
            expected += exact * (1 - exact);
            squares += error * error;
            sum += error;
            soft += exact > 0 && exact < 1;
            leaks += exact == 0 && v[i] > 0.02f;
            wrong += error != 0;
            worst = std::max(worst, std::abs(error));
        }
    }
    std::printf("%s: N_eff %.0f, bias %.5f of %zu receivers, %zu soft, %zu leaks\n", GetParam().name,
                expected / squares, sum / double(receivers), receivers, soft, leaks);
    EXPECT_GT(receivers, 1000u);
    EXPECT_EQ(leaks, 0u);
    if (GetParam().least > 0) {
        EXPECT_GT(soft, 100u);
        EXPECT_GT(expected / squares, GetParam().least);
        EXPECT_LT(std::abs(sum) / double(receivers), 4e-3);
    } else {
        EXPECT_EQ(soft, 0u);
        EXPECT_LT(wrong, receivers / 1000);
        EXPECT_LT(worst, 0.01);
    }
}

class FlushPanel : public GpuTest {};

// By rounding alone some of the floor's points lie before the panel and others behind it.
TEST_F(FlushPanel, LightsNoneOfTheFloorAroundIt) {
    Shot shot = shot_with(LightKind::rectangle, {96, 54});
    shot.lights.at("lamp").keys = {{0, {0.9, 0, 0.1}, {0, 1, 0}, {1, 0, 0}, 1, 1}};
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto truth_session = open_light_truth(gpu(), shot, "lamp", diagnostics, warnings, false);
    const auto session = open(shot, "light", {}, diagnostics);
    ASSERT_TRUE(truth_session && session) << diagnostics.text();
    const Truth truth = counted_light_truth(*truth_session, 0, 16);
    session->run_frame(0, true);
    const std::vector<float> v = captured_planes(session->view(), "visibility")[0];
    const auto points = floor_points(shot);
    std::set<float> said;
    size_t floor = 0, receivers = 0;
    for (size_t i = 0; i < v.size(); ++i) {
        if (!points[i]) continue;
        ++floor;
        receivers += truth.receiver[i] > 0;
        said.insert(v[i]);
    }
    EXPECT_GT(floor, 1000u);
    EXPECT_EQ(receivers, 0u);
    EXPECT_EQ(said.size(), 1u) << "the floor is not of one kind";
}

class Bulb : public GpuTest {};

// Which has a direction all the same, as every light's block does.
TEST_F(Bulb, ReachesWhatIsStraightBehindItsDirection) {
    Shot shot = shot_with(LightKind::point, {96, 54});
    shot.lights.at("lamp").keys = {{0, {1.5, 2, 0.1}, {0, 1, 0}, {1, 0, 0}, 1, 1}};
    shot.camera = {{0, {1.5, 0.1, 0.4}, {1.5, 0, 0.1}, {0, 1, 0}}};
    shot.vertical_fov_deg = 1;
    Diagnostics diagnostics;
    const auto session = open(shot, "light", {R"(outputs=["visibility","receiver_words"])"}, diagnostics);
    ASSERT_TRUE(session) << diagnostics.text();
    session->run_frame(0, true);
    int receivers = 0;
    for (const uint32_t word : captured_values<uint32_t>(*session, "receiver_words"))
        receivers += std::popcount(word);
    EXPECT_EQ(receivers, 96 * 54);
}

INSTANTIATE_TEST_SUITE_P(Cases, NearLightsAwkward, ::testing::ValuesIn(awkward()),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace penumbra::test
