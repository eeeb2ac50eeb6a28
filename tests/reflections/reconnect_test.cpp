// SPDX-License-Identifier: MIT
// What neighbours' rays count where what they found is as near as they are.
#include <cmath>
#include <cstdio>

#include "host/models/model_builder.h"
#include "tests/gpu_test.h"
#include "tests/reflections/radiance_run.h"

namespace penumbra::test {
namespace {

class Reconnect : public GpuTest {};

// A floor, and a bright board as close above it as a pixel is wide.
Shot floor_below_a_lamp(float roughness) {
    Model model = striped_floor({roughness});
    model.materials.push_back(shining({1, 1, 1}));
    model.meshes.push_back(
        {{to_part(box({-4, 0.1, -1.5}, {4, 0.12, -1}), static_cast<int>(model.materials.size()) - 1)}});
    Node node;
    node.mesh = static_cast<int>(model.meshes.size()) - 1;
    model.nodes.push_back(node);
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

}  // namespace
}  // namespace penumbra::test
