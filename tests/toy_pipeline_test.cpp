// SPDX-License-Identifier: MIT
// What the shadow pipelines do not exercise, on nodes whose results are exact: update chains, history read
// before and after its writer, optional ports, two producers under exclusive conditions, culling through
// history, indirect lists and partial writes; all with aliased memory that is poisoned before its first use.
#include <algorithm>
#include <cstring>

#include "app/session.h"
#include "penumbra/graph.h"
#include "tests/gpu_test.h"
#include "tests/toy_set.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

constexpr uint32_t width = 37, height = 11;

Plan toy_plan(const Facts& facts, bool alias, bool capture) {
    static const CheckedPipeline pipeline = toy_pipeline_file();
    Target target;
    target.extent = {width, height};
    target.facts = facts;
    target.device = capture ? device_table(handles_of(gpu())) : reference_device();
    CompileOptions options;
    options.alias = alias;
    options.poison = true;
    if (capture) options.captures = pipeline.output_names();
    Diagnostics diagnostics;
    auto plan = compile(pipeline, target, options, diagnostics);
    if (!plan) throw std::runtime_error(diagnostics.text());
    return std::move(*plan);
}

size_t position(const Plan& plan, const std::string& node) {
    return static_cast<size_t>(std::find_if(plan.passes.begin(), plan.passes.end(),
                                            [&](const PlanPass& p) { return p.node == node; }) -
                               plan.passes.begin());
}

const Culled* culled(const Plan& plan, const std::string& node) {
    for (const Culled& c : plan.culled)
        if (c.node == node) return &c;
    return nullptr;
}

TEST(ToyPlan, ConditionsChooseTheProducer) {
    const Plan moving = toy_plan({}, true, false), still = toy_plan({{"moves", false}}, true, false);
    EXPECT_LT(position(moving, "bright"), moving.passes.size());
    EXPECT_LT(position(still, "dim"), still.passes.size());
    ASSERT_TRUE(culled(moving, "dim"));
    EXPECT_EQ(culled(moving, "dim")->why, "if");
    EXPECT_EQ(culled(moving, "dim")->cond, "!moves");
    EXPECT_TRUE(culled(still, "bright"));
}

TEST(ToyPlan, ANodeThatOnlyFeedsItsOwnHistoryIsCulled) {
    const Plan plan = toy_plan({}, true, false);
    ASSERT_TRUE(culled(plan, "selfish"));
    EXPECT_EQ(culled(plan, "selfish")->why, "unused");
    for (const PlanResource& r : plan.resources) EXPECT_NE(r.names.front(), "hoard");
}

TEST(ToyPlan, ReadersOfAnOldNameComeBeforeItsUpdater) {
    const Plan plan = toy_plan({}, true, false);
    EXPECT_LT(position(plan, "keep"), position(plan, "double0"));
    EXPECT_LT(position(plan, "double0"), position(plan, "double1"));
    const auto chain = std::find_if(plan.resources.begin(), plan.resources.end(),
                                    [](const PlanResource& r) { return r.names.front() == "base"; });
    EXPECT_EQ(chain->names, (std::vector<std::string>{"base", "base2", "base4"}));
}

TEST(ToyPlan, HistoryIsReadOnBothSidesOfItsWriter) {
    const Plan plan = toy_plan({}, true, false);
    EXPECT_LT(position(plan, "early"), position(plan, "blend"));
    EXPECT_LT(position(plan, "blend"), position(plan, "late"));
}

class ToyRun : public GpuTest {};

// toy_chain and toy_pick in plain C++: 37x11 has six levels, whose last column or row has no partner.
std::vector<float> picked(const std::vector<float>& base) {
    std::vector<std::vector<float>> levels{base};
    for (float& value : levels[0]) value *= 2;
    for (uint32_t l = 1; (std::max(width, height) >> l) > 0; ++l) {
        const uint32_t w = std::max(width >> l, 1u), h = std::max(height >> l, 1u);
        const uint32_t below_w = std::max(width >> (l - 1), 1u), below_h = std::max(height >> (l - 1), 1u);
        std::vector<float> level(size_t{w} * h, 0.0f);
        for (uint32_t y = 0; y < h; ++y)
            for (uint32_t x = 0; x < w; ++x)
                for (uint32_t i = 0; i < 4; ++i) {
                    const uint32_t bx = 2 * x + (i & 1), by = 2 * y + (i >> 1);
                    if (bx < below_w && by < below_h) level[y * w + x] += levels.back()[by * below_w + bx];
                }
        levels.push_back(std::move(level));
    }
    std::vector<float> result(base.size());
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            const uint32_t l = x % uint32_t(levels.size());
            const uint32_t w = std::max(width >> l, 1u), h = std::max(height >> l, 1u);
            result[y * width + x] = levels[l][std::min(y >> l, h - 1) * w + std::min(x >> l, w - 1)];
        }
    return result;
}

// The same dataflow in plain C++.
struct Expected {
    std::vector<float> previous = std::vector<float>(width * height, 0.0f);
    std::map<std::string, std::vector<float>> values;

    void frame(uint32_t index, bool reset, bool moves) {
        auto& v = values;
        for (const char* name :
             {"early_view", "late_view", "base_copy", "blended", "level", "scattered", "picked"})
            v[name].assign(width * height, 0.0f);
        for (uint32_t y = 0; y < height; ++y)
            for (uint32_t x = 0; x < width; ++x) {
                const uint32_t i = y * width + x;
                const auto f = static_cast<float>(index);
                const float base = static_cast<float>(i) + f, history = reset ? 0 : 0.5f * previous[i];
                v["base_copy"][i] = base;
                v["blended"][i] = 4 * base + history;
                v["early_view"][i] = base + history;
                v["late_view"][i] = v["blended"][i] + history;
                v["level"][i] = moves ? 3 * static_cast<float>(i) + f + 7 : 0.5f * static_cast<float>(i) + f;
                if (y % 2 == 0) v["scattered"][i] = static_cast<float>(x / 2 + 1) + base;
            }
        v["picked"] = picked(v["base_copy"]);
        previous = v["blended"];
    }
};

void run_and_compare(bool moves, bool alias, uint32_t poison) {
    auto program = std::make_shared<Program>(
        handles_of(gpu()), std::make_shared<Plan>(toy_plan({{"moves", moves}}, alias, true)));
    View view(program, {2, poison});
    Expected expected;
    for (uint32_t index = 0; index < 7; ++index) {
        FrameDescription frame;
        frame.camera.clip_from_view = frame.previous.clip_from_view = perspective(1.0, 1.0, 0.1);
        frame.size = frame.prev_size = {width, height};
        frame.index = index;
        const bool reset =
            index == 0 || index == 4;  // a cut at an even and at an odd parity is the same to the graph
        if (index == 4) frame.flags = frame_reset;
        gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, frame, {}); });
        expected.frame(index, reset, moves);
        for (const auto& [name, values] : expected.values)
            ASSERT_EQ(captured<float>(view, name), values) << name << " in frame " << index;
        const auto statistics = view.statistics();
        EXPECT_EQ(statistics[position(view.plan(), "fill")].counters, std::vector<uint32_t>{width * height});
    }
}

TEST_F(ToyRun, ComputesWhatTheDataflowSays) {
    for (const bool moves : {false, true})
        for (const bool alias : {false, true})
            for (const uint32_t poison : {0u, 1u}) {
                SCOPED_TRACE(testing::Message()
                             << "moves " << moves << " alias " << alias << " poison " << poison);
                run_and_compare(moves, alias, poison);
            }
}

TEST_F(ToyRun, DynamicParametersChangeBetweenFrames) {
    auto program = std::make_shared<Program>(
        handles_of(gpu()), std::make_shared<Plan>(toy_plan({{"moves", false}}, true, true)));
    View view(program, {});
    EXPECT_TRUE(view.set_param("dim", "scale", ParamValue(2.0f)));
    EXPECT_FALSE(view.set_param("dim", "bias", ParamValue(int32_t{1}))) << "constants are part of the plan";
    EXPECT_FALSE(view.set_param("nobody", "scale", ParamValue(2.0f)));
    FrameDescription frame;
    frame.camera.clip_from_view = frame.previous.clip_from_view = perspective(1.0, 1.0, 0.1);
    frame.size = frame.prev_size = {width, height};
    gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, frame, {}); });
    EXPECT_EQ(captured<float>(view, "level")[10], 20.0f);
}

}  // namespace
}  // namespace penumbra::test
