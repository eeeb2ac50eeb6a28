// SPDX-License-Identifier: MIT
// Every input of the corpora, those among them that once broke something, what ships, and changes of each;
// the fuzzers themselves take other builds (docs/reliability.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "tests/fuzz/targets.h"

namespace penumbra::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::pair<std::string, std::string>> inputs_of(std::string_view target) {
    std::vector<std::pair<std::string, std::string>> inputs;  // name, bytes
    const auto add = [&](const fs::path& folder, std::string_view ending) {
        if (!fs::exists(PENUMBRA_SOURCE_DIR / folder)) return;
        for (const auto& entry : fs::directory_iterator(PENUMBRA_SOURCE_DIR / folder)) {
            if (!entry.path().string().ends_with(ending)) continue;
            std::ifstream stream(entry.path(), std::ios::binary);
            inputs.emplace_back((folder / entry.path().filename()).string(),
                                std::string(std::istreambuf_iterator<char>(stream), {}));
        }
    };
    add(fs::path("tests/fuzz/corpus") / target, "");
    if (target == "pipeline") add("pipelines", ".json");
    if (target == "shot") add("scenes", ".shot.json");
    std::ranges::sort(inputs);
    return inputs;
}

class Corpus : public ::testing::TestWithParam<FuzzTarget> {};

TEST_P(Corpus, IsReadOrRefused) {
    const auto inputs = inputs_of(GetParam().name);
    EXPECT_FALSE(inputs.empty());
    std::mt19937 random(1);
    for (const auto& [name, bytes] : inputs) {
        EXPECT_NO_THROW(GetParam().run(std::as_bytes(std::span(bytes)))) << name;
        for (int i = 0; i < 50 && !bytes.empty(); ++i) {
            std::string changed = bytes;
            for (int k = 0; k < 3; ++k) changed[random() % changed.size()] = static_cast<char>(random());
            if (i % 5 == 0) changed.resize(random() % changed.size());
            EXPECT_NO_THROW(GetParam().run(std::as_bytes(std::span(changed)))) << name << ", change " << i;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Corpus, ::testing::ValuesIn(fuzz_targets),
                         [](const auto& test) { return std::string(test.param.name); });

// Shipped pipelines changed by what is in them: a plan that the checks accept, or a diagnostic.
TEST(Mutants, CompileToASoundPlanOrAreRefused) {
    std::mt19937 random(2);
    for (int i = 0; i < 2000; ++i) {
        std::array<std::byte, 48> bytes;
        for (std::byte& byte : bytes) byte = std::byte(random() & 255);
        EXPECT_NO_THROW(fuzz_mutant(bytes)) << i;
    }
}

}  // namespace
}  // namespace penumbra::test
