// SPDX-License-Identifier: MIT
// Files of the project, for tests that hold them to something.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace penumbra::test {

namespace fs = std::filesystem;

inline const fs::path root = PENUMBRA_SOURCE_DIR;

inline std::string read(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    EXPECT_TRUE(stream) << path;
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

}  // namespace penumbra::test
