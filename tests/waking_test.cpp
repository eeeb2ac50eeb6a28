// SPDX-License-Identifier: MIT
// Members of a family that sleep and wake (View::set_awake): what runs meanwhile, what others read, and that
// nobody wakes with a past.
#include <algorithm>

#include "tests/embedding_host.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

class WakingGpu : public GpuTest {};

// Three members, each with a mean over its past, and the sum over them; before it something takes their
// memory.
CheckedPipeline members(const std::string& outputs, const std::string& first = "clear") {
    return checked(R"("outputs": [)" + outputs + R"(],
      "instances": { "a": { "of": "toys" }, "b": { "of": "toys" }, "c": { "of": "toys" } },
      "resources": { "blended": { "first": ")" +
                   first + R"(" } },
      "nodes": {
        "fill":   { "type": "toy_fill", "instances": "toys" },
        "double": { "type": "toy_double", "instances": "toys", "in": { "value": "value" }, "out": { "doubled": "twice" } },
        "blend":  { "type": "toy_blend", "instances": "toys", "in": { "value": "twice", "history": "blended@-1" } },
        "add":    { "type": "toy_add", "instances": "toys", "in": { "value": "blended", "before": "sum@before" } },
        "peek":   { "type": "toy_add", "instances": "toys", "in": { "value": "blended", "before": "blended@last" },
                    "out": { "sum": "peeked" } },
        "all":    { "type": "toy_add", "in": { "value": "sum@last" }, "out": { "sum": "all" } } })");
}

std::shared_ptr<const Program> poisonable(const CheckedPipeline& pipeline) {
    CompileOptions options = capturing(pipeline);
    options.poison = true;
    return std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, options));
}

void frame_of(View& view, uint32_t index, uint32_t flags = 0) {
    FrameDescription frame = description(index);
    frame.flags = flags;
    gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, frame, {}); });
}

// Of pixel i in frame `index`, where the mean has gone on since frame `since`.
float mean(uint32_t i, uint32_t index, uint32_t since) {
    float sum = 0;
    for (uint32_t f = since; f <= index; ++f) sum = 2 * static_cast<float>(i + f) + 0.5f * sum;
    return sum;
}

TEST_F(WakingGpu, WhoSleepsDoesNothingAndIsZero) {
    for (const std::string outputs : {R"("sum", "blended", "all")", R"("all")", R"("peeked")"})
        for (const uint32_t poison : {0u, 1u}) {
            const CheckedPipeline pipeline = members(outputs);
            View view(poisonable(pipeline), {.poison = poison});
            const auto expect = [&](const std::string& output, float value, uint32_t frame) {
                if (!view.plan().output(output)) return;
                EXPECT_EQ(floats(view.captured(output))[7], value) << output << " in " << frame;
            };
            for (uint32_t f = 0; f < 9; ++f) {
                const bool a = f < 7, b = f < 2 || f > 5, c = f % 3 != 1;
                EXPECT_TRUE(view.set_awake("a", a) && view.set_awake("b", b) && view.set_awake("c", c));
                frame_of(view, f);
                const std::map<std::string, std::pair<bool, uint32_t>> are{
                    {"a", {a, 0}}, {"b", {b, f > 5 ? 6 : 0}}, {"c", {c, f > 1 ? (f + 1) / 3 * 3 - 1 : 0}}};
                const float last = c ? mean(7, f, are.at("c").second) : 0;
                float sum = 0;
                for (const auto& [name, is] : are) {
                    const auto [awake, since] = is;
                    const float own = awake ? mean(7, f, since) : 0;
                    sum += own;
                    EXPECT_EQ(counters_of(view, "fill_" + name)["pixels"], awake ? width * height : 0);
                    expect("blended_" + name, own, f);
                    expect("sum_" + name, sum, f);
                    expect("peeked_" + name, awake ? own + last : 0, f);
                }
                expect("all", sum, f);
                EXPECT_EQ(view.reset().reason, f == 0 ? Reset::Reason::first_frame : Reset::Reason::none);
            }
        }
}

// A sum that three nodes pass on, beside one that reads it on its way, whose result is summed up as well.
TEST_F(WakingGpu, SeveralNodesHandOn) {
    const CheckedPipeline pipeline = checked(R"("outputs": ["sum", "twice", "tally"],
      "instances": { "a": { "of": "toys" }, "b": { "of": "toys" }, "c": { "of": "toys" } },
      "nodes": {
        "fill":   { "type": "toy_fill", "instances": "toys", "out": { "value": "own" } },
        "begin":  { "type": "toy_add", "instances": "toys", "in": { "value": "own", "before": "sum@before" },
                    "out": { "sum": "begun" } },
        "middle": { "type": "toy_add", "instances": "toys", "in": { "value": "begun", "before": null }, "out": { "sum": "value" } },
        "end":    { "type": "toy_add", "instances": "toys", "in": { "before": null }, "out": { "sum": "sum" } },
        "aside":  { "type": "toy_add", "instances": "toys", "in": { "value": "begun", "before": "sum" }, "out": { "sum": "twice" } },
        "count":  { "type": "toy_add", "instances": "toys", "in": { "value": "twice", "before": "tally@before" },
                    "out": { "sum": "tally" } } })");
    View view(poisonable(pipeline), {.poison = 1});
    for (const char* pass : {"begin_b", "middle_b", "end_b", "count_b"})
        EXPECT_FALSE(view.plan().pass(pass)->rests) << pass;
    for (const char* pass : {"fill_b", "aside_b"}) EXPECT_TRUE(view.plan().pass(pass)->rests) << pass;
    for (uint32_t f = 0; f < 3; ++f) {
        EXPECT_TRUE(view.set_awake("b", f != 1));
        frame_of(view, f);
        const auto own = static_cast<float>(7 + f);
        EXPECT_EQ(floats(view.captured("sum_c"))[7], (f == 1 ? 2 : 3) * own);
        EXPECT_EQ(floats(view.captured("twice_b"))[7], f == 1 ? 0 : 4 * own);
        EXPECT_EQ(floats(view.captured("twice_c"))[7], (f == 1 ? 4 : 6) * own);
        EXPECT_EQ(floats(view.captured("tally_c"))[7], (f == 1 ? 6 : 12) * own);
    }
}

// A past that must not begin cleared can only begin with everybody's.
TEST_F(WakingGpu, WhoCannotBeginClearedResetsTheFrame) {
    const CheckedPipeline pipeline = members(R"("blended")", "any");
    View view(poisonable(pipeline), {.poison = 0});
    for (uint32_t f = 0; f < 5; ++f) {
        EXPECT_TRUE(view.set_awake("b", f != 2));
        frame_of(view, f);
        const uint32_t since = f < 3 ? 0 : 3;
        EXPECT_EQ(view.reset().reason, f == 0   ? Reset::Reason::first_frame
                                       : f == 3 ? Reset::Reason::woken
                                                : Reset::Reason::none);
        EXPECT_EQ(view.reset().resource, f == 3 ? "blended_b" : "");
        EXPECT_EQ(floats(view.captured("blended_a"))[3], mean(3, f, since)) << f;
        EXPECT_EQ(floats(view.captured("blended_b"))[3], f == 2 ? 0 : mean(3, f, since)) << f;
    }
}

// A reset that a sleeper has missed, and a view that takes over from one in which somebody sleeps. What b's
// passes leave here nobody else reads, so that it is not cleared where they rest.
TEST_F(WakingGpu, NobodyElsesPastIsTheirs) {
    const CheckedPipeline pipeline = members(R"("peeked")");
    const auto program = program_with(pipeline, {});
    View before(program, {});
    const auto expect_since = [](const View& view, uint32_t frame, uint32_t a, uint32_t b) {
        const float c = mean(5, frame, a);
        EXPECT_EQ(floats(view.captured("peeked_a"))[5], mean(5, frame, a) + c) << frame;
        EXPECT_EQ(floats(view.captured("peeked_b"))[5], mean(5, frame, b) + c) << frame;
    };
    for (uint32_t f = 0; f < 5; ++f) {
        EXPECT_TRUE(before.set_awake("b", f < 2 || f == 4));
        frame_of(before, f, f == 3 ? uint32_t{frame_reset} : 0u);
    }
    expect_since(before, 4, 3, 4);
    EXPECT_TRUE(before.set_awake("b", false));
    frame_of(before, 5);
    View heir(program, {.heir_of = &before});
    frame_of(heir, 6);
    EXPECT_EQ(heir.reset().reason, Reset::Reason::none);
    expect_since(heir, 6, 3, 6);  // all members of a new view are awake
}

// Also in an heir's first frame, of a past that its sleeper has not handed on.
TEST_F(WakingGpu, AnHeirsSleeperHasAPastOfNothing) {
    const CheckedPipeline pipeline = checked(R"("outputs": ["late"],
      "instances": { "a": { "of": "toys" }, "b": { "of": "toys" } },
      "nodes": {
        "fill":  { "type": "toy_fill", "instances": "toys" },
        "blend": { "type": "toy_blend", "instances": "toys", "in": { "history": "blended@-1" } },
        "late":  { "type": "toy_add", "in": { "value": "blended_b@-1" }, "out": { "sum": "late" } } })");
    CompileOptions options = capturing(pipeline);
    options.poison = options.hand_on_history = true;
    const auto program = std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, options));
    View before(program, {.poison = 1});
    for (uint32_t f = 0; f < 3; ++f) {
        EXPECT_TRUE(before.set_awake("b", f == 0));
        frame_of(before, f);
    }
    View heir(program, {.poison = 1, .heir_of = &before});
    EXPECT_TRUE(heir.set_awake("b", false));
    frame_of(heir, 3);
    EXPECT_EQ(heir.reset().reason, Reset::Reason::none);
    EXPECT_EQ(floats(heir.captured("late"))[7], 0);
}

// Without captures, too, which are readers like any.
TEST_F(WakingGpu, AnOutputIsRead) {
    const auto plan = plan_of(members(R"("peeked")"), {});
    EXPECT_EQ(plan->pass("peek_b")->zero_at_rest.size(), 1u);
    EXPECT_TRUE(plan->pass("blend_b")->zero_at_rest.empty());
    EXPECT_EQ(plan->pass("blend_c")->zero_at_rest.size(), 1u) << "which the others peek at";
}

TEST_F(WakingGpu, ItIsAChangeAndOfMembersAlone) {
    const CheckedPipeline pipeline = checked(R"("outputs": ["value"], "instances": { "a": { "of": "toys" } },
        "nodes": { "fill": { "type": "toy_fill", "instances": "toys" } })");
    View view(program_with(pipeline, {}), {});
    frame_of(view, 0);
    frame_of(view, 1, frame_unchanged);
    EXPECT_TRUE(view.settled());
    EXPECT_TRUE(view.set_awake("a", true)) << "as it is";
    EXPECT_TRUE(view.settled());
    EXPECT_TRUE(view.set_awake("a", false));
    EXPECT_FALSE(view.settled());
    EXPECT_FALSE(view.set_awake("fill_a", false)) << "a node";
    EXPECT_FALSE(view.set_awake("toys", false)) << "the family";
    EXPECT_FALSE(view.set_awake("", false));
}

}  // namespace
}  // namespace penumbra::test
