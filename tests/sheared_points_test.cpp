// SPDX-License-Identifier: MIT
// The tracer keeps the point of the sun that each ray goes to, and nobody is to ask for that of a pixel
// without a ray: so nothing may change with what the memory held before.
#include <filesystem>

#include "app/session.h"
#include "tests/gpu_test.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

std::unique_ptr<Session> session_of(const char* scene, std::optional<uint32_t> poison) {
    Diagnostics diagnostics;
    auto shot =
        read_shot(std::filesystem::path(PENUMBRA_SOURCE_DIR) / "scenes" / (std::string(scene) + ".shot.json"),
                  diagnostics);
    SessionOptions options;
    options.size = {150, 85};  // the last tiles and cells are not whole
    options.captures = {"visibility"};
    options.poison = poison;
    options.optimum = false;
    std::vector<std::string> warnings;
    auto session = shot ? Session::open(gpu(), test_nodes(), shadow_pipeline_file("sheared"), *shot, options,
                                        diagnostics, warnings)
                        : nullptr;
    if (!session) throw std::runtime_error(diagnostics.text());
    return session;
}

class ShearedPoints : public GpuTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(ShearedPoints, NobodyAsksForAnotherThanTheTracers) {
    const auto one = session_of(GetParam(), 0), other = session_of(GetParam(), 1);
    for (uint32_t frame = 0; frame < 3; ++frame) {
        one->run_frame(frame, frame == 0);
        other->run_frame(frame, frame == 0);
        const auto got = one->view().captured("visibility"), expected = other->view().captured("visibility");
        EXPECT_TRUE(std::equal(got.begin(), got.end(), expected.begin(), expected.end())) << frame;
    }
}

INSTANTIATE_TEST_SUITE_P(Shots, ShearedPoints, ::testing::Values("engine", "heightfield"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace penumbra::test
