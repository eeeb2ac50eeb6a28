// SPDX-License-Identifier: MIT
// A folder of a test's own, however many tests run beside it.
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <string>

namespace penumbra::test {

// Empty at first, and gone with what lies in it when the object ends.
class TestFolder {
  public:
    TestFolder() {
        static int count = 0;  // one process may run several tests, and a test may want several
        path_ =
            std::filesystem::temp_directory_path() / fmt::format("penumbra_test_{}_{}", getpid(), count++);
        std::filesystem::remove_all(path_);
        std::filesystem::create_directories(path_);
    }
    TestFolder(const TestFolder&) = delete;
    TestFolder& operator=(const TestFolder&) = delete;
    ~TestFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    const std::filesystem::path& path() const { return path_; }
    operator const std::filesystem::path&() const { return path_; }
    std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }
    std::string string() const { return path_.string(); }

  private:
    std::filesystem::path path_;
};

}  // namespace penumbra::test
