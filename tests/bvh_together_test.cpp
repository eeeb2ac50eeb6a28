// SPDX-License-Identifier: MIT
// Lanes that walk through the tree together (shaders/visibility/bvh_together.glsl): each sees what it would
// have seen alone, as all do in the form for GPUs.
#include <bit>

#include "app/session.h"
#include "tests/cover_run.h"
#include "tests/gpu_test.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

std::unique_ptr<Session> first_frame(bool together, const std::string& pipeline, const std::string& shot,
                                     const std::string& light, std::vector<std::string> settings,
                                     const std::string& capture) {
    settings.emplace_back("outputs=[\"visibility\"]");
    SessionOptions options;
    options.size = {160, 90};
    options.cpu = together;
    options.captures = {capture};
    options.light = light;
    auto session =
        open_session(shipped_pipeline(pipeline, settings), shipped_shot(shot, options.size), options);
    session->run_frame(0, true);
    return session;
}

std::vector<float> seen(bool together, const std::string& pipeline, const std::string& shot,
                        const std::string& light, const std::vector<std::string>& settings) {
    const auto session = first_frame(together, pipeline, shot, light, settings, "visibility");
    return captured_planes(session->view(), "visibility").at(0);
}

// A device that is no CPU would take the driver's tree.
std::string by_tree(const std::string& node) {
    return "nodes." + node + ".params.backend=bvh";
}

class BvhTogether : public GpuTest {
  protected:
    static void expect_as_alone(const std::string& pipeline, const std::string& shot,
                                const std::string& light = {},
                                const std::vector<std::string>& settings = {}) {
        const auto together = seen(true, pipeline, shot, light, settings),
                   alone = seen(false, pipeline, shot, light, settings);
        EXPECT_GT(std::ranges::count_if(alone, [](float v) { return v > 0 && v < 1; }), 100);
        EXPECT_EQ(together, alone) << pipeline << " " << shot << " " << light;
    }
};

TEST_F(BvhTogether, LanesSeeWhatEachWouldAlone) {
    for (const char* shot : {"trees", "cards", "lamp"}) expect_as_alone("covered", shot);
}

TEST_F(BvhTogether, AndGiveUpWhereEachWould) {
    for (const char* budget : {"20", "60"})
        expect_as_alone("hybrid_shadows", "trees", {},
                        {by_tree("trace"), std::string("nodes.cover.params.budget=") + budget});
}

// Straight below it children lie to either side, and lanes would take them in different orders.
TEST_F(BvhTogether, AlsoBelowALamp) {
    for (const char* light : {"panel", "bulb", "tube"}) expect_as_alone("light", "lights/interior", light);
}

// Several of a pixel, also through holes, and to a lamp, where rays end.
TEST_F(BvhTogether, SoDoRaysOfAPixel) {
    for (const char* shot : {"trees", "cards", "lamp"})
        expect_as_alone("raw", shot, {}, {by_tree("trace"), "nodes.trace.params.rays_per_pixel=5"});
    expect_as_alone("light_raw", "lights/interior", "panel",
                    {by_tree("trace"), "nodes.trace.params.rays_per_pixel=16"});
}

TEST_F(BvhTogether, AndFurtherRays) {
    const auto bits_of = [](bool together) {
        const auto session = first_frame(together, "shadows_best", "cards", {},
                                         {by_tree("trace"), by_tree("refine")}, "ray_bits");
        return captured_values<uint32_t>(*session, "ray_bits");
    };
    const auto together = bits_of(true);
    EXPECT_GT(std::ranges::count_if(together, [](uint32_t word) { return std::popcount(word) > 2; }), 100);
    EXPECT_EQ(together, bits_of(false));
}

}  // namespace
}  // namespace penumbra::test
