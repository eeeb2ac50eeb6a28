// SPDX-License-Identifier: MIT
// Shipped pipelines, changed by what is in them already: what compiles and can be fed runs, with validation
// and synchronisation checks silent; all else is refused with a diagnostic.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>

#include "app/pipeline_file.h"
#include "app/session.h"
#include "penumbra/shadow_nodes.h"
#include "tests/fuzz/changed_pipeline.h"
#include "tests/gpu_test.h"
#include "tests/test_scene.h"

namespace penumbra::test {
namespace {

constexpr uint32_t frames = 3;
constexpr std::array<uint32_t, 2> size{45, 27};

// PENUMBRA_CHANGED_PIPELINES=N: as many; PENUMBRA_SEED: others (docs/reliability.md).
unsigned from_environment(const char* name, unsigned otherwise) {
    const char* text = std::getenv(name);
    return text ? static_cast<unsigned>(std::atol(text)) : otherwise;
}

class ChangedPipelines : public GpuTest {
  protected:
    // Whether it ran: false with the diagnostics of who refused it.
    static bool run(const std::string& text, const NodeSet& nodes, const Shot& shot,
                    Diagnostics& diagnostics) {
        auto pipeline = parse_pipeline(text, "changed.json", {}, diagnostics);
        if (pipeline) name_lights(*pipeline, shot, "", diagnostics);
        const auto checked =
            pipeline && diagnostics.empty() ? check(*pipeline, nodes, diagnostics) : std::nullopt;
        if (!checked) return false;
        SessionOptions options;
        options.size = size;
        options.pass_costs = false;
        options.cascade_size = 64;
        std::vector<std::string> warnings;
        const auto session = Session::open(gpu(), nodes, *checked, shot, options, diagnostics, warnings);
        for (uint32_t f = 0; session && f < frames; ++f) session->run_frame(f, f == 0);
        return session != nullptr;
    }
};

TEST_F(ChangedPipelines, RunCleanOrAreRefused) {
    const unsigned wanted = from_environment("PENUMBRA_CHANGED_PIPELINES", 100);
    std::mt19937 random(from_environment("PENUMBRA_SEED", 3));
    const NodeSet nodes = shadow_nodes();
    const Shot shot = plaza_shot(size, frames);
    unsigned ran = 0;
    for (unsigned i = 0; i < wanted; ++i) {
        std::array<std::byte, 48> bytes;
        for (std::byte& byte : bytes) byte = std::byte(random() & 255);
        const std::string text = changed_pipeline(bytes, 2);  // the more changes, the fewer run
        const size_t messages = gpu().message_count();
        Diagnostics diagnostics;
        const bool runs = run(text, nodes, shot, diagnostics);
        EXPECT_NE(runs, !diagnostics.empty()) << i << ": " << text << '\n' << diagnostics.text();
        ASSERT_EQ(gpu().message_count(), messages) << i << ": " << text;
        ran += runs;
    }
    std::printf("%u of %u changed pipelines ran\n", ran, wanted);
    EXPECT_GT(ran, wanted / 8) << "hardly any changed pipeline compiles and runs";
}

// One of them made a buffer of no texels: who needs what a sky has none of is told so.
TEST_F(ChangedPipelines, WhatASkyHasNoneOfIsRefused) {
    std::ifstream file(PENUMBRA_SOURCE_DIR "/pipelines/reference_radiance.json");
    std::string text(std::istreambuf_iterator<char>(file), {});
    const std::string lots = R"("environment_lots": { "extent": "any", "optional": true })";
    ASSERT_NE(text.find(lots), std::string::npos);
    text.replace(text.find(lots), lots.size(), R"("environment_lots": { "extent": "any" })");
    Diagnostics diagnostics;
    EXPECT_FALSE(run(text, shadow_nodes(), plaza_shot(size, frames), diagnostics));
    EXPECT_NE(diagnostics.text().find("inputs.environment_lots: there are none"), std::string::npos)
        << diagnostics.text();
}

}  // namespace
}  // namespace penumbra::test
