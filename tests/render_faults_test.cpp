// SPDX-License-Identifier: MIT
// A render whose memory ends, or whose disk or device fails, somewhere on its way: it ends with a word, and
// whatever stands under its own name is whole. cli_robustness_test.cpp has the commands that take no device.
#include <vulkan/vulkan_core.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tests/cli_run.h"

namespace penumbra::test {
namespace {

using Files = std::map<std::string, std::string>;

class RenderFaults : public Cli {
  protected:
    // Into folder_/out, with the preloaded library and its variables.
    Result render(const std::string& before, const std::string& stream = ">/dev/null") const {
        const std::string command = "cd '" PENUMBRA_SOURCE_DIR "' && " + before +
                                    " '" PENUMBRA_PROGRAM
                                    "' render raw --shot cards --size 32x18 "
                                    "--frames 0..1 --out '" +
                                    out().string() + "' " + stream + " 2>'" + (folder_ / "err").string() +
                                    "'";
        const int status = std::system(command.c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, "", read_file(folder_ / "err")};
    }
    fs::path out() const { return folder_ / "out"; }

    // What is there, with the report, which tells times, as whether it is whole.
    Files files() const {
        Files all;
        if (!fs::exists(out())) return all;
        for (const auto& entry : fs::directory_iterator(out())) {
            std::string& text = all[entry.path().filename().string()] = read_file(entry.path());
            if (entry.path().extension() == ".json")
                text = nlohmann::json::parse(text, nullptr, false).is_object() && text.ends_with("}\n")
                           ? "a report"
                           : "a broken report";
        }
        return all;
    }
    void expect_whole(const Files& left, const Files& whole, const std::string& what) const {
        for (const auto& [name, text] : left) {
            const auto good = whole.find(name);
            EXPECT_TRUE(good != whole.end() && good->second == text) << what << ": " << name;
        }
    }
};

TEST_F(RenderFaults, MemoryThatEndsIsSaidAndLeavesWholeFiles) {
    ASSERT_EQ(render("").code, 0);
    const Files whole = files();
    EXPECT_EQ(whole.at("report.json"), "a report");
    EXPECT_EQ(whole.size(), 9u);
    size_t said = 0, spared = 0, after_output = 0;
    for (size_t n = 1, past_the_end = 0; past_the_end < 2; n += 6007) {
        fs::remove_all(out());
        const std::string what = "allocation " + std::to_string(n);
        const Result result =
            render(preload(PENUMBRA_FAILING_NEW) + " PENUMBRA_FAIL_NEW_AT=" + std::to_string(n));
        const Files left = files();
        expect_whole(left, whole, what);
        const bool failed = result.err.find("[memory ends]") != std::string::npos;
        past_the_end += !failed;
        if (result.code == 0) {  // nothing failed, or somebody could do without
            EXPECT_EQ(left, whole) << what;
            spared += failed;
            continue;
        }
        EXPECT_TRUE(failed) << what << ": " << result.err;
        EXPECT_EQ(result.code, 1) << what << ": " << result.err;
        EXPECT_NE(result.err.find("there is not enough memory"), std::string::npos) << what << result.err;
        EXPECT_FALSE(left.contains("report.json")) << what << ": a report of a run that failed";
        ++said;
        after_output += !left.empty();
    }
    std::printf("%zu allocations made to fail and said, %zu of them with files there; %zu not needed\n", said,
                after_output, spared);
    EXPECT_GT(said, 10u);
}

TEST_F(RenderFaults, ATableThatNobodyGetsIsAFailure) {
    for (const char* stream : {">/dev/full", ">&-"})
        expect(render("", stream), 1, "standard output cannot be written");
}

TEST_F(RenderFaults, AFileThatCannotBeWrittenLeavesWholeOnes) {
    ASSERT_EQ(render("").code, 0);
    const Files whole = files();
    for (const std::string& how : {std::to_string(ENOSPC), std::string("kill")}) {
        size_t faults = 0;
        for (size_t n = 1;; n += 5) {
            fs::remove_all(out());
            const std::string what = how + " at call " + std::to_string(n);
            const Result result = render(preload(PENUMBRA_FAILING_FILES) + " PENUMBRA_FAIL_FILE_HOW=" + how +
                                         " PENUMBRA_FAIL_FILE_UNDER='" + out().string() +
                                         "' PENUMBRA_FAIL_FILE_AT=" + std::to_string(n));
            if (result.err.find("[fault in ") == std::string::npos) break;
            Files left = files();
            if (how == "kill") {
                EXPECT_EQ(result.code, 128 + SIGKILL) << what << result.err;
                std::erase_if(left, [](const auto& file) { return file.first.ends_with(".part"); });
            } else if (result.code == 0) {  // a flush that no file needs
                EXPECT_EQ(left, whole) << what;
                continue;
            } else {
                EXPECT_EQ(result.code, 1) << what;
                EXPECT_NE(result.err.find(out().string()), std::string::npos) << what << ": " << result.err;
                EXPECT_FALSE(left.contains("report.json")) << what;
            }
            expect_whole(left, whole, what);
            ++faults;
        }
        std::printf("%s: %zu faults\n", how.c_str(), faults);
        EXPECT_GT(faults, 3u) << how;
    }
}

// The first and the last call of each function, the instance's and the device's among them: the driver leaves
// garbage where a result would be, which nobody may take for an object (tests/failing_vulkan.cpp).
TEST_F(RenderFaults, ACallOfVulkanThatFailsIsNamedAndLeavesNothing) {
    const auto faulty = [&](const std::string& call, VkResult how) {
        fs::remove_all(out());
        return render(preload(PENUMBRA_FAILING_VULKAN) + " PENUMBRA_FAIL_VULKAN=" + call +
                      " PENUMBRA_FAIL_VULKAN_HOW=" + std::to_string(how));
    };
    const Result good = faulty("none", VK_SUCCESS);
    ASSERT_EQ(good.code, 0) << good.err;
    const Files whole = files();
    std::map<std::string, int> calls;
    std::istringstream lines(good.err);
    for (std::string word, name; lines >> word;)
        if (word == "[called" && lines >> name) lines >> calls[name];
    EXPECT_GE(calls.size(), 30u) << "functions that can fail";
    size_t faults = 0;
    for (const auto& [name, count] : calls)
        for (const int at : std::set{1, count}) {
            const std::string call = name + ":" + std::to_string(at);
            const bool lost = ++faults % 2;
            const Result result = faulty(call, lost ? VK_ERROR_DEVICE_LOST : VK_ERROR_OUT_OF_HOST_MEMORY);
            ASSERT_NE(result.err.find("[fault in " + name + "]"), std::string::npos) << call << result.err;
            EXPECT_EQ(result.code, 1) << call << ": " << result.err;
            const std::string said =
                name + " failed with " + (lost ? "VK_ERROR_DEVICE_LOST" : "VK_ERROR_OUT_OF_HOST_MEMORY");
            EXPECT_NE(result.err.find(said), std::string::npos) << call << ": " << result.err;
            EXPECT_NE(result.err.find("[alive 0]"), std::string::npos) << call << ": " << result.err;
            EXPECT_FALSE(files().contains("report.json")) << call;
            expect_whole(files(), whole, call);
        }
    std::printf("%zu faults in %zu functions\n", faults, calls.size());
}

}  // namespace
}  // namespace penumbra::test
