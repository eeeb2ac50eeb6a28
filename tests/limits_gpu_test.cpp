// SPDX-License-Identifier: MIT
// Frames as long and as narrow as a device allows run, and one more pixel is refused without a word from
// Vulkan.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "app/session.h"
#include "host/models/glb_writer.h"
#include "tests/gpu_test.h"
#include "tests/scene_file.h"
#include "tests/shipped.h"
#include "tests/test_scene.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

class LimitsGpu : public GpuTest {};

std::unique_ptr<Session> open(const char* name, std::array<uint32_t, 2> size, std::string& refusal) {
    SessionOptions options;
    options.size = size;
    options.captures = {"visibility"};
    options.pass_costs = false;
    options.cascade_size = 64;
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    auto session = Session::open(gpu(), test_nodes(), shipped_pipeline(name), plaza_shot(size, 2), options,
                                 diagnostics, warnings);
    refusal = diagnostics.text();
    return session;
}

TEST_F(LimitsGpu, FramesOfOneLineRun) {
    const uint32_t most = device_table(handles_of(gpu())).max_image_extent;
    for (const char* name : {"shadows", "hybrid_shadows", "fidelityfx"}) {
        float least = 1, largest = 0;
        for (const std::array<uint32_t, 2> size : {std::array<uint32_t, 2>{most, 1}, {1, most}}) {
            std::string refusal;
            const auto session = open(name, size, refusal);
            ASSERT_TRUE(session) << refusal;
            for (uint32_t f = 0; f < 2; ++f) session->run_frame(f, f == 0);
            const std::vector<float> visibility = captured_planes(session->view(), "visibility").at(0);
            ASSERT_EQ(visibility.size(), most);
            EXPECT_TRUE(std::ranges::all_of(visibility, [](float v) { return v >= 0 && v <= 1.001f; }))
                << name;
            least = std::min(least, std::ranges::min(visibility));
            largest = std::max(largest, std::ranges::max(visibility));
        }
        EXPECT_LT(least, 0.5f) << name << ": nothing is in shadow";
        EXPECT_GT(largest, 0.5f) << name << ": nothing is lit";
    }
}

TEST_F(LimitsGpu, APixelMoreIsRefused) {
    const uint32_t more = device_table(handles_of(gpu())).max_image_extent + 1;
    for (const std::array<uint32_t, 2> size : {std::array<uint32_t, 2>{more, 1}, {1, more}}) {
        std::string refusal;
        EXPECT_FALSE(open("shadows", size, refusal));
        EXPECT_NE(refusal.find("exceeds the device's largest image"), std::string::npos) << refusal;
    }
}

TEST_F(LimitsGpu, ATextureThatIsTooLargeIsAWarning) {
    const uint32_t most = gpu().limits().maxImageDimension2D;
    Model model;
    for (const uint32_t width : {most, most + 1})
        model.textures.push_back({width, 1, std::vector<uint8_t>(size_t{width} * 4, 99)});
    model.materials = {{.texture = 0}, {.texture = 1}};
    add(model, "floor", ground(4, 4, 2, 2), 0);
    add(model, "block", box({0, 1, 0}, {1, 2, 1}), 1);
    const SceneFile file("large_texture.glb", to_glb(model));
    SessionOptions options;
    options.size = {64, 48};
    options.pass_costs = false;
    Shot shot = plaza_shot(options.size, 2);
    shot.model = file.path();
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    ASSERT_TRUE(
        Session::open(gpu(), test_nodes(), shipped_pipeline("raw"), shot, options, diagnostics, warnings))
        << diagnostics.text();
    EXPECT_EQ(warnings,
              std::vector<std::string>{fmt::format("a texture of {}x1 exceeds the device's largest image, {} "
                                                   "per axis: it is drawn white",
                                                   most + 1, most)});
}

}  // namespace
}  // namespace penumbra::test
