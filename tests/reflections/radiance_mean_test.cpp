// SPDX-License-Identifier: MIT
// What the nodes of reflections.json do to the mean of the light: nothing.
#include <cmath>

#include "app/outputs.h"
#include "host/models/model_builder.h"
#include "tests/gpu_test.h"
#include "tests/reflections/radiance_run.h"

namespace penumbra::test {
namespace {

class RadianceMean : public GpuTest {};

// A floor that fills the frame, under a sky that is bright at one end; small lamps that few rays find.
Shot speckled_floor(const std::vector<float>& roughness, float lamp, uint32_t frames) {
    Model model = striped_floor(roughness);
    model.materials.push_back(shining({lamp, lamp, lamp}));
    for (int i = 0; i < 5; ++i) {
        const double x = -1.5 + 0.7 * i;
        model.meshes.push_back({{to_part(box({x, 2, -1.6}, {x + 0.1, 2.1, -1.5}),
                                         static_cast<int>(model.materials.size()) - 1)}});
        Node node;
        node.mesh = static_cast<int>(model.meshes.size()) - 1;
        model.nodes.push_back(node);
    }
    Shot shot = night_shot(model, {64, 36}, frames);
    shot.camera = {{0, {0, 1.6, 1.2}, {0, 0, 0.2}, {0, 1, 0}}};
    shot.environment = linear_sky(0.2, 1);
    return shot;
}

double mean(const PlanarImage& image) {
    double sum = 0;
    for (const char* name : {"R", "G", "B"})
        for (const float v : image.find(name)->values) sum += v;
    return sum / (3.0 * static_cast<double>(image.width) * image.height);
}

// Rare and bright is what a filter that prefers the frequent casts out: 2 % of the light in this scene.
TEST_F(RadianceMean, TheTailKeepsIt) {
    for (const char* lobe : {"reflections", "indirect"}) {
        const bool diffuse = lobe == std::string("indirect");
        const auto session = open_shipped(lobe, speckled_floor({0.3f, 0.3f, 0.6f, 0.6f}, 60, 4), {},
                                          {"accumulated", "frames"});
        for (uint32_t frame = 0; frame < 3; ++frame) {
            session->run_frame(frame, frame == 0);
            const double before = mean_accumulated(*session),
                         after = mean(captured_image(*session, diffuse ? "diffuse" : "specular"));
            EXPECT_NEAR(after / before, 1, 2e-4) << lobe << ", frame " << frame;
        }
    }
}

// A running mean of 64 frames is the mean of what it was given, whichever way the device rounds what it
// stores.
TEST_F(RadianceMean, ThePastKeepsIt) {
    const auto session = open_shipped("reflections", speckled_floor({0.5f, 0.8f}, 0, 64), {},
                                      {"accumulated", "frames", "gathered"});
    double given = 0;
    for (uint32_t frame = 0; frame < 64; ++frame) {
        session->run_frame(frame, frame == 0);
        given += mean_gathered(*session) / 64;
    }
    EXPECT_NEAR(mean_accumulated(*session) / given, 1, 2e-3);
}

}  // namespace
}  // namespace penumbra::test
