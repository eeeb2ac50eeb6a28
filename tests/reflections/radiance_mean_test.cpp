// SPDX-License-Identifier: MIT
// What the nodes of reflections.json do to the mean of the light: nothing.
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

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

// Just below a power of two the largest mantissa would round up beyond its nine bits, and steps twice as
// large are taken instead.
TEST_F(RadianceMean, BelowAPowerOfTwoItIsKept) {
    for (const double value : {0.9993, 0.4997, 0.75}) {
        Shot shot = night_shot(striped_floor({0.6f}), {64, 36}, 1);
        shot.camera = {{0, {0, 1.6, 1.2}, {0, 0, 0.2}, {0, 1, 0}}};
        shot.environment = linear_sky(value, value);
        const auto session = open_shipped("reflections", shot, {}, {"gathered"});
        session->run_frame(0, true);
        EXPECT_NEAR(mean_gathered(*session) / value, 1, 3e-4);
    }
}

// Two slopes that count as one surface where they meet, for one of two pixels and perhaps not for the other.
TEST_F(RadianceMean, TheTailKeepsItAcrossABend) {
    Material matte;
    matte.base_color = {1, 1, 1, 1};
    ModelBuilder builder({matte, shining({40, 40, 40})});
    for (const double side : {-1.0, 1.0}) {
        Shape slope = ground(3, 4, 1, 1);
        glm::dmat4 place = glm::rotate(glm::dmat4(1), side * glm::radians(-11.0), glm::dvec3(0, 0, 1));
        place = place * glm::translate(glm::dmat4(1), glm::dvec3(3 * side, 0, 0));
        slope.transform(place);
        builder.solid("slope", slope, 0);
    }
    for (int i = 0; i < 5; ++i)
        builder.solid("lamp", box({-1.2 + 0.5 * i, 1.7, -0.6}, {-1.1 + 0.5 * i, 1.8, -0.5}), 1);
    Shot shot = night_shot(builder.take(), {64, 36}, 4);
    shot.camera = {{0, {0, 1.4, 1}, {0, 0, -0.1}, {0, 1, 0}}};
    shot.environment = linear_sky(0.1, 0.4);
    const auto session = open_shipped("indirect", shot, {}, {"accumulated", "frames"});
    for (uint32_t frame = 0; frame < 3; ++frame) {
        session->run_frame(frame, frame == 0);
        const double before = mean_accumulated(*session), after = mean(captured_image(*session, "diffuse"));
        EXPECT_NEAR(after / before, 1, 6e-5) << "frame " << frame;
    }
}

}  // namespace
}  // namespace penumbra::test
