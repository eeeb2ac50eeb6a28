// SPDX-License-Identifier: MIT
// Hard cases 57 to 63: lights that are near, where they stop being like the sun. A floor under a plate, whose
// shadow a closed form knows.
#include <cmath>

#include "tests/hard_cases/hard_cases.h"
#include "tests/light_plate.h"
#include "tests/shot_run.h"

namespace penumbra::test {
namespace {

using Seen = std::function<double(const NearLight&, const glm::dvec3&)>;

struct Errors {
    double naive = 0, ours = 0;  // rms over all receivers
    size_t receivers = 0, soft = 0;
};

Shot lamp_shot(LightKind kind, const LightKey& at, double radius, double length = 1, double height = 1) {
    Shot shot = shot_with(kind, {160, 90});
    ShotLight& light = shot.lights.at("lamp");
    light.radius = radius;
    light.length = length;
    light.height = height;
    light.range = 500;
    light.keys = {at};
    return shot;
}

double exact(const NearLight& light, const glm::dvec3& p) {
    return light.visibility(p, plate);
}

NearLight light_of(const Shot& shot) {
    return NearLight(light_block(shot.lights.at("lamp"), 0, glm::dvec3(0)));
}

std::vector<float> mask_of(const Shot& shot, const std::vector<std::string>& settings = {}) {
    Diagnostics diagnostics;
    const auto session = open(shot, "light", settings, diagnostics);
    if (!session) throw std::runtime_error(diagnostics.text());
    session->run_frame(0, true);
    return captured_planes(session->view(), "visibility")[0];
}

Errors errors(const Shot& shot, const Seen& naive) {
    const std::vector<float> v = mask_of(shot);
    const auto points = floor_points(shot);
    const NearLight light = light_of(shot);
    Errors e;
    for (size_t i = 0; i < v.size(); ++i) {
        if (!points[i] || !light.reaches(*points[i])) continue;
        const double truth = exact(light, *points[i]);
        const double off = naive(light, *points[i]) - truth, ours = double(v[i]) - truth;
        e.naive += off * off;
        e.ours += ours * ours;
        e.soft += truth > 0 && truth < 1;
        ++e.receivers;
    }
    e.naive = std::sqrt(e.naive / double(e.receivers));
    e.ours = std::sqrt(e.ours / double(e.receivers));
    return e;
}

// What programs for the sun make of a lamp: the ball that holds it.
Seen as_a_ball(double radius) {
    return [radius](const NearLight& light, const glm::dvec3& p) {
        blocks::Light ball{};
        for (int c = 0; c < 3; ++c) ball.centre.v[c] = static_cast<float>(light.centre()[c]);
        ball.kind = blocks::LIGHT_SPHERE;
        ball.u.v[0] = static_cast<float>(radius);
        ball.range = 500;
        ball.cos_outer = -1;
        ball.on = 1;
        return exact(NearLight(ball), p);
    };
}

const glm::dvec3 down(0, -1, 0), along_x(1, 0, 0);

TEST_F(HardCase, ALargePanelJustAboveAPlateIsNoBall) {
    const Errors e = errors(
        lamp_shot(LightKind::rectangle, {0, {0, 1.02, 0}, down, along_x, 1, 1}, 0, 1.2, 1.2), as_a_ball(0.6));
    figure("case 57, error before a panel that hangs 2 cm above its blocker", e.naive, e.ours);
    EXPECT_GT(e.soft, 1000u);
    EXPECT_GT(e.naive, 0.05);
    EXPECT_LT(e.ours, 0.02);
}

Truth counted(const Shot& shot) {
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto session = open_light_truth(gpu(), shot, "lamp", diagnostics, warnings, false);
    if (!session) throw std::runtime_error(diagnostics.text());
    return counted_light_truth(*session, 0, 1024);
}

// Its plane passes among the receivers, so that a blocker lies before some and behind others: many rays say
// what is right.
TEST_F(HardCase, ALightSeenEdgeOnIsNoBall) {
    Shot shot = lamp_shot(LightKind::rectangle, {0, {-1.5, 0.9, 0}, {1, 0, 0}, {0, 1, 0}, 1, 1}, 0, 1.6, 1);
    shot.size = {64, 36};
    Shot ball = shot;
    ball.lights.at("lamp").kind = LightKind::sphere;
    ball.lights.at("lamp").radius = 0.5;
    const Truth right = counted(shot), naive = counted(ball);
    const std::vector<float> ours = mask_of(shot);
    double by_ball = 0, by_ours = 0;
    size_t receivers = 0, soft = 0;
    for (size_t i = 0; i < ours.size(); ++i) {
        if (right.receiver[i] == 0 || naive.receiver[i] == 0) continue;
        by_ball += std::pow(double(naive.visibility[i]) - double(right.visibility[i]), 2);
        by_ours += std::pow(double(ours[i]) - double(right.visibility[i]), 2);
        soft += right.visibility[i] > 0 && right.visibility[i] < 1;
        ++receivers;
    }
    by_ball = std::sqrt(by_ball / double(receivers));
    by_ours = std::sqrt(by_ours / double(receivers));
    figure("case 58, error where a light's plane is at right angles to the receivers'", by_ball, by_ours);
    EXPECT_GT(soft, 200u);
    EXPECT_GT(by_ball, 0.02);
    EXPECT_LT(by_ours, 0.01);
}

TEST_F(HardCase, InsideALightIsNobodysShadow) {
    const Shot shot = lamp_shot(LightKind::sphere, {0, {0, 0.5, 0}, down, along_x, 1, 1}, 0.9);
    const std::vector<float> v = mask_of(shot);
    const auto points = floor_points(shot);
    const glm::dvec3 centre(0, 0.5, 0);
    size_t inside = 0, dark = 0, nan = 0;
    for (size_t i = 0; i < v.size(); ++i) {
        if (!points[i] || glm::distance(*points[i], centre) > 0.89) continue;
        ++inside;
        nan += std::isnan(std::asin(0.9 / glm::distance(*points[i], centre)));
        dark += v[i] != 1;
    }
    figure("case 59, share of receivers inside a light that have no number, or a shadow",
           double(nan) / double(inside), double(dark) / double(inside));
    EXPECT_GT(inside, 300u);
    EXPECT_EQ(nan, inside);
    EXPECT_EQ(dark, 0u);
    EXPECT_EQ(nonfinite(v), 0u);
}

// A ray that ends a centimetre before its light, as rays to lights often do, does not see what is nearer.
TEST_F(HardCase, WhatIsHalfACentimetreFromALightStillHidesIt) {
    const Errors e = errors(lamp_shot(LightKind::disc, {0, {0.1, 1.005, 0}, down, along_x, 1, 1}, 0.02),
                            [](const NearLight&, const glm::dvec3&) { return 1.0; });
    figure("case 60, error of a lamp of 2 cm whose blocker is 5 mm away", e.naive, e.ours);
    EXPECT_GT(e.naive, 0.3);
    EXPECT_LT(e.ours, 0.01);
}

TEST_F(HardCase, ALightIsOfAnySize) {
    for (const double radius : {1e-5, 1e-3, 1.0, 60.0}) {
        const double height = 1.5 + 1.2 * radius;
        const Errors e =
            errors(lamp_shot(LightKind::disc, {0, {0.2, height, 0.1}, down, along_x, 1, 1}, radius),
                   as_a_ball(0.05));  // a size for all
        figure(("case 61, error before a disc of radius " + std::to_string(radius)).c_str(), e.naive, e.ours);
        EXPECT_GT(e.receivers, 3000u);
        EXPECT_GT(e.naive, 0.005) << radius;
        EXPECT_LT(e.ours, 0.004) << radius;
    }
}

// Lux on either side of the range, over what there is at half of it.
TEST_F(HardCase, ALightEndsWithoutAStep) {
    Shot shot = lamp_shot(LightKind::point, {0, {0, 2, 0}, down, along_x, 1, 1}, 0);
    ShotLight& light = shot.lights.at("lamp");
    light.range = 3.2;
    shot.size = {640, 360};
    const auto checked = shipped_pipeline("lights", {R"(outputs=["illuminance"])"}, test_nodes());
    SessionOptions options;
    options.size = shot.size;
    options.captures = checked.output_names();
    const auto session = open_session(checked, shot, options, test_nodes());
    session->run_frame(0, true);
    const std::vector<float> lux = captured_planes(session->view(), "illuminance")[0];
    const auto points = floor_points(shot);
    double last = 0, beyond = 0;
    size_t near_the_end = 0;
    for (size_t i = 0; i < lux.size(); ++i) {
        if (!points[i]) continue;
        const double d = glm::distance(*points[i], glm::dvec3(0, 2, 0));
        if (d > 3.201) beyond = std::max(beyond, double(lux[i]));
        if (d > 3.199 || d < 3.18) continue;
        last = std::max(last, double(lux[i]));
        ++near_the_end;
    }
    const double at_end = light.strength * 2 / (3.2 * 3.2 * 3.2), under = light.strength / 4;
    figure("case 62, the step at a light's range over the lux below it", at_end / under, last / under);
    EXPECT_GT(near_the_end, 50u);
    EXPECT_EQ(beyond, 0);
    EXPECT_GT(at_end / under, 0.1);
    EXPECT_LT(last / under, 0.01);
}

TEST_F(HardCase, ALightIsWhereItIsAMillionMetresAway) {
    const LightKey at{0, {0.213, 2.6177, 0.1}, down, along_x, 1, 1};
    const Shot near_by = lamp_shot(LightKind::sphere, at, 0.05);
    for (const double far : {1e6, 1e7}) {
        Shot away = near_by;
        away.origin = {far, 0, -far};
        const double ours = rms(mask_of(near_by), mask_of(away));
        // Positions of the world in fp32.
        const auto points = floor_points(near_by);
        const NearLight light = light_of(near_by);
        double squares = 0;
        size_t count = 0;
        const auto rounded = [&](glm::dvec3 p) {
            p += glm::dvec3(far, 0, -far);
            return glm::dvec3(glm::vec3(p)) - glm::dvec3(far, 0, -far);
        };
        Shot shifted = near_by;
        shifted.lights.at("lamp").keys[0].position = rounded(at.position);
        const NearLight naive = light_of(shifted);
        for (const auto& p : points) {
            if (!p) continue;
            const double error = exact(naive, rounded(*p)) - exact(light, *p);
            squares += error * error;
            ++count;
        }
        figure(("case 63, error with the origin " + std::to_string(far) + " m away").c_str(),
               std::sqrt(squares / double(count)), ours);
        EXPECT_GT(std::sqrt(squares / double(count)), 0.005);
        EXPECT_EQ(ours, 0);
    }
}

}  // namespace
}  // namespace penumbra::test
