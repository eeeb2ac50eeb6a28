// SPDX-License-Identifier: MIT
// Translucent triangles from the file to coloured light: what a material lets through, that a scene without
// any has the plan that it had, and closed forms of panes over a floor under a disc sun, by both backends.
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

#include "app/session.h"
#include "host/models/glb_writer.h"
#include "host/models/gltf.h"
#include "host/models/translucency.h"
#include "host/truth/counted_visibility.h"
#include "host/truth/sun_visibility.h"
#include "penumbra/dump.h"
#include "tests/gpu_test.h"
#include "tests/ray_maker.h"
#include "tests/scene_file.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"

namespace penumbra::test {
namespace {

namespace fs = std::filesystem;

Material glass(const glm::vec3& color) {
    Material material;
    material.base_color = {color.x, color.y, color.z, 1};
    material.transmission = 1;
    return material;
}

Material film(float alpha) {
    Material material;
    material.base_color = {0.2f, 0.5f, 0.3f, alpha};
    material.alpha_blend = true;
    return material;
}

constexpr double steps = 1023;  // of a channel of a transmittance map

glm::dvec3 only_texel(const Model& model, const Material& material) {
    const TransmittanceMap map = transmittance_map(model, material);
    EXPECT_EQ(map.texels.size(), 1u);
    return unpack_transmittance(map.texels.at(0));
}

void expect_near(const glm::dvec3& value, const glm::dvec3& expected, double within) {
    for (glm::length_t c = 0; c < 3; ++c) EXPECT_NEAR(value[c], expected[c], within) << "channel " << c;
}

TEST(Translucency, IsWhatBlendingLeavesAndWhatTheWallTints) {
    Model model;
    expect_near(only_texel(model, film(0.3f)), glm::dvec3(0.7), 0.5 / steps);  // whatever its colour
    expect_near(only_texel(model, glass({0.9f, 0.4f, 0.1f})), {0.9, 0.4, 0.1}, 0.5 / steps);
    Material both = glass({0.9f, 0.4f, 0.1f});
    both.alpha_blend = true;
    both.base_color[3] = 0.5f;
    both.transmission = 0.8f;
    expect_near(only_texel(model, both), 0.5 + 0.4 * glm::dvec3(0.9, 0.4, 0.1), 0.5 / steps);
    both.metallic = 0.5f;
    expect_near(only_texel(model, both), 0.5 + 0.2 * glm::dvec3(0.9, 0.4, 0.1), 0.5 / steps);
}

TEST(Translucency, OfTexturesIsLinearAndOfTheirLargestSize) {
    Model model;
    model.textures = {{2, 1, {188, 188, 188, 255, 255, 255, 255, 51}},
                      {1, 2, {255, 0, 0, 255, 0, 0, 0, 255}}};
    Material material = glass({1, 1, 1});
    material.alpha_blend = true;
    material.texture = 0;
    material.transmission_texture = 1;
    const TransmittanceMap map = transmittance_map(model, material);
    ASSERT_EQ(map.width, 2u);
    ASSERT_EQ(map.height, 2u);
    const double half = std::pow((188 / 255.0 + 0.055) / 1.055, 2.4);  // of the sRGB curve, nearly one half
    expect_near(unpack_transmittance(map.texels[0]), glm::dvec3(half), 0.5 / steps);
    expect_near(unpack_transmittance(map.texels[1]), glm::dvec3(1), 0);
    expect_near(unpack_transmittance(map.texels[2]), glm::dvec3(0), 0);
    expect_near(unpack_transmittance(map.texels[3]), glm::dvec3(0.8), 0.5 / steps);
}

TEST(Translucency, IsOfMaterialsThatLetSomethingThrough) {
    Model model;
    model.textures = {{1, 1, {255, 255, 255, 255}}};
    Material metal = glass({1, 1, 1}), solid = film(1), masked = glass({1, 1, 1});
    metal.metallic = 1;
    solid.texture = 0;
    masked.alpha_cutoff = 0.5;
    model.materials = {{}, metal, solid, masked, film(0.9f), glass({0.1f, 0, 0})};
    const std::vector<bool> expected{false, false, false, true, true, true};
    for (size_t i = 0; i < expected.size(); ++i)
        EXPECT_EQ(is_translucent(model, static_cast<int>(i)), expected[i]) << i;
    EXPECT_FALSE(is_translucent(model, -1));
}

// What is not quite opaque is, as exporters write whole models of it; a factor counts as a texel does.
TEST(Translucency, BeginsBelowAnAlphaThatIsNearlyOne) {
    Model model;
    model.textures = {{2, 1, {9, 9, 9, 255, 9, 9, 9, 250}}, {2, 1, {9, 9, 9, 250, 9, 9, 9, 249}}};
    Material opaque = film(1), hair = film(1), faint = film(0.9f), tinted = film(1);
    opaque.texture = tinted.texture = 0;
    hair.texture = faint.texture = 1;
    tinted.transmission = 0.5f;
    model.materials = {opaque, film(0.99f), hair, faint, tinted};
    const std::vector<bool> translucent{false, false, true, true, true},
        seen{true, false, true, false, false};
    for (size_t i = 0; i < translucent.size(); ++i) {
        EXPECT_EQ(is_translucent(model, static_cast<int>(i)), translucent[i]) << i;
        EXPECT_EQ(has_opaque_texels(model, model.materials[i]), seen[i]) << i;
        EXPECT_FALSE(is_alpha_tested(model, static_cast<int>(i))) << i;
    }
    const TransmittanceMap map = transmittance_map(model, hair);
    EXPECT_EQ(map.texels[0], 0u);
    expect_near(unpack_transmittance(map.texels[1]), glm::dvec3(6 / 255.0), 0.5 / steps);
}

// A horizontal rectangle, u along x.
Shape sheet(double x0, double x1, double y, double z0 = -30, double z1 = 30) {
    Shape shape;
    for (const glm::vec2 uv : {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1), glm::vec2(0, 1)}) {
        shape.positions.emplace_back(x0 + (x1 - x0) * double(uv.x), y, z0 + (z1 - z0) * double(uv.y));
        shape.uv.push_back(uv);
    }
    shape.indices = {0, 2, 1, 0, 3, 2};
    return shape;
}

TEST(TranslucentGltf, ComesBackAsItWasWritten) {
    Model model;
    model.textures = {{1, 1, {255, 255, 255, 99}}, {1, 1, {99, 0, 0, 255}}};
    Material both = glass({0.25f, 0.5f, 1});
    both.alpha_blend = true;
    both.transmission = 0.75f;
    both.texture = 0;
    both.transmission_texture = 1;
    model.materials = {both, {}};
    add(model, "pane", sheet(-1, 1, 1), 0);
    add(model, "floor", ground(2, 2, 1, 1), 1);
    const SceneFile file("panes.glb", to_glb(model));
    Diagnostics diagnostics;
    const auto read = load_gltf(file.path(), diagnostics);
    ASSERT_TRUE(read) << diagnostics.text();
    EXPECT_TRUE(read->warnings.empty()) << read->warnings.front();
    EXPECT_TRUE(read->materials[0].alpha_blend);
    EXPECT_EQ(read->materials[0].transmission, 0.75f);
    EXPECT_EQ(read->materials[0].transmission_texture, 1);
    EXPECT_FALSE(read->materials[1].alpha_blend);
    EXPECT_EQ(read->materials[1].transmission, 0);
}

// Without the fact the plan is, but for saying so, byte for byte that of the pipeline without the node.
TEST(TranslucentFact, CostsNothingWhereItDoesNotHold) {
    const auto plan_of = [&](const CheckedPipeline& pipeline, bool translucent) {
        Target target;
        target.extent = {640, 360};
        target.device = reference_device();
        target.facts["translucent"] = translucent;
        Diagnostics diagnostics;
        auto plan = compile(pipeline, target, {}, diagnostics);
        if (!plan) throw std::runtime_error(diagnostics.text());
        return std::move(*plan);
    };
    const auto text_of = [](const Plan& plan) {
        std::string text = to_text(plan);
        const std::string culled = "  culled transmit (if sun_up & translucent)\n";
        if (const size_t at = text.find(culled); at != std::string::npos) text.erase(at, culled.size());
        return text;
    };
    for (const char* name : {"hybrid_shadows", "one_ray", "shadows", "many_rays"}) {
        SCOPED_TRACE(name);
        const CheckedPipeline with = shipped_pipeline(name),
                              without =
                                  shipped_pipeline(name, {"nodes.transmit=null", "inputs.translucents=null",
                                                          "inputs.translucent_texels=null"});
        const Plan holds_not = plan_of(with, false), never = plan_of(without, false);
        EXPECT_EQ(text_of(holds_not), text_of(never));
        EXPECT_TRUE(holds_not.modules == never.modules);
        EXPECT_NE(text_of(plan_of(with, true)).find("transmit"), std::string::npos);
    }
}

constexpr uint32_t width = 160, height = 48;
constexpr double sheet_height = 2, radius_deg = 6, radius = radius_deg * std::numbers::pi / 180;

// A floor under a sun in the zenith, seen from below whatever hangs over it.
Shot shot_of(const fs::path& model) {
    Shot shot;
    shot.name = "panes";
    shot.model = model;
    shot.size = {width, height};
    shot.frames = 2;
    shot.vertical_fov_deg = 60;
    shot.camera = {{0, {0, 0.95, 0.001}, {0, 0, 0}, {0, 1, 0}}};
    shot.sun_angular_radius_deg = radius_deg;
    shot.sun = {{0, {0, 1, 0}}};
    return shot;
}

struct Seen {
    std::vector<glm::dvec3> color;
    std::vector<double> visibility, x;  // metres
    std::vector<float> depth;
    std::vector<std::byte> bytes;
};

Seen render(const Model& model, const std::vector<std::string>& settings = {},
            std::optional<uint32_t> poison = {}, const decltype(Shot::objects)& moving = {}) {
    const SceneFile file("floor.glb", to_glb(model));
    Shot shot = shot_of(file.path());
    shot.objects = moving;
    SessionOptions options;
    options.size = shot.size;
    options.jitter = false;
    options.poison = poison;
    options.captures = {"transmittance", "visibility", "view_depth"};
    const auto session = open_session(shipped_pipeline("hybrid_shadows", settings), shot, options);
    session->run_frame(0, true);
    session->run_frame(1, false);
    Seen seen;
    const auto texels = captured_values<std::array<uint8_t, 4>>(*session, "transmittance");
    const auto visibility = captured_values<uint16_t>(*session, "visibility");
    seen.depth = captured_values<float>(*session, "view_depth");
    const double across = std::tan(0.5 * glm::radians(shot.vertical_fov_deg)) * width / height;
    for (size_t i = 0; i < texels.size(); ++i) {
        seen.color.emplace_back(texels[i][0] / 255.0, texels[i][1] / 255.0, texels[i][2] / 255.0);
        seen.visibility.push_back(glm::detail::toFloat32(static_cast<short>(visibility[i])));
        seen.x.push_back(((double(i % width) + 0.5) / width * 2 - 1) * across * double(seen.depth[i]));
    }
    const auto bytes = session->view().captured("transmittance");
    seen.bytes.assign(bytes.begin(), bytes.end());
    return seen;
}

// What a point of the floor sees of the sun to the right of an edge at `edge`, sheet_height above.
double right_of(double x, double edge) {
    return half_plane_visibility(std::atan2(x - edge, sheet_height), radius);
}

struct Errors {
    double rms = 0, largest = 0, mean = 0;
    size_t pixels = 0;  // where the truth is neither end
};

// `truth` of x, for each channel; of pixels where it is between its ends.
template <class Truth>
Errors errors_of(const Seen& seen, const Truth& truth) {
    Errors out;
    for (size_t i = 0; i < seen.x.size(); ++i) {
        const glm::dvec3 error = seen.color[i] - truth(seen.x[i]);
        double largest = 0;
        for (glm::length_t c = 0; c < 3; ++c) largest = std::max(largest, std::abs(error[c]));
        out.largest = std::max(out.largest, largest);
        if (largest <= 0.5 / 255 + 0.5 / steps) continue;
        ++out.pixels;
        out.rms += glm::dot(error, error) / 3;
        out.mean += (error.x + error.y + error.z) / 3;
    }
    const double all = double(seen.x.size());
    out.rms = std::sqrt(out.rms / all);
    out.mean /= all;
    return out;
}

constexpr double stored = 0.5 / 255 + 1e-3;  // rounding: of the image, and of maps of panes

Model floor_with(std::vector<Material> panes) {
    Model model;
    model.materials = {{{0.5f, 0.5f, 0.5f, 1}}};
    model.materials.insert(model.materials.end(), panes.begin(), panes.end());
    add(model, "floor", ground(6, 6, 2, 2), 0);
    return model;
}

class Transmit : public GpuTest {};

TEST_F(Transmit, AHalfPlaneOfGlassTakesItsColourTimesItsShareOfTheSun) {
    const glm::dvec3 color(0.9, 0.35, 0.1);
    Model model = floor_with({glass(color)});
    add(model, "pane", sheet(-30, 0, sheet_height), 1);
    const Seen seen = render(model);
    const Errors errors =
        errors_of(seen, [&](double x) { return 1.0 - (1.0 - color) * (1 - right_of(x, 0)); });
    EXPECT_GT(errors.pixels, 100u);   // the penumbra is in view
    EXPECT_LT(errors.largest, 0.16);  // two of the sixteen rays
    EXPECT_LT(errors.rms, 0.012);
    EXPECT_NEAR(errors.mean, 0, 8e-4);
    for (size_t i = 0; i < seen.x.size(); ++i) {
        EXPECT_EQ(seen.visibility[i], 1) << i;  // nothing opaque: the mask stays as it is
        if (right_of(seen.x[i], 0) == 1) {
            EXPECT_EQ(seen.color[i], glm::dvec3(1)) << i;
        }
        if (right_of(seen.x[i], 0) == 0) expect_near(seen.color[i], color, stored);
    }
}

TEST_F(Transmit, PanesMultiplyInAnyOrderAndTexturesByTheirTexels) {
    const glm::dvec3 first(0.9, 0.5, 0.2), second(0.3, 0.8, 0.6);
    Material painted = film(1);
    painted.base_color = {1, 1, 1, 1};
    painted.texture = 0;
    Model model = floor_with({glass(first), glass(second), painted});
    model.textures = {{2, 1, {255, 255, 255, 51, 255, 255, 255, 204}}};
    add(model, "upper", sheet(-30, 0, 2.5), 1);
    add(model, "lower", sheet(-30, 0, sheet_height), 2);
    add(model, "painted", sheet(0, 2, 1), 3);  // from x = 1 on its right texel
    const Seen seen = render(model);
    size_t both = 0, left = 0, right = 0;
    for (size_t i = 0; i < seen.x.size(); ++i) {
        const double x = seen.x[i];
        if (x < -0.4) expect_near(seen.color[i], first * second, stored);
        if (x > 0.4 && x < 0.8) expect_near(seen.color[i], glm::dvec3(0.8), stored);
        if (x > 1.2 && x < 1.7) expect_near(seen.color[i], glm::dvec3(0.2), stored);
        both += x < -0.4;
        left += x > 0.4 && x < 0.8;
        right += x > 1.2 && x < 1.7;
    }
    EXPECT_GT(std::min({both, left, right}), 100u);
}

// Under one pane alone the colour is the pane's wherever anything arrives, and what arrives is the exact
// coverage.
TEST_F(Transmit, OpaqueInFrontOfAPaneAndBehindItKeepsItsExactShadow) {
    const glm::dvec3 color(0.9, 0.35, 0.1);
    Model model = floor_with({glass(color)});
    add(model, "pane", sheet(-30, 30, sheet_height), 1);
    add(model, "above", sheet(-30, -0.5, 3), 0);
    add(model, "below", sheet(0.5, 30, 1), 0);
    const Seen seen = render(model);
    size_t dark = 0, between = 0;
    for (size_t i = 0; i < seen.x.size(); ++i) {
        expect_near(seen.color[i], seen.visibility[i] * color, stored);
        dark += seen.visibility[i] == 0;
        between += seen.visibility[i] > 0 && seen.visibility[i] < 1;
    }
    EXPECT_GT(dark, 1000u);
    EXPECT_GT(between, 500u);
}

// For SIGMA, whose penumbra is as wide as the first of a ray's panes is far: a black texel beyond, at which
// the walk from the light's end has its product, is not the first.
TEST_F(Transmit, TheFirstPaneIsTheNearestThoughOneBeyondIsBlack) {
    Material painted = film(1);
    painted.base_color = {1, 1, 1, 1};
    painted.texture = 0;
    Model model = floor_with({glass({0.9, 0.9, 0.9}), painted});
    model.textures = {{2, 1, {255, 255, 255, 255, 255, 255, 255, 0}}};
    // So that the tree has the one beyond next to its root, and these below.
    for (int i = -30; i < 30; ++i) add(model, "near", sheet(i, i + 1, 1), 1);
    add(model, "far", sheet(-30, 30, 4), 2);
    const SceneFile file("floor.glb", to_glb(model));
    const Shot shot = shot_of(file.path());
    SessionOptions options;
    options.size = shot.size;
    options.jitter = false;
    options.captures = {"penumbra", "translucency"};
    const auto session = open_session(shipped_pipeline("sigma_translucency"), shot, options);
    session->run_frame(0, true);
    const auto penumbra = captured_values<uint16_t>(*session, "penumbra");
    const auto colours = captured_values<std::array<uint8_t, 4>>(*session, "translucency");
    size_t black = 0;
    for (size_t i = 0; i < penumbra.size(); ++i) {
        black += colours[i][1] == 0;
        EXPECT_NEAR(glm::detail::toFloat32(static_cast<short>(penumbra[i])), 0.5 * std::tan(radius), 0.002)
            << i;
    }
    EXPECT_GT(black, 100u);
}

// With something opaque that moves, and without.
TEST_F(Transmit, FollowsAPaneThatMoves) {
    const glm::dvec3 color(0.9, 0.35, 0.1);
    Model model = floor_with({glass(color)});
    add(model, "pane", sheet(-30, 0, sheet_height), 1);
    add(model, "opaque", sheet(-30, -29, sheet_height), 0);
    const auto from = [](double x) { return ObjectMotion{{}, {{0, {x, 0, 0}, {}}, {1, {0, 0, 0}, {}}}}; };
    const Seen stands = render(model), beside = render(model, {}, {}, {{"opaque", from(-9)}}),
               moved = render(model, {}, {}, {{"opaque", from(-9)}, {"pane", from(-9)}});
    EXPECT_TRUE(beside.bytes == stands.bytes);
    EXPECT_TRUE(moved.bytes == stands.bytes);
    EXPECT_NE(std::ranges::count(stands.color, glm::dvec3(1)), std::ssize(stands.color));
}

// An opaque edge, and a pane's beside it, over what the first leaves of the sun: the mean transmittance of
// the whole sun times the visibility would be off by up to (1 - c) v (1 - v).
TEST_F(Transmit, ColoursOnlyWhatAnOpaqueEdgeLeavesOpen) {
    const glm::dvec3 color(0.9, 0.35, 0.1);
    for (const double edge : {0.0, 0.12}) {
        SCOPED_TRACE(edge);
        Model model = floor_with({glass(color)});
        add(model, "opaque", sheet(-30, 0, sheet_height), 0);
        add(model, "pane", sheet(edge, 30, sheet_height), 1);
        const Seen seen = render(model);
        const Errors errors =
            errors_of(seen, [&](double x) { return right_of(x, 0) - (1.0 - color) * right_of(x, edge); });
        // With one edge for both only where none of sixteen rays finds what is open, less than a sixteenth.
        EXPECT_LT(errors.largest, edge == 0 ? 1.0 / 16 : 0.16);
        EXPECT_LT(errors.rms, edge == 0 ? 0.002 : 0.012);
        EXPECT_NEAR(errors.mean, 0, 8e-4);
    }
}

TEST_F(Transmit, IsTheSameByBothBackendsAndWhateverMemoryHeld) {
    const glm::dvec3 color(0.9, 0.35, 0.1);
    Model model = floor_with({glass(color)});
    add(model, "opaque", sheet(-30, 0, sheet_height), 0);
    add(model, "pane", sheet(0.12, 30, sheet_height), 1);
    const Seen tree = render(model);
    EXPECT_TRUE(render(model, {}, 0xFFFFFFFFu).bytes == tree.bytes);
    if (!gpu().caps().ray_query) GTEST_SKIP() << "no ray queries";
    const Seen queries = render(model, {"nodes.transmit.params.backend=ray_query"});
    size_t other = 0;
    for (size_t i = 0; i < tree.color.size(); ++i) other += tree.color[i] != queries.color[i];
    EXPECT_LE(other, tree.color.size() / 1000);  // rays that meet an edge to the last bit
}

// A pane between the camera and the floor is not in the G-buffer: what is behind it is the receiver.
TEST_F(Transmit, WhatLetsLightThroughIsNotDrawn) {
    Model model = floor_with({glass({0.9, 0.35, 0.1})});
    add(model, "pane", sheet(-30, 30, 0.5), 1);
    const Seen seen = render(model);
    for (size_t i = 0; i < seen.x.size(); ++i) {
        ASSERT_NEAR(seen.depth[i], 0.95, 0.01) << i;
        expect_near(seen.color[i], {0.9, 0.35, 0.1}, stored);
    }
}

// What SIGMA takes for translucent shadows: the first thing on the ray, be it glass, and what that leaves.
TEST_F(Transmit, ForSigmaGlassIsABlockerWithAColour) {
    const glm::dvec3 color(0.9, 0.35, 0.1);
    Model model = floor_with({glass(color)});
    add(model, "pane", sheet(-30, 0, sheet_height), 1);
    add(model, "above", sheet(-30, -0.5, sheet_height + 1), 0);
    const SceneFile file("floor.glb", to_glb(model));
    const Shot shot = shot_of(file.path());
    SessionOptions options;
    options.size = shot.size;
    options.jitter = false;
    options.captures = {"penumbra", "translucency", "transmittance", "view_depth"};
    const auto session = open_session(shipped_pipeline("sigma_translucency"), shot, options);
    session->run_frame(0, true);
    const auto penumbra = captured_values<uint16_t>(*session, "penumbra");
    const auto rays = captured_values<std::array<uint8_t, 4>>(*session, "translucency"),
               seen = captured_values<std::array<uint8_t, 4>>(*session, "transmittance");
    const auto depth = captured_values<float>(*session, "view_depth");
    const double across = std::tan(0.5 * glm::radians(shot.vertical_fov_deg)) * width / height;
    const std::array<uint8_t, 4> none{0, 0, 0, 0}, all{255, 255, 255, 255};
    const double first = 0.5 * sheet_height * std::tan(radius);
    size_t dark = 0, glassy = 0, clear = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
        const double x = ((double(i % width) + 0.5) / width * 2 - 1) * across * double(depth[i]),
                     p = double(glm::detail::toFloat32(static_cast<short>(penumbra[i])));
        if (x > 0.25) {  // beyond the pane's penumbra
            EXPECT_EQ(rays[i], all) << i;
            EXPECT_EQ(p, 65504) << i;
            ++clear;
        } else if (x < -0.85) {  // the opaque one is higher: the glass comes first
            EXPECT_EQ(rays[i], none) << i;
            EXPECT_NEAR(p, first, 0.01 * first) << i;
            ++dark;
        } else if (x > -0.2 && x < -0.15) {
            EXPECT_EQ(rays[i][0], rays[i] == all ? 255 : 0) << i;
            if (rays[i][0] == 0 && rays[i][1] > 0) {
                for (size_t c = 0; c < 3; ++c)
                    EXPECT_NEAR(rays[i][c + 1] / 255.0, color[glm::length_t(c)], stored) << i;
                EXPECT_NEAR(p, first, 0.01 * first) << i;
                ++glassy;
            }
        }
        EXPECT_LE(seen[i][2], seen[i][0]) << i;  // never bluer than the glass
    }
    EXPECT_GT(std::min({dark, glassy, clear}), 50u);
}

TEST(TranslucentTruth, IsTheClosedForm) {
    const glm::dvec3 color(0.9, 0.35, 0.1);
    Model model = floor_with({glass(color)});
    add(model, "opaque", sheet(-30, 0, sheet_height), 0);
    add(model, "pane", sheet(0.1, 30, sheet_height), 1);
    const Scene scene(std::move(model), Shot{});
    const CountedVisibility counted(scene, 0);
    ASSERT_TRUE(counted.has_translucent());
    for (const double x : {-0.5, -0.1, 0.0, 0.08, 0.15, 0.6}) {
        SCOPED_TRACE(x);
        SurfacePoint point;
        point.at = glm::dvec3(x, 0, 0.3) - scene.bvh_origin();
        point.triangle = ~0u;
        const auto seen = counted.seen(point, {{0, 1, 0}, radius, 64, 7});
        EXPECT_NEAR(seen.visibility, right_of(x, 0), 2e-3);
        expect_near(seen.transmittance, right_of(x, 0) - (1.0 - color) * right_of(x, 0.1), 2e-3);
    }
}

// A pixel may show an opaque texel of a translucent triangle, and nothing else of one.
TEST(TranslucentTruth, KnowsTheOpaqueTexelsThatAreDrawn) {
    for (const uint8_t alpha : {uint8_t{255}, uint8_t{200}}) {
        Material hair = film(1);
        hair.texture = 0;
        Model model = floor_with({hair});
        model.textures = {{2, 1, {255, 255, 255, alpha, 255, 255, 255, 99}}};
        add(model, "card", sheet(-3, 3, 1), 1);
        const Scene scene(std::move(model), Shot{});
        const ViewRay ray{glm::dvec3(-1, 3, 0.2) - scene.bvh_origin(), {0, -1, 0}, 0, 1e-3};
        const auto point = CountedVisibility(scene, 0).shown(ray, 2, {0, 1, 0});
        EXPECT_EQ(point.has_value(), alpha == 255);
        if (point) {
            EXPECT_NEAR(point->at.y + scene.bvh_origin().y, 1, 1e-9);
        }
    }
}

}  // namespace
}  // namespace penumbra::test
