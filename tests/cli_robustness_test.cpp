// SPDX-License-Identifier: MIT
// The program where the system lets it down: streams that cannot be written, memory that is not there. No
// device.
#include <gtest/gtest.h>

#include "tests/cli_run.h"

namespace penumbra::test {
namespace {

class CliRobustness : public Cli {
  protected:
    // As run(), with the streams as the shell line says.
    Result raw(const std::string& before, const std::string& arguments, const std::string& streams) const {
        const std::string err = (folder_ / "err").string();
        const std::string command = "cd '" PENUMBRA_SOURCE_DIR "' && " + before + " '" PENUMBRA_PROGRAM "' " +
                                    arguments + " " + streams + " 2>'" + err + "'";
        const int status = std::system(command.c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, "", read_file(err)};
    }
};

const char* const printing[] = {"nodes",
                                "nodes --format json",
                                "nodes filter",
                                "plan pipelines/raw.json --size 64x64",
                                "plan pipelines/raw.json --size 64x64 --format json",
                                "--help",
                                "--version"};

TEST_F(CliRobustness, AnOutputThatIsFullOrClosedIsAFailure) {
    for (const char* command : printing) {
        for (const char* stream : {">/dev/full", ">&-"}) {
            const Result result = raw("", command, stream);
            EXPECT_EQ(result.code, 1) << command << " " << stream;
            EXPECT_NE(result.err.find("standard output cannot be written"), std::string::npos)
                << command << " " << stream << ": " << result.err;
        }
        EXPECT_EQ(raw("", command, ">/dev/null").code, 0) << command;
    }
    EXPECT_EQ(raw("", "check pipelines/raw.json", ">&-").code, 0) << "nothing was to be said";
}

// With the streams closed, the first file that is opened would take the place of one.
TEST_F(CliRobustness, AClosedStreamIsNotWrittenIntoAFile) {
    const fs::path out = folder_ / "plan";
    EXPECT_EQ(raw("", "plan pipelines/raw.json --size 64x64 --out " + out.string(), "<&- >&-").code, 0);
    const std::string text = read_file(out / "plan.json");
    EXPECT_TRUE(text.starts_with("{") && text.ends_with("}\n")) << text.substr(0, 80);
    for (const auto& entry : fs::directory_iterator(out))
        EXPECT_NE(entry.path().extension(), ".part") << "nothing half done is left";
}

TEST_F(CliRobustness, ValuesThatAreNearlyRightAreRefused) {
    for (const char* size :
         {"'16 x16'", "+5x5", "16x16x16", "16x", "x16", "0x16", "16x-1", "16x16 ", "99999999999x1"})
        expect(run(std::string("plan pipelines/raw.json --size ") +
                   (std::string(size).ends_with(' ') ? "'16x16 '" : size)),
               2, "is not WIDTHxHEIGHT");
    expect(run("plan pipelines/raw.json --size 64x64 --out ''"), 2, "--out: the text is empty");
    expect(run("compare '' pipelines"), 2, "the text is empty");
    const std::string folders = "compare " + folder_.string() + " " + folder_.string();
    expect(run(folders + " --frames 0..4294967295"), 2, "--frames");
    expect(run(folders + " --frames 2..1"), 2, "--frames");
}

// operator new fails at the call of one number (tests/failing_new.cpp): whatever was under way ends with a
// word.
TEST_F(CliRobustness, AnAllocationThatFailsEndsWithAWord) {
    for (const char* command :
         {"check pipelines/hybrid_shadows.json", "plan pipelines/raw.json --size 64x64", "nodes"}) {
        size_t failed = 0;
        // Each third of the first hundred, where nothing but the program's own start is; then fewer and
        // fewer.
        for (size_t n = 1; n < 200'000; n += n < 100 ? 3 : 1 + n / 6) {
            const Result result =
                raw("LD_PRELOAD='" PENUMBRA_FAILING_NEW "' PENUMBRA_FAIL_NEW_AT=" + std::to_string(n),
                    command, ">/dev/null");
            if (result.code == 0) continue;  // it was past the last one, or somebody could do without
            ++failed;
            EXPECT_TRUE(result.code == 1 || result.code == 2)
                << command << ", allocation " << n << ": exit code " << result.code;
            EXPECT_FALSE(result.err.empty()) << command << ", allocation " << n;
        }
        EXPECT_GT(failed, 20u) << command;
    }
}

}  // namespace
}  // namespace penumbra::test
