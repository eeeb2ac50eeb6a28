// SPDX-License-Identifier: MIT
// One picture whatever computes it: equal to the bit over lavapipe's numbers of threads, which change the
// order of everything that the Vulkan API leaves open; within tolerances over two versions of the driver,
// whose compilers round otherwise.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "host/images/image_file.h"
#include "tests/cli_run.h"

namespace penumbra::test {
namespace {

const fs::path older = PENUMBRA_SOURCE_DIR "/.cache/mesa22/lvp_icd.json";  // scripts/mesa22.sh

class Drivers : public Cli {
  protected:
    // Into a folder of that name.
    void render(const std::string& name, const std::string& environment, const std::string& arguments) const {
        const std::string command =
            "cd '" PENUMBRA_SOURCE_DIR "' && " + environment + " '" PENUMBRA_PROGRAM "' render " + arguments +
            " --out '" + (folder_ / name).string() + "' >/dev/null 2>'" + (folder_ / "err").string() + "'";
        ASSERT_EQ(std::system(command.c_str()), 0) << command << "\n" << read_file(folder_ / "err");
    }
    std::string driver(const std::string& name) const {  // that rendered it
        return nlohmann::json::parse(read_file(folder_ / name / "report.json"))["device"]["driver"];
    }
    std::map<std::string, std::string> images(const std::string& name) const {
        std::map<std::string, std::string> found;
        for (const auto& entry : fs::directory_iterator(folder_ / name))
            if (entry.path().extension() == ".exr")
                found[entry.path().filename().string()] = read_file(entry.path());
        return found;
    }
};

constexpr const char* pipelines[] = {"shadows", "hybrid_shadows", "reflections"};

TEST_F(Drivers, NumbersOfThreadsDoNotShow) {
    for (const std::string pipeline : pipelines) {
        const std::string arguments = pipeline + " --shot colonnade --size 160x90 --frames 0..3";
        render(pipeline, "LP_NUM_THREADS=1", arguments);
        const auto expected = images(pipeline);
        ASSERT_GE(expected.size(), 4u);
        for (const char* threads : {"0", "3", "16"}) {
            render("again", std::string("LP_NUM_THREADS=") + threads, arguments);
            EXPECT_TRUE(images("again") == expected) << pipeline << " with " << threads << " threads";
            fs::remove_all(folder_ / "again");
        }
        EXPECT_NE(expected.begin()->second, std::next(expected.begin())->second) << "the frames are equal";
    }
}

// RMSE of an output over that output's own root mean square, all frames and channels together.
double difference(const fs::path& a, const fs::path& b, const std::string& output) {
    double error = 0, square = 0;
    for (const auto& entry : fs::directory_iterator(a)) {
        const std::string name = entry.path().filename().string();
        if (!name.starts_with(output + ".") || entry.path().extension() != ".exr") continue;
        Diagnostics diagnostics;
        const auto one = read_exr(entry.path(), diagnostics), other = read_exr(b / name, diagnostics);
        if (!one || !other) throw std::runtime_error(diagnostics.text());
        for (size_t p = 0; p < one->planes.size(); ++p)
            for (size_t i = 0; i < one->planes[p].values.size(); ++i) {
                const double u = one->planes[p].values[i], v = other->planes[p].values[i];
                error += (u - v) * (u - v);
                square += u * u;
            }
    }
    return std::sqrt(error / square);
}

// docs/reliability.md has what was measured: equal bits, but for reflections.
TEST_F(Drivers, TwoVersionsAgree) {
    if (!fs::exists(older)) {
        ASSERT_EQ(std::getenv("PENUMBRA_ALL_DRIVERS"), nullptr) << "scripts/mesa22.sh has not run";
        GTEST_SKIP() << "no second driver";
    }
    struct Case {
        const char *pipeline, *output;
        double tolerance;
        const char* shot = "colonnade";
    };
    for (const Case& c : {Case{"raw", "visibility", 1e-4},
                          {"shadows", "visibility", 1e-4},
                          {"hybrid_shadows", "visibility", 1e-4},
                          {"fidelityfx", "visibility", 1e-4},
                          {"light_shadows", "visibility", 1e-4, "lights/interior --light panel"},
                          {"reflections", "specular", 1e-4},
                          {"lit", "color", 1e-4}}) {
        const std::string arguments =
            fmt::format("{} --shot {} --size 160x90 --frames 0..3", c.pipeline, c.shot);
        render("newer", "env -u VK_DRIVER_FILES", arguments);
        render("older", "VK_DRIVER_FILES='" + older.string() + "'", arguments);
        const std::string newest = driver("newer");
        if (newest == driver("older")) {
            ASSERT_EQ(std::getenv("PENUMBRA_ALL_DRIVERS"), nullptr) << "both are " << newest;
            GTEST_SKIP() << "both are " << newest;
        }
        const double found = difference(folder_ / "newer", folder_ / "older", c.output);
        std::printf("%s: %s differs by %.2g\n", c.pipeline, c.output, found);
        EXPECT_LE(found, c.tolerance) << c.pipeline;
        fs::remove_all(folder_ / "newer");
        fs::remove_all(folder_ / "older");
    }
}

}  // namespace
}  // namespace penumbra::test
