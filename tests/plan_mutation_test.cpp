// SPDX-License-Identifier: MIT
// Every plan that ships with one thing wrong, at both parities: the checks of plan_checks.h, which share no
// code with the compiler, notice each. The counts are those of docs/reliability.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "penumbra/graph.h"
#include "tests/plan_checks.h"
#include "tests/plan_mutants.h"
#include "tests/shipped.h"
#include "tests/toy_set.h"

namespace penumbra::test {
namespace {

constexpr size_t faults = 8;
using Counts = std::array<size_t, faults>;

Plan plan_of(const CheckedPipeline& pipeline, bool poison = false) {
    Target target;
    target.extent = {1280, 720};
    target.inputs = told_inputs(pipeline);
    target.device = reference_device();
    CompileOptions options;
    options.poison = poison;
    Diagnostics diagnostics;
    auto plan = compile(pipeline, target, options, diagnostics);
    if (!plan) throw std::runtime_error(diagnostics.text());
    return std::move(*plan);
}

// `harmless`: nodes before which a dependency makes a write available that another has made available
// already, as the rules that place them cannot tell.
Counts expect_all_noticed(const Plan& plan, const std::vector<std::string>& harmless = {}) {
    EXPECT_EQ(overlap_errors(plan), std::vector<std::string>{});
    EXPECT_EQ(hazard_errors(plan), std::vector<std::string>{});
    Counts counts{};
    for (const Mutant& mutant : mutants(plan, reference_device())) {
        ++counts[static_cast<size_t>(mutant.fault)];
        const bool of_memory =
            mutant.fault == Fault::lifetime_short || mutant.fault == Fault::lifetime_short_packed;
        const auto errors = of_memory ? overlap_errors(mutant.plan) : hazard_errors(mutant.plan, 1);
        const std::string node = mutant.what.substr(0, mutant.what.find(','));
        const bool lives = mutant.fault == Fault::dependency_dropped &&
                           std::find(harmless.begin(), harmless.end(), node) != harmless.end();
        EXPECT_EQ(errors.empty(), lives) << name_of(mutant.fault) << ": " << mutant.what;
    }
    return counts;
}

void print(const std::string& name, const Counts& counts) {
    std::printf("%-20s", name.c_str());
    for (const size_t count : counts) std::printf(" %4zu", count);
    std::printf("\n");
}

class PlanMutation : public ::testing::TestWithParam<std::string> {};

TEST_P(PlanMutation, IsNoticed) {
    const Counts counts = expect_all_noticed(plan_of(shipped_pipeline(GetParam())));
    EXPECT_GT(counts[static_cast<size_t>(Fault::dependency_dropped)], 0u);
    EXPECT_EQ(counts[static_cast<size_t>(Fault::end_dropped)], 2u);
    print(GetParam(), counts);
}

INSTANTIATE_TEST_SUITE_P(Pipelines, PlanMutation, ::testing::ValuesIn(pipeline_files()),
                         [](const auto& test) { return test.param; });

TEST(ToyMutation, IsNoticed) {
    const Counts counts = expect_all_noticed(plan_of(toy_pipeline_file()), {"chain"});
    EXPECT_EQ(counts[static_cast<size_t>(Fault::clear_unordered)], 4u);
    print("toys", counts);
}

// What poison adds are clears, and each is waited for.
TEST(ToyMutation, OfPoisonedMemoryIsNoticed) {
    const Counts counts = expect_all_noticed(plan_of(toy_pipeline_file(), true), {"chain"});
    print("toys, poisoned", counts);
}

}  // namespace
}  // namespace penumbra::test
