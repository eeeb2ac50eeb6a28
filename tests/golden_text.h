// SPDX-License-Identifier: MIT
// Expectations that are text files under tests/golden/: compared as they stand, rewritten on purpose only,
// with PENUMBRA_REWRITE_GOLDEN=1. Places in them are relative to the repository's root.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra::test {

inline std::string read_text(const std::filesystem::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

inline void expect_golden(const std::string& text, const std::filesystem::path& golden) {
    if (std::getenv("PENUMBRA_REWRITE_GOLDEN")) std::ofstream(golden, std::ios::binary) << text;
    EXPECT_EQ(text, read_text(golden)) << "rewrite on purpose with PENUMBRA_REWRITE_GOLDEN=1";
}

// The sorted names of the files NAME + suffix in `folder`, which is relative to the repository's root.
inline std::vector<std::string> names_in(const std::filesystem::path& folder, std::string_view suffix) {
    std::vector<std::string> names;
    for (const auto& entry :
         std::filesystem::directory_iterator(std::filesystem::path(PENUMBRA_SOURCE_DIR) / folder)) {
        const std::string name = entry.path().filename().string();
        if (name.ends_with(suffix)) names.push_back(name.substr(0, name.size() - suffix.size()));
    }
    std::ranges::sort(names);
    return names;
}

// Runs a test in the repository's root.
class InSourceRoot : public ::testing::TestWithParam<std::string> {
  protected:
    void SetUp() override {
        before_ = std::filesystem::current_path();
        std::filesystem::current_path(PENUMBRA_SOURCE_DIR);
    }
    void TearDown() override { std::filesystem::current_path(before_); }

  private:
    std::filesystem::path before_;
};

}  // namespace penumbra::test
