// SPDX-License-Identifier: MIT
// The sheared gather before a light that is near: a straight edge of a closed form, as geometry through the
// whole shipped pipeline, against the sun's of the same width.
#include <fmt/format.h>

#include <cstdlib>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/quaternion.hpp>
#include <iterator>
#include <sstream>

#include "tests/edge_run.h"
#include "tests/light_plate.h"

namespace penumbra::test {
namespace {

// A plate over a floor that is seen from below it; its edge goes through the origin, and the light hangs over
// that. Everything lies level, so that the penumbra is as wide everywhere.
constexpr double edge_m = 1.25, light_m = 3.25, plate_half_m = 10, fov_deg = 30;

struct LampEdge {
    LightKind kind = LightKind::disc;
    Edge edge;
    bool turned = false;           // the world upside down: the light hangs straight below
    std::vector<LightKey> keys{};  // instead of one above the edge
};

double pixel_m(const Edge& edge) {
    return 2 * std::tan(glm::radians(fov_deg / 2)) / edge.size[1];
}

glm::dvec3 across(const Edge& edge) {  // the plate lies on this side
    const double angle = glm::radians(edge.edge_deg);
    return {std::cos(angle), 0, std::sin(angle)};
}

glm::dvec3 shift_at(const Edge& edge, double frame) {
    const double on_floor = (edge.offset_px + edge.speed_px * (frame - edge.last)) * pixel_m(edge);
    return across(edge) * -(on_floor * (light_m - edge_m) / light_m);
}

glm::dquat world_of(bool turned) {
    return glm::angleAxis(turned ? glm::pi<double>() : 0, glm::dvec3(1, 0, 0));
}

std::vector<std::byte> edge_glb(bool turned) {
    Model model;
    model.materials = {{{0.8f, 0.8f, 0.8f, 1}, -1}};
    const glm::dquat world = world_of(turned);
    const glm::dvec3 n = across(Edge{});
    add(model, "floor", ground(plate_half_m, plate_half_m, 1, 1), 0);
    model.nodes.back().rotation = world;
    add(model, "plate", ground(plate_half_m, plate_half_m, 1, 1), 0);
    Node& over = model.nodes.back();
    over.rotation = world * glm::angleAxis(std::atan2(-n.z, n.x), glm::dvec3(0, 1, 0));
    over.translation = world * (plate_half_m * n + glm::dvec3(0, edge_m, 0));
    return to_glb(model);
}

const fs::path& edge_file(bool turned) {
    static const SceneFile level("edge.glb", edge_glb(false)), upside_down("edge.glb", edge_glb(true));
    return (turned ? upside_down : level).path();
}

Shot shot_of(const LampEdge& lamp) {
    const Edge& edge = lamp.edge;
    // Half of what the light spans across the edge.
    const double half = 0.5 * edge.width_px * pixel_m(edge) * (light_m - edge_m) / edge_m;
    const double along_deg = edge.edge_deg + 25, c = std::cos(glm::radians(25.0)),
                 s = std::sin(glm::radians(25.0));
    ShotLight light;
    light.kind = lamp.kind;
    light.radius = half;
    light.length = light.height = 2 * half / (c + s);
    light.range = 100;
    light.strength = 1;
    const glm::dvec3 along{std::cos(glm::radians(along_deg)), 0, std::sin(glm::radians(along_deg))};
    light.keys = lamp.keys;
    if (light.keys.empty()) light.keys = {{0, {0, light_m, 0}, {0, -1, 0}, along, 1, 1}};
    const glm::dquat world = world_of(lamp.turned);
    for (LightKey& key : light.keys) {
        key.position = world * key.position;
        key.direction = world * key.direction;
        key.along = world * key.along;
    }
    Shot shot;
    shot.name = "lamp_edge";
    shot.model = edge_file(lamp.turned);
    shot.size = edge.size;
    shot.frames = edge.last + 1;
    shot.vertical_fov_deg = fov_deg;
    shot.camera = {{0, world * glm::dvec3(0, 1, 0), {0, 0, 0}, world * glm::dvec3(0, 0, -1)}};
    shot.has_sun = false;
    shot.sun = {{0, {0, 1, 0}}};
    shot.lights["lamp"] = light;
    ObjectMotion motion;
    motion.keys = {{0, world * shift_at(edge, 0), glm::dvec3(0)}};
    if (edge.speed_px != 0)
        motion.keys.push_back({double(edge.last), world * shift_at(edge, edge.last), glm::dvec3(0)});
    shot.objects["plate"] = motion;
    return shot;
}

std::vector<float> truth_of(const LampEdge& lamp) {
    const Edge& edge = lamp.edge;
    LampEdge level = lamp;
    level.turned = false;
    const Shot shot = shot_of(level);
    const NearLight light(light_block(shot.lights.at("lamp"), edge.last, glm::dvec3(0)));
    const glm::dvec3 n = across(edge), t(-n.z, 0, n.x),
                     o = glm::dvec3(0, edge_m, 0) + shift_at(edge, edge.last);
    const double l = 2 * plate_half_m, h = plate_half_m;
    const std::array<glm::dvec3, 4> corners{o - h * t, o - h * t + l * n, o + h * t + l * n, o + h * t};
    std::vector<float> image;
    for (uint32_t y = 0; y < edge.size[1]; ++y)
        for (uint32_t x = 0; x < edge.size[0]; ++x) {
            const double px = pixel_m(edge);
            const glm::dvec3 p((x + 0.5 - 0.5 * edge.size[0]) * px, 0, (y + 0.5 - 0.5 * edge.size[1]) * px);
            image.push_back(static_cast<float>(light.visibility(p, corners)));
        }
    return image;
}

std::vector<float> mask_of(const LampEdge& lamp, const char* pipeline,
                           const std::vector<std::string>& settings) {
    Diagnostics diagnostics;
    const auto session = open(shot_of(lamp), pipeline, settings, diagnostics);
    if (!session) throw std::runtime_error(diagnostics.text());
    for (uint32_t i = 0; i <= lamp.edge.last; ++i) session->run_frame(i, i == 0);
    return captured_planes(session->view(), "visibility")[0];
}

double n_eff_of(const LampEdge& lamp, const char* pipeline, const std::vector<std::string>& settings = {}) {
    return n_eff(mask_of(lamp, pipeline, settings), truth_of(lamp), inside_of(lamp.edge));
}

std::vector<double> numbers(const char* name, const char* otherwise) {
    const char* value = std::getenv(name);
    std::stringstream text(value ? value : otherwise);
    return {std::istream_iterator<double>(text), {}};
}

class LampGather : public GpuTest {};

// PENUMBRA_WIDTHS, _SPEEDS, _FRAME and _OFFSETS, places of the edge within a pixel over which errors are
// averaged, make the table of docs/lights.md.
TEST_F(LampGather, StraightEdgesAreWorthWhatTheSunsAre) {
    const auto last = static_cast<uint32_t>(numbers("PENUMBRA_FRAME", "7").at(0));
    const std::vector<double> offsets = numbers("PENUMBRA_OFFSETS", "0.37");
    for (const double width : numbers("PENUMBRA_WIDTHS", "8"))
        for (const double speed : numbers("PENUMBRA_SPEEDS", "0 -0.5")) {
            std::array<double, 4> errors{};
            for (const double offset : offsets) {
                const Edge edge{width, speed, last, offset};
                errors[0] += 1 / n_eff_inside(edge, ShotRun("shadows_fast", shot_of(edge)).up_to(last));
                int i = 0;
                for (const LightKind kind : {LightKind::disc, LightKind::rectangle, LightKind::sphere})
                    errors[++i] += 1 / n_eff_of({kind, edge}, "light_shadows");
            }
            const double n = double(offsets.size());
            std::printf("%4g px, %5g px per frame: sun %.4g, disc %.4g, rectangle %.4g, sphere %.4g\n", width,
                        speed, n / errors[0], n / errors[1], n / errors[2], n / errors[3]);
            std::fflush(stdout);
            for (const int i : {1, 2, 3})
                EXPECT_LT(errors[i], 1.5 * errors[0]) << width << " " << speed << " " << i;
        }
}

// How much too light the light half is and too dark the other, mean over the penumbra.
double steepness(const std::vector<float>& truth, const std::vector<float>& image) {
    double sum = 0, n = 0;
    for (size_t i = 0; i < truth.size(); ++i) {
        if (truth[i] < 0.03 || truth[i] > 0.97) continue;
        sum += (double(image[i]) - truth[i]) * (truth[i] < 0.5 ? -1 : 1);
        ++n;
    }
    return sum / n;
}

// Noise averages out over frames; a frame that counts for more when it says lit or dark leaves a bias.
TEST_F(LampGather, StillPenumbraeAreNotTooSteep) {
    for (const LightKind kind : {LightKind::disc, LightKind::rectangle}) {
        double sum = 0;
        const std::vector<double> offsets{0.37, 3.1};
        for (const double offset : offsets) {
            const LampEdge lamp{kind, {8, 0, 63, offset}};
            sum += steepness(truth_of(lamp), mask_of(lamp, "light_shadows", {}));
        }
        std::printf("%s: %.4f\n", name_of(kind), sum / double(offsets.size()));
        EXPECT_LT(sum / double(offsets.size()), 0.001);
    }
}

// Within its half sides of 3 px are 29 neighbours, so that a larger part of those asked lies at the rim.
TEST_F(LampGather, ASquareThatStandsStillIsWorthTwoThirdsOfTheSun) {
    std::array<double, 2> errors{};
    for (const double offset : {0.37, 3.1}) {
        const Edge edge{9, 0, 63, offset};
        errors[0] += 1 / n_eff_inside(edge, ShotRun("shadows_fast", shot_of(edge)).up_to(63));
        errors[1] += 1 / n_eff_of({LightKind::rectangle, edge}, "light_shadows");
    }
    EXPECT_LT(errors[1], 1.5 * errors[0]);
}

// No neighbour's ray tests a disc of one pixel, and their means would be noise to its own.
TEST_F(LampGather, NarrowPenumbraeThatStandStillAreTheirOwnRays) {
    double error = 0;
    for (const double offset : {0.37, 3.1}) {
        const LampEdge lamp{LightKind::disc, {2, 0, 63, offset}};
        error += 1 / n_eff_of(lamp, "light_shadows");
    }
    std::printf("%.4g\n", 2 / error);
    EXPECT_GT(2 / error, 6000);
}

// A field of axes over all directions has a whirl somewhere: here the image's middle looks at it.
TEST_F(LampGather, ASphereStraightBelowIsAsGoodAsOneAbove) {
    std::array<double, 2> errors{};
    for (const double offset : {-6.0, -3.0, 0.0, 3.0, 6.0})
        for (const bool turned : {false, true}) {
            const LampEdge lamp{LightKind::sphere, {16, 0, 0, offset, {96, 96}}, turned};
            errors[turned] +=
                1 / n_eff(mask_of(lamp, "light_shadows", {}), truth_of(lamp), inside_of(lamp.edge, 36));
        }
    std::printf("above %.4g, below %.4g\n", 5 / errors[0], 5 / errors[1]);
    EXPECT_LT(errors[1], 1.12 * errors[0]);
}

// Half of it is below the floor, and a plate hides some of the rest.
TEST_F(LampGather, WhatTheFloorHidesOfALightIsKnown) {
    LampEdge lamp{LightKind::rectangle, {16, 0, 0}};
    Shot shot = shot_of(lamp);
    ShotLight& light = shot.lights.at("lamp");
    light.length = light.height = 1;
    light.keys = {{0, {2, 0, 0}, {-1, 0, 0}, {0, 0, 1}, 1, 1}};
    shot.objects["plate"].keys = {{0, {1, -1, 0}, glm::dvec3(0)}};
    Diagnostics diagnostics;
    const auto session = open(shot, "light_shadows", {}, diagnostics);
    ASSERT_TRUE(session) << diagnostics.text();
    session->run_frame(0, true);
    std::vector<std::string> warnings;
    const auto truth = open_light_truth(gpu(), shot, "lamp", diagnostics, warnings, false);
    ASSERT_TRUE(truth) << diagnostics.text();
    const Truth counted = counted_light_truth(*truth, 0, 1024);
    const double n =
        n_eff(captured_planes(session->view(), "visibility")[0], counted.visibility, inside_of(lamp.edge));
    std::printf("%.4g\n", n);
    EXPECT_GT(n, 1450);
}

LightKey key_at(double frame, double x, double power = 1) {
    return {frame, {x, light_m, 0}, {0, -1, 0}, {1, 0, 0}, 1, power};
}

// Between two frames the light jumps: the past is of another one.
TEST_F(LampGather, ALightThatJumpsLeavesNoGhost) {
    for (const LightKind kind : {LightKind::disc, LightKind::rectangle}) {
        const LampEdge fresh{kind, {8, 0, 0}, false, {key_at(0, -0.4)}};
        const LampEdge jumped{kind, {8, 0, 7}, false, {key_at(6, 0.4), key_at(7, -0.4)}};
        const double first = n_eff_of(fresh, "light_shadows"), after = n_eff_of(jumped, "light_shadows"),
                     naive = n_eff_of(jumped, "light_shadows", {"inputs.light_prev=null"});
        std::printf("%s: first frame %.4g, after a jump %.4g, without the light's past %.4g\n", name_of(kind),
                    first, after, naive);
        EXPECT_GT(after, 0.15 * first);  // where the past was of one kind not every pixel has a ray
        EXPECT_LT(naive, 0.01 * first);
    }
}

// It is off from frame 6 to 11, and on again elsewhere.
TEST_F(LampGather, ALightThatWasOffLeavesNoGhost) {
    const std::vector<LightKey> keys{key_at(0, 0.4), key_at(5, 0.4), key_at(6, 0.4, 0), key_at(10, -0.4, 0),
                                     key_at(11, -0.4)};
    for (const float v : mask_of({LightKind::disc, {8, 0, 6}, false, keys}, "light_shadows", {}))
        ASSERT_EQ(v, 1);
    const double first = n_eff_of({LightKind::disc, {8, 0, 0}, false, {key_at(0, -0.4)}}, "light_shadows");
    EXPECT_GT(n_eff_of({LightKind::disc, {8, 0, 11}, false, keys}, "light_shadows"), 0.5 * first);
}

}  // namespace
}  // namespace penumbra::test
