// SPDX-License-Identifier: MIT
// examples/invert on a device, as its README says: a node that penumbra does not ship runs behind a shipped
// pipeline.
#include <cstring>
#include <filesystem>
#include <glm/gtc/packing.hpp>

#include "app/commands.h"
#include "app/session.h"
#include "penumbra/shadow_nodes.h"
#include "penumbra/user_nodes.h"
#include "tests/gpu_test.h"
#include "tests/shot_run.h"
#include "tests/test_scene.h"

namespace penumbra::test {
namespace {

const std::filesystem::path example = std::filesystem::path(PENUMBRA_SOURCE_DIR) / "examples/invert";

class Example : public GpuTest {};

TEST_F(Example, InvertIsOneMinusVisibilityTimesGain) {
    NodeSet nodes = shadow_nodes();
    Diagnostics diagnostics;
    ASSERT_TRUE(add_user_nodes(nodes, example / "nodes", diagnostics, open_shader_cache("")))
        << diagnostics.text();
    const std::vector<std::string> settings = {"nodes.invert.params.gain=0.5",
                                               "resources.visibility={\"format\": \"r16f\"}"};
    const auto pipeline = load_pipeline(example / "shadow.json", settings, diagnostics);
    const auto checked = pipeline ? check(*pipeline, nodes, diagnostics) : std::nullopt;
    ASSERT_TRUE(checked) << diagnostics.text();
    const Shot shot = plaza_shot({75, 43}, 2);
    SessionOptions options;
    options.size = shot.size;
    options.captures = {"visibility", "shadow"};
    const auto session = open_session(*checked, shot, options, nodes);
    const size_t pixels = size_t{shot.size[0]} * shot.size[1];
    for (uint32_t frame = 0; frame < shot.frames; ++frame) {
        session->run_frame(frame, frame == 0);
        const auto visibility = session->view().captured("visibility"),
                   shadow = session->view().captured("shadow");
        ASSERT_EQ(visibility.size(), 2 * pixels);
        ASSERT_EQ(shadow.size(), 2 * pixels);
        size_t lit = 0;
        for (size_t i = 0; i < pixels; ++i) {
            uint16_t v = 0, s = 0;
            std::memcpy(&v, visibility.data() + 2 * i, 2);
            std::memcpy(&s, shadow.data() + 2 * i, 2);
            ASSERT_EQ(glm::unpackHalf1x16(s), 0.5f * (1 - glm::unpackHalf1x16(v))) << "pixel " << i;
            lit += glm::unpackHalf1x16(v) == 1;
        }
        EXPECT_GT(lit, pixels / 10);
        EXPECT_LT(lit, pixels - pixels / 100) << "nothing is in shadow: the test shows nothing";
    }
}

}  // namespace
}  // namespace penumbra::test
