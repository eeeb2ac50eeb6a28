// SPDX-License-Identifier: MIT
// plan.json is enough: an executor that knows nothing else gives the program's images bit for bit.
#include "app/plan_json.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "app/session.h"
#include "tests/gpu_test.h"
#include "tests/plan_executor.h"
#include "tests/recording.h"
#include "tests/shipped.h"
#include "tests/test_folder.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::byte> bytes_in(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    EXPECT_TRUE(in) << file;
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

class PlanJsonGpu : public GpuTest, public ::testing::WithParamInterface<const char*> {};

void run_plan(const char* name, std::array<uint32_t, 2> size, std::array<uint32_t, 2> largest) {
    const CheckedPipeline pipeline = shipped_pipeline(name);
    const TestFolder folder;
    constexpr uint32_t frames = 5;
    record_plaza(pipeline, size, frames, folder);

    DeviceTable device = device_table(handles_of(gpu()));
    device.features = features_of(gpu());
    Diagnostics diagnostics;
    const auto plan =
        compile(pipeline, standalone_target(pipeline, device, largest, recorded_facts()), {}, diagnostics);
    ASSERT_TRUE(plan) << diagnostics.text();
    ASSERT_TRUE(write_plan(*plan, folder / "plan", diagnostics)) << diagnostics.text();
    PlanExecutor executor(folder / "plan");
    std::vector<std::byte> last;
    for (uint32_t f = 0; f < frames; ++f) {
        const fs::path from = folder / std::to_string(f);
        std::map<std::string, std::vector<std::byte>> slots;
        for (const std::string& slot : executor.slots()) slots[slot] = bytes_in(from / (slot + ".bin"));
        std::vector<std::byte> block = bytes_in(from / "frame_block.bin");
        executor.frame(block, slots);
        for (const PlanOutput& output : plan->outputs) {
            const std::vector<std::byte> expected = bytes_in(from / (output.name + ".out"));
            EXPECT_EQ(executor.output(output.name), expected) << output.name << " of frame " << f;
            if (output.name != "visibility") continue;
            EXPECT_NE(last, expected) << "nothing changes: the test shows nothing";
            last = expected;
        }
    }
}

TEST_P(PlanJsonGpu, AnExecutorOfItsOwnGivesTheSameImages) {
    run_plan(GetParam(), {75, 43}, {75, 43});
}

// Of sizes at which a linear sampler is told the same numbers (size_test.cpp).
TEST_P(PlanJsonGpu, AlsoInAPlanForLargerFrames) {
    run_plan(GetParam(), {64, 32}, {128, 64});
}

INSTANTIATE_TEST_SUITE_P(Shipped, PlanJsonGpu,
                         ::testing::Values("shadows", "hybrid_shadows", "fidelityfx", "covered"),
                         [](const auto& name) { return std::string(name.param); });

}  // namespace
}  // namespace penumbra::test
