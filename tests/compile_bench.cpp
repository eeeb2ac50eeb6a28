// SPDX-License-Identifier: MIT
//   compile_bench
// Milliseconds that plans take: of shipped pipelines, and of chains of toy nodes; the least of many. No
// device is asked.
#include <chrono>
#include <cstdio>
#include <stdexcept>

#include "penumbra/graph.h"
#include "penumbra/shadow_nodes.h"
#include "tests/shipped.h"
#include "tests/toy_set.h"

namespace penumbra::test {
namespace {

double since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

// `read`: from text to a checked pipeline.
template <class Read>
void measure(const char* name, Read&& read, int times) {
    double best = 1e9, best_read = 1e9;
    size_t passes = 0;
    MemoryReport memory;
    for (int i = 0; i < times; ++i) {
        Diagnostics diagnostics;
        const auto begin = std::chrono::steady_clock::now();
        const CheckedPipeline pipeline = read();
        best_read = std::min(best_read, since(begin));
        const auto checked = std::chrono::steady_clock::now();
        const auto plan =
            compile(pipeline, {.extent = {1920, 1080}, .device = reference_device()}, {}, diagnostics);
        best = std::min(best, since(checked));
        if (!plan) throw std::runtime_error(diagnostics.text());
        passes = plan->passes.size();
        memory = plan->memory;
    }
    std::printf("%-24s %4zu passes  %8.2f ms, reading %.2f ms  heap %llu, live bound %llu\n", name, passes,
                best, best_read, static_cast<unsigned long long>(memory.heap_bytes),
                static_cast<unsigned long long>(memory.live_bound_bytes));
}

// Each node reads the one before, and some its own past.
CheckedPipeline chain(int nodes) {
    std::string text = R"({ "penumbra": 1, "name": "chain", "outputs": ["n)" + std::to_string(nodes - 1) +
                       R"("], "nodes": { "fill": { "type": "toy_fill", "out": { "value": "n0" } })";
    for (int i = 1; i < nodes; ++i) {
        const std::string own = "n" + std::to_string(i), before = "n" + std::to_string(i - 1);
        text += R"(, "b)" + std::to_string(i) + R"(": { "type": "toy_blend", "in": { "value": ")" + before +
                "\"" + (i % 4 == 0 ? R"(, "history": ")" + own + "@-1\"" : "") +
                R"( }, "out": { "blended": ")" + own + R"(" } })";
    }
    Diagnostics diagnostics;
    const auto pipeline = parse_pipeline(text + "} }", "chain.json", {}, diagnostics);
    auto checked = pipeline ? check(*pipeline, toy_set(), diagnostics) : std::nullopt;
    if (!checked) throw std::runtime_error(diagnostics.text());
    return std::move(*checked);
}

}  // namespace
}  // namespace penumbra::test

int main() {
    using namespace penumbra::test;
    for (const char* name : {"shadows", "hybrid_shadows", "covered", "fidelityfx", "one_ray"})
        measure(
            name, [&] { return shipped_pipeline(name); }, 30);
    for (const int nodes : {10, 100, 1000})
        measure(("chain of " + std::to_string(nodes)).c_str(), [&] { return chain(nodes); },
                nodes < 1000 ? 10 : 3);
}
