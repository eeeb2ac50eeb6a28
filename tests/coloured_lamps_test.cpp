// SPDX-License-Identifier: MIT
// Coloured shadows of lights that are near: a pane of glass before each kind of light, whose share of the
// light is known in closed form, by one light alone, by several in one pass, and in the truth. And whom a
// pane colours nothing: it hangs behind the light, or the light does not reach so far.
#include <algorithm>

#include "tests/light_plate.h"
#include "tests/ray_maker.h"
#include "tests/scene_file.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"

namespace penumbra::test {
namespace {

const glm::dvec3 red(0.9, 0.35, 0.1);
constexpr double stored = 0.5 / 255 + 1e-3;  // rounding: of the image, and of maps of panes

Material glass(const glm::dvec3& color) {
    Material material;
    material.base_color = {float(color.x), float(color.y), float(color.z), 1};
    material.transmission = 1;
    return material;
}

// A floor, and over it a rectangle of glass `height` metres above, as large as light_plate.h's plate or
// larger; an opaque one where it is not nothing.
Model floor_and_pane(double height, float scale = 1, std::optional<double> opaque = {}) {
    Model model;
    model.materials = {{{0.8f, 0.8f, 0.8f, 1}}, glass(red)};
    add(model, "floor", ground(10, 10, 4, 4), 0);
    const auto hang = [&](const char* name, double y, float size, int material) {
        add(model, name, ground(0.4 * double(size), 0.3 * double(size), 1, 1), material);
        model.nodes.back().translation = {0, float(y), 0};
    };
    hang("pane", height, scale, 1);
    if (opaque) hang("plate", *opaque, 1, 0);
    return model;
}

struct Colours {
    std::vector<glm::dvec3> transmittance, lux;
    std::vector<double> visibility;
};

std::vector<glm::dvec3> light_of(const Session& session, const char* name) {
    const auto planes = captured_planes(session.view(), name);
    std::vector<glm::dvec3> out;
    for (size_t i = 0; i < planes[0].size(); ++i) out.emplace_back(planes[0][i], planes[1][i], planes[2][i]);
    return out;
}

std::unique_ptr<Session> shown(const Shot& shot, const char* pipeline, std::vector<std::string> captures,
                               const std::vector<std::string>& settings = {}, const Facts& facts = {}) {
    SessionOptions options;
    options.size = shot.size;
    options.jitter = false;
    options.captures = std::move(captures);
    options.facts = facts;
    auto session =
        open_session(shipped_pipeline(pipeline, settings, test_nodes()), shot, options, test_nodes());
    session->run_frame(0, true);
    return session;
}

std::vector<glm::dvec3> colours_of(const Session& session, const char* name) {
    std::vector<glm::dvec3> out;
    for (const auto& t : captured_values<std::array<uint8_t, 4>>(session, name))
        out.emplace_back(t[0] / 255.0, t[1] / 255.0, t[2] / 255.0);
    return out;
}

Colours seen_alone(const Shot& shot) {
    const auto session = shown(shot, "light", {"transmittance", "visibility"});
    Colours out{colours_of(*session, "transmittance"), {}, {}};
    const auto planes = captured_planes(session->view(), "visibility");
    out.visibility.assign(planes[0].begin(), planes[0].end());
    return out;
}

// Of the pipeline for several, whose only light it is.
Colours seen_among_several(const Shot& shot, const Facts& facts = {}) {
    const auto session = shown(shot, "lights", {"transmittances", "masks", "illuminance"},
                               {R"(outputs=["transmittances","masks","illuminance"])"}, facts);
    Colours out{colours_of(*session, "transmittances"), light_of(*session, "illuminance"), {}};
    for (const uint8_t v : captured_values<uint8_t>(*session, "masks")) out.visibility.push_back(v / 255.0);
    return out;
}

struct Errors {
    size_t soft = 0, clear = 0, covered = 0;
    double mean = 0, rms = 0;
};

// Against the pane's colour times its share of the light; whoever sees all of the light through it, or none.
Errors errors_of(const std::vector<glm::dvec3>& seen, const Shot& shot) {
    const NearLight light(light_block(shot.lights.at("lamp"), 0, glm::dvec3(0)));
    const auto points = floor_points(shot);
    Errors out;
    for (size_t i = 0; i < points.size(); ++i) {
        if (!points[i] || !light.reaches(*points[i])) continue;
        const double open = light.visibility(*points[i], plate);
        const glm::dvec3 error = seen[i] - (1.0 - (1.0 - red) * (1 - open));
        if (open == 1) {
            EXPECT_EQ(seen[i], glm::dvec3(1)) << i;
        }
        if (open == 0) {
            EXPECT_LT(glm::length(error), 2 * stored) << i;
        }
        out.clear += open == 1;
        out.covered += open == 0;
        if (!(open > 0.02 && open < 0.98)) continue;
        ++out.soft;
        out.mean += (error.x + error.y + error.z) / 3;
        out.rms += glm::dot(error, error) / 3;
    }
    out.mean /= double(out.soft);
    out.rms = std::sqrt(out.rms / double(out.soft));
    return out;
}

class ColouredLamps : public GpuTest, public ::testing::WithParamInterface<LightKind> {};

// Sixteen rays are stratified over the light: along an edge at most every fourth is in doubt.
TEST_P(ColouredLamps, APaneTakesItsColourTimesItsShareOfTheLight) {
    Shot shot = shot_with(GetParam(), {192, 108});
    const SceneFile file("pane.glb", to_glb(floor_and_pane(plate_m)));
    shot.model = file.path();
    for (const Colours& seen : {seen_alone(shot), seen_among_several(shot)}) {
        EXPECT_EQ(*std::ranges::min_element(seen.visibility), 1);  // nothing opaque: the mask stays as it is
        const Errors errors = errors_of(seen.transmittance, shot);
        std::printf("%s: %zu soft pixels, bias %.5f, RMSE %.4f\n", name_of(GetParam()), errors.soft,
                    errors.mean, errors.rms);
        EXPECT_GT(errors.soft, 300u);
        EXPECT_GT(errors.clear, 1000u);
        EXPECT_LT(std::abs(errors.mean), 3e-3);
        EXPECT_LT(errors.rms, 0.05);
    }
}

INSTANTIATE_TEST_SUITE_P(Kinds, ColouredLamps,
                         ::testing::Values(LightKind::point, LightKind::sphere, LightKind::disc,
                                           LightKind::rectangle, LightKind::tube, LightKind::spot),
                         [](const auto& test) { return std::string(name_of(test.param)); });

class ColouredLampsTruth : public GpuTest {};

TEST_F(ColouredLampsTruth, IsTheClosedForm) {
    Shot shot = shot_with(LightKind::rectangle, {40, 24});
    const SceneFile file("pane.glb", to_glb(floor_and_pane(plate_m)));
    shot.model = file.path();
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto session = open_light_truth(gpu(), shot, "lamp", diagnostics, warnings, false);
    ASSERT_TRUE(session) << diagnostics.text();
    const penumbra::Truth truth = counted_light_truth(*session, 0, 4096);
    ASSERT_FALSE(truth.transmittance[0].empty());
    std::vector<glm::dvec3> seen;
    for (size_t i = 0; i < truth.visibility.size(); ++i) {
        EXPECT_EQ(truth.visibility[i], 1) << i;
        seen.emplace_back(truth.transmittance[0][i], truth.transmittance[1][i], truth.transmittance[2][i]);
    }
    const Errors errors = errors_of(seen, shot);
    EXPECT_GT(errors.soft, 20u);
    EXPECT_LT(std::abs(errors.mean), 2e-4);
    EXPECT_LT(errors.rms, 8e-4);
    // The same in rounds, as the viewer counts it.
    TruthRounds rounds(light_pixels(*session, 0), session->plan().extent, 16, 1);
    while (rounds.rounds() == 0) rounds.work(1e9);
    const penumbra::Truth again = rounds.truth();
    ASSERT_FALSE(again.transmittance[0].empty());
    for (size_t i = 0; i < seen.size(); ++i) {
        if (again.receiver[i] == 0) continue;
        EXPECT_NEAR(again.transmittance[2][i], seen[i].z, 0.06) << i;
    }
}

class ColouredLampsReach : public GpuTest {};

// The pane hangs over all of the light, seen from everywhere; a ray that went on would meet it.
TEST_F(ColouredLampsReach, APaneBehindTheLightColoursNothing) {
    for (const LightKind kind : {LightKind::point, LightKind::rectangle}) {
        Shot shot = shot_with(kind, {64, 36});
        const SceneFile file("behind.glb", to_glb(floor_and_pane(3.2, 20)));
        shot.model = file.path();
        for (const Colours& seen : {seen_alone(shot), seen_among_several(shot)})
            EXPECT_EQ(std::ranges::count(seen.transmittance, glm::dvec3(1)), 64 * 36) << name_of(kind);
    }
}

// Who is out of range has no shadow of the light, coloured or not: 1, as in the mask.
TEST_F(ColouredLampsReach, WhereTheLightEndsNothingIsColoured) {
    Shot shot = shot_with(LightKind::disc, {96, 54});
    const SceneFile file("over.glb", to_glb(floor_and_pane(plate_m, 20)));
    shot.model = file.path();
    const NearLight light(light_block(shot.lights.at("lamp"), 0, glm::dvec3(0)));
    const auto points = floor_points(shot);
    for (const Colours& seen : {seen_alone(shot), seen_among_several(shot)}) {
        size_t beyond = 0, within = 0;
        for (size_t i = 0; i < points.size(); ++i) {
            if (!points[i] || std::abs(glm::length(*points[i] - light.centre()) - 3.4) < 0.01) continue;
            const bool reached = light.reaches(*points[i]);
            const glm::dvec3 expected = reached ? red : glm::dvec3(1);
            EXPECT_LT(glm::length(seen.transmittance[i] - expected), 2 * stored) << i;
            ++(reached ? within : beyond);
        }
        EXPECT_GT(std::min(within, beyond), 500u);
    }
}

// Where an opaque plate hides a part of the light and the pane another, the colour is of the rest; one light
// by itself and among several is the same but for how masks are rounded, and what it shines is as coloured.
TEST_F(ColouredLampsReach, OneLightIsTheSameAmongSeveral) {
    Shot shot = shot_with(LightKind::disc, {192, 108});
    shot.lights.at("lamp").range = 1e9;
    shot.lights.at("lamp").strength = 100;
    Shot bare = shot;
    const SceneFile file("both.glb", to_glb(floor_and_pane(plate_m + 0.3, 1, plate_m)));
    const SceneFile empty("none.glb", to_glb(floor_and_pane(50)));
    shot.model = file.path();
    bare.model = empty.path();
    const Colours alone = seen_alone(shot), several = seen_among_several(shot);
    const std::vector<glm::dvec3> unshaded = seen_among_several(bare).lux;
    size_t mixed = 0;
    for (size_t i = 0; i < alone.transmittance.size(); ++i) {
        const glm::dvec3 t = several.transmittance[i];
        EXPECT_LT(glm::length(alone.transmittance[i] - t), 4.5 / 255) << i;
        for (glm::length_t c = 0; c < 3; ++c)
            EXPECT_NEAR(several.lux[i][c], t[c] * unshaded[i][c], unshaded[i][c] * 3 / 255 + 1e-6) << i;
        mixed +=
            several.visibility[i] > 0.1 && several.visibility[i] < 0.9 && t.z < 0.9 * several.visibility[i];
    }
    EXPECT_GT(mixed, 100u);
}

// By rays alone, where a host has no tree: the small tree is walked all the same.
TEST_F(ColouredLampsReach, WithoutATreeTheyAreColouredAsWell) {
    if (!gpu().caps().ray_query) GTEST_SKIP() << "the device has no ray queries";
    Shot shot = shot_with(LightKind::disc, {48, 27});
    const SceneFile file("over.glb", to_glb(floor_and_pane(plate_m)));
    shot.model = file.path();
    const Colours tree = seen_among_several(shot), queries = seen_among_several(shot, {{"tree", false}});
    size_t coloured = 0;
    for (size_t i = 0; i < tree.transmittance.size(); ++i) {
        EXPECT_EQ(tree.transmittance[i], queries.transmittance[i]) << i;
        coloured += tree.transmittance[i] != glm::dvec3(1);
    }
    EXPECT_GT(coloured, 50u);
}

}  // namespace
}  // namespace penumbra::test
