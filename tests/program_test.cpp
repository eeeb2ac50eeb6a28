// SPDX-License-Identifier: MIT
// What a program makes on its device: one pipeline for all passes that differ in nothing that a pipeline
// knows.
#include <fmt/format.h>

#include "app/session.h"
#include "penumbra/graph.h"
#include "tests/faulty_vulkan.h"
#include "tests/gpu_test.h"
#include "tests/shipped.h"

namespace penumbra::test {
namespace {

struct Made {
    size_t passes;
    long pipelines;
};

class ProgramGpu : public GpuTest {
  protected:
    Made made_for(uint32_t lights) {
        std::string members;
        for (uint32_t i = 0; i < lights; ++i)
            members += fmt::format(R"({}"l{}": {{"of": "lights"}})", i ? ", " : "", i);
        const CheckedPipeline pipeline =
            shipped_pipeline("lights_shadows", {"instances=null", "instances={" + members + "}"});
        const DeviceHandles handles = FaultyVulkan::handles(handles_of(gpu()));
        Diagnostics diagnostics;
        auto plan = compile(pipeline, {.extent = {64, 36}, .device = device_table(handles)}, {}, diagnostics);
        if (!plan) throw std::runtime_error(diagnostics.text());
        const Program program(handles, std::make_shared<const Plan>(std::move(*plan)));
        return {program.plan().passes.size(), FaultyVulkan::alive["pipeline"]};
    }
};

// From the second on: the first has no sums of a light before it, and so another `pool`.
TEST_F(ProgramGpu, FurtherInstancesNeedNoFurtherPipeline) {
    const Made two = made_for(2), four = made_for(4);
    EXPECT_GT(four.passes, two.passes + 20);
    EXPECT_EQ(four.pipelines, two.pipelines);
    EXPECT_GT(two.pipelines, 10);
}

}  // namespace
}  // namespace penumbra::test
