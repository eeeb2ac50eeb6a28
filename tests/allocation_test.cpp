// SPDX-License-Identifier: MIT
// Memory ends at one allocation after the other, on the way from a pipeline's text to a plan: whoever called
// is told, nothing is lost, and afterwards all is as before. PENUMBRA_EVERY_ALLOCATION=1: also where a run
// takes some of them.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <new>

#include "penumbra/graph.h"
#include "penumbra/penumbra.h"
#include "penumbra/shadow_nodes.h"
#include "tests/allocations.h"

namespace penumbra::test {
namespace {

const std::string folder = PENUMBRA_SOURCE_DIR "/";

std::string plan_of(const std::string& file) {
    static const NodeSet nodes = shadow_nodes();
    Diagnostics diagnostics;
    const auto pipeline = load_pipeline(folder + file, {}, diagnostics);
    const auto checked = pipeline ? check(*pipeline, nodes, diagnostics) : std::nullopt;
    if (!checked) return diagnostics.text();
    Target target;
    target.extent = {640, 360};
    target.device = reference_device();
    const auto plan = compile(*checked, target, {}, diagnostics);
    return plan ? to_text(*plan) : diagnostics.text();
}

std::string plan_in_c(const std::string& file) {
    penumbra_plan_request request{};
    request.struct_size = sizeof request;
    request.width = 640;
    request.height = 360;
    const std::string path = folder + file;
    request.file = path.c_str();
    penumbra_error error{};
    error.struct_size = sizeof error;
    penumbra_plan* plan = nullptr;
    const penumbra_code code = penumbra_plan_create(&request, &plan, &error);
    if (code == PENUMBRA_OUT_OF_MEMORY && !plan) throw std::bad_alloc();
    std::string said = std::to_string(code) + " " + error.text;
    said += " " + std::to_string(penumbra_plan_slot_count(plan));
    penumbra_plan_destroy(plan);
    return said;
}

struct Sweep {
    size_t allocations = 0, failed = 0, spared = 0;  // spared: what failed was not needed
};

// `step`: each, or every so many.
Sweep sweep(const std::function<std::string()>& work, size_t step) {
    Sweep counts;
    std::string whole = work();  // what is made once is there now
    const long live = live_allocations;
    const size_t before = allocations;
    EXPECT_TRUE(work() == whole);
    counts.allocations = allocations - before;
    EXPECT_EQ(live_allocations, live);
    for (size_t n = 1; n <= counts.allocations; n += step) {
        failing_allocation = allocations + n;
        try {
            const std::string result = work();
            failing_allocation = ~size_t{0};
            EXPECT_TRUE(result == whole) << "allocation " << n << ": " << result;
            ++counts.spared;
        } catch (const std::bad_alloc&) {
            failing_allocation = ~size_t{0};
            ++counts.failed;
        }
        if (live_allocations != live) {
            ADD_FAILURE() << "allocation " << n << ": " << live_allocations - live << " are lost";
            return counts;
        }
    }
    EXPECT_TRUE(work() == whole);
    return counts;
}

void expect_all_said(const char* what, const std::function<std::string()>& work, size_t step) {
    if (std::getenv("PENUMBRA_EVERY_ALLOCATION")) step = 1;
    const Sweep counts = sweep(work, step);
    std::printf("%s: %zu allocations, %zu made to fail and said, %zu not needed\n", what, counts.allocations,
                counts.failed, counts.spared);
    EXPECT_GT(counts.failed, 100u) << what;
    EXPECT_LT(counts.spared * 20, counts.failed) << what;
}

TEST(Allocation, EachMayFailFromAPipelineToItsPlan) {
    expect_all_said(
        "raw", [] { return plan_of("pipelines/raw.json"); }, 1);
    expect_all_said(
        "hybrid_shadows", [] { return plan_of("pipelines/hybrid_shadows.json"); }, 7);
}

// While what is wrong is put into words.
TEST(Allocation, EachMayFailWhereSomethingIsWrong) {
    for (const char* file : {"tests/golden/broken/bad_params.json", "tests/golden/broken/cycle.json",
                             "tests/golden/broken/bad_enum_and_vector.json"})
        expect_all_said(
            file, [&] { return plan_of(file); }, 1);
}

TEST(Allocation, EachMayFailInC) {
    expect_all_said(
        "raw in C", [] { return plan_in_c("pipelines/raw.json"); }, 19);
    expect_all_said(
        "hybrid_shadows in C", [] { return plan_in_c("pipelines/hybrid_shadows.json"); }, 97);
}

}  // namespace
}  // namespace penumbra::test
