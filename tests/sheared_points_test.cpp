// SPDX-License-Identifier: MIT
// sheared.json has no pass of its own for the points of the sun: the tracer keeps that of each ray it casts,
// and nobody is to ask for another. So nothing may change where all pixels have one, whatever the memory held
// before.
#include <filesystem>

#include "app/session.h"
#include "tests/gpu_test.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

constexpr const char* every_point = R"({
  "penumbra": 1, "name": "every_point", "extends": "sheared.json",
  "nodes": { "trace": { "out": { "ray_points": null } }, "sun_points": { "type": "sun_points" } }
})";

CheckedPipeline with_every_point() {
    Diagnostics diagnostics;
    const std::filesystem::path beside =
        std::filesystem::path(PENUMBRA_SOURCE_DIR) / "pipelines/every_point.json";
    const auto pipeline = parse_pipeline(every_point, beside.string(), {}, diagnostics);
    auto result = pipeline ? check(*pipeline, test_nodes(), diagnostics) : std::nullopt;
    if (!result) throw std::runtime_error(diagnostics.text());
    return std::move(*result);
}

std::unique_ptr<Session> session_of(const CheckedPipeline& pipeline, const char* scene) {
    Diagnostics diagnostics;
    auto shot =
        read_shot(std::filesystem::path(PENUMBRA_SOURCE_DIR) / "scenes" / (std::string(scene) + ".shot.json"),
                  diagnostics);
    SessionOptions options;
    options.size = {150, 85};  // the last tiles and cells are not whole
    options.captures = {"visibility"};
    options.poison = 1;
    options.optimum = false;
    std::vector<std::string> warnings;
    auto session =
        shot ? Session::open(gpu(), test_nodes(), pipeline, *shot, options, diagnostics, warnings) : nullptr;
    if (!session) throw std::runtime_error(diagnostics.text());
    return session;
}

class ShearedPoints : public GpuTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(ShearedPoints, NobodyAsksForAnotherThanTheTracers) {
    const auto by_tracer = session_of(shadow_pipeline_file("sheared"), GetParam());
    const auto all = session_of(with_every_point(), GetParam());
    for (uint32_t frame = 0; frame < 3; ++frame) {
        by_tracer->run_frame(frame, frame == 0);
        all->run_frame(frame, frame == 0);
        const auto got = by_tracer->view().captured("visibility"),
                   expected = all->view().captured("visibility");
        EXPECT_TRUE(std::equal(got.begin(), got.end(), expected.begin(), expected.end())) << frame;
    }
}

INSTANTIATE_TEST_SUITE_P(Shots, ShearedPoints, ::testing::Values("engine", "heightfield"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace penumbra::test
