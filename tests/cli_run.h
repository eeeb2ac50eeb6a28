// SPDX-License-Identifier: MIT
// The program as a shell runs it: exit code and both streams.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/test_folder.h"

namespace penumbra::test {

namespace fs = std::filesystem;

inline std::string read_file(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

// Before a command: the library in front of all others. LD_PRELOAD parts names at spaces, LD_LIBRARY_PATH
// does not.
inline std::string preload(const fs::path& library) {
    return "LD_LIBRARY_PATH='" + library.parent_path().string() +
           "'\"${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}\" LD_PRELOAD='" + library.filename().string() + "'";
}

struct Result {
    int code = -1;
    std::string out, err;
};

class Cli : public ::testing::Test {
  protected:
    // Runs in the source tree, so that diagnostics name files as a user there would see them.
    Result run(const std::string& arguments) const {
        const std::string command = "cd '" PENUMBRA_SOURCE_DIR "' && '" PENUMBRA_PROGRAM "' " + arguments +
                                    " >'" + (folder_ / "out").string() + "' 2>'" +
                                    (folder_ / "err").string() + "'";
        const int status = std::system(command.c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_file(folder_ / "out"),
                read_file(folder_ / "err")};
    }
    std::string in(const std::string& name) const { return (folder_ / name).string(); }
    std::string file(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name) << text;
        return in(name);
    }

    TestFolder folder_;
};

inline void expect(const Result& result, int code, const std::string& in_err) {
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_NE(result.err.find(in_err), std::string::npos) << result.err;
    if (code == 2) {
        EXPECT_EQ(result.out, "") << "errors go to the standard error stream";
    }
}

}  // namespace penumbra::test
