// SPDX-License-Identifier: MIT
// What neighbours' rays count where what they found is as near as they are.
#include <cmath>
#include <cstdio>
#include <numeric>

#include "host/models/model_builder.h"
#include "tests/gpu_test.h"
#include "tests/reflections/radiance_run.h"

namespace penumbra::test {
namespace {

class Reconnect : public GpuTest {};

void add(Model& model, const Shape& shape, float shines) {
    model.materials.push_back(shining({shines, shines, shines}));
    model.meshes.push_back({{to_part(shape, static_cast<int>(model.materials.size()) - 1)}});
    Node node;
    node.mesh = static_cast<int>(model.meshes.size()) - 1;
    model.nodes.push_back(node);
}

// A floor, and a bright board as close above it as a pixel is wide.
Shot floor_below_a_lamp(float roughness) {
    Model model = striped_floor({roughness});
    add(model, box({-4, 0.1, -1.5}, {4, 0.12, -1}), 1);
    Shot shot = night_shot(model, {64, 36}, 32);
    shot.camera = {{0, {0, 0.6, 0.2}, {0, 0, -0.9}, {0, 1, 0}}};
    shot.environment = linear_sky(0, 0);
    return shot;
}

// Of what 32 frames gather in the mean: the root of the mean square by which rows of pixels are off, of the
// truth's.
double error(const Shot& shot, const std::string& pipeline, const std::vector<double>& truth,
             bool hit_normals) {
    std::vector<std::string> settings;
    if (!hit_normals)
        settings = {"nodes.rays.params.hit_normals=false", "nodes.reconnect.params.hit_normals=false"};
    const auto session = open_shipped(pipeline, shot, settings, {"gathered"}, {}, false);
    std::vector<double> rows(shot.size[1], 0);
    for (uint32_t frame = 0; frame < shot.frames; ++frame) {
        session->run_frame(frame, frame == 0);
        const auto pixels = gathered(*session);
        for (size_t i = 0; i < pixels.size(); ++i)
            rows[i / shot.size[0]] += pixels[i] / shot.size[0] / shot.frames;
    }
    double off = 0, of = 0;
    for (size_t y = 0; y < rows.size(); ++y) {
        off += std::pow(rows[y] - truth[y], 2);
        of += truth[y] * truth[y];
    }
    return std::sqrt(off / of);
}

// A cosine at the hit that is taken for the same from all pixels makes another integral of it, and weights
// that are divided by their sum make what only the nearest rays find well too faint: .21 and .24 by both, .17
// and .21 by the second alone.
TEST_F(Reconnect, WhatIsNearIsSeenUnderItsOwnCosine) {
    for (const auto& [pipeline, signal, largest] :
         {std::tuple{"reflections", "specular", 0.162}, {"indirect", "diffuse", 0.2}}) {
        const Shot shot = floor_below_a_lamp(0.8f);
        const PlanarImage image = truth_of(shot, signal, 1024);
        std::vector<double> truth(shot.size[1], 0);
        for (size_t i = 0; i < image.planes[0].values.size(); ++i)
            truth[i / shot.size[0]] += double(image.planes[0].values[i]) / shot.size[0];
        const double known = error(shot, pipeline, truth, true),
                     unknown = error(shot, pipeline, truth, false);
        std::printf("%s: %.3f, without normals %.3f\n", pipeline, known, unknown);
        EXPECT_LT(known, largest);
        EXPECT_LT(known, 0.85 * unknown);
    }
}

constexpr const char* asking = "nodes.reconnect.type=reconnect_asking";

// From above: a lamp over the floor's left half, which a wall of less than a pixel's width hides from the
// right one. `white`: all of it, as far as the sky, is 1.
Shot wall_beside_a_lamp(float roughness, bool white) {
    Model model = striped_floor({roughness});
    if (white) model.materials[0].emissive = {1, 1, 1};
    add(model, box({-0.6, 0.1, -1.5}, {-0.4, 0.3, 1.5}), 1);
    add(model, box({-0.002, 0, -3}, {0.002, 0.5, 3}), white);
    Shot shot = night_shot(model, {64, 36}, 32);
    shot.camera = {{0, {0, 3, 0.3}, {0, 0, 0}, {0, 0, -1}}};
    shot.environment = linear_sky(white, white);
    return shot;
}

// What the columns of pixels gather in the mean of all frames.
std::vector<double> columns_of(const Shot& shot, const char* pipeline,
                               const std::vector<std::string>& settings) {
    const auto session = open_shipped(pipeline, shot, settings, {"gathered"}, {}, false);
    std::vector<double> columns(shot.size[0], 0);
    for (uint32_t frame = 0; frame < shot.frames; ++frame) {
        session->run_frame(frame, frame == 0);
        const auto pixels = gathered(*session);
        for (size_t i = 0; i < pixels.size(); ++i)
            columns[i % shot.size[0]] += pixels[i] / shot.size[1] / shot.frames;
    }
    return columns;
}

// Two columns on the dark side have neighbours on the other one. What these found is hidden by the wall.
TEST_F(Reconnect, AskingKeepsLightBehindAWall) {
    for (const char* pipeline : {"reflections", "indirect"}) {
        const Shot shot = wall_beside_a_lamp(0.8f, false);
        const auto trusting = columns_of(shot, pipeline, {}), asked = columns_of(shot, pipeline, {asking});
        const size_t dark = shot.size[0] / 2;
        const auto leaks = [&](const std::vector<double>& c) { return c[dark] + c[dark + 1]; };
        const auto lit = [&](const std::vector<double>& c) {
            return std::reduce(c.begin(), c.begin() + static_cast<std::ptrdiff_t>(dark));
        };
        std::printf("%s: %.4f leak, %.4f where rays ask; %.3f and %.3f on the lit side\n", pipeline,
                    leaks(trusting), leaks(asked), lit(trusting), lit(asked));
        EXPECT_GT(leaks(trusting), 0.03);
        EXPECT_LT(leaks(asked), 0.3 * leaks(trusting));
        EXPECT_NEAR(lit(asked), lit(trusting), 0.03 * lit(trusting));
        EXPECT_EQ(asked[dark + 2], 0);
    }
}

TEST_F(Reconnect, WhatIsHiddenLeavesWhiteWhite) {
    Shot shot = wall_beside_a_lamp(0.4f, true);
    shot.frames = 3;
    for (const char* pipeline : {"reflections", "indirect"}) {
        const auto session = open_shipped(pipeline, shot, {asking}, {"gathered"});
        for (uint32_t frame = 0; frame < shot.frames; ++frame) {
            session->run_frame(frame, frame == 0);
            for (const double pixel : gathered(*session)) ASSERT_NEAR(pixel, 1, 1e-3) << pipeline;
        }
    }
}

// A hit is known by few digits of a direction and a distance. In a convex room nothing hides any, so nothing
// changes.
TEST_F(Reconnect, WhatNothingHidesIsSeen) {
    Model model = striped_floor({0.2f, 0.4f, 0.8f});
    add(model, box({-9, 1.6, -9}, {9, 2, 9}), 2);
    add(model, box({-9, -1, -9}, {-3.5, 2, 9}), 1);
    add(model, box({3.5, -1, -9}, {9, 2, 9}), 3);
    add(model, box({-9, -1, -9}, {9, 2, -2.5}), 0.5);
    add(model, box({-9, -1, 2.5}, {9, 2, 9}), 0);
    Shot shot = night_shot(model, {64, 36}, 4);
    shot.camera = {{0, {0, 1.2, 2.3}, {0, 0, 0}, {0, 1, 0}}};
    for (const char* pipeline : {"reflections", "indirect"}) {
        const auto trusting = open_shipped(pipeline, shot, {}, {"gathered"}),
                   asked = open_shipped(pipeline, shot, {asking}, {"gathered"});
        for (uint32_t frame = 0; frame < shot.frames; ++frame) {
            trusting->run_frame(frame, frame == 0);
            asked->run_frame(frame, frame == 0);
            const auto a = gathered(*trusting), b = gathered(*asked);
            size_t others = 0;
            for (size_t i = 0; i < a.size(); ++i) others += a[i] != b[i];
            EXPECT_EQ(others, 0u) << pipeline << ", frame " << frame;
        }
    }
}

}  // namespace
}  // namespace penumbra::test
