// SPDX-License-Identifier: MIT
// What AMD's compiler in Mesa (RADV) makes of every shipped pipeline, on its null hardware: no spill, no
// scratch, registers, occupancy and shared memory within the targets of docs/gpu.md. A pass that misses one
// stands below with what it has now: no worse is let in, and a line that a pass no longer needs has to go.
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/cli_run.h"

namespace penumbra::test {
namespace {

using Json = nlohmann::json;

fs::path radv_manifest() {
    const fs::path folder = "/usr/share/vulkan/icd.d";
    if (fs::exists(folder))
        for (const auto& entry : fs::directory_iterator(folder))
            if (entry.path().filename().string().starts_with("radeon_icd")) return entry.path();
    return {};
}

// A figure that a target bounds.
struct Figure {
    const char* name;
    int value, target;
    bool at_least;
    bool met() const { return at_least ? value >= target : value <= target; }
};

struct Exception {
    std::string family, node_type, figure;
    int now;  // the worst among the pipelines
};

class Statics : public Cli, public ::testing::WithParamInterface<const char*> {
  protected:
    // Environment of the program: this driver alone, as if that hardware were there.
    void SetUp() override {
        Cli::SetUp();
        const fs::path manifest = radv_manifest();
        if (manifest.empty()) {
            if (std::getenv("PENUMBRA_ALL_DRIVERS")) FAIL() << "RADV is not installed (mesa-vulkan-drivers)";
            GTEST_SKIP() << "RADV is not installed (mesa-vulkan-drivers): nothing says what a GPU would run";
        }
        setenv("VK_DRIVER_FILES", manifest.c_str(), 1);
    }
    void TearDown() override {
        unsetenv("VK_DRIVER_FILES");
        unsetenv("RADV_FORCE_FAMILY");
        Cli::TearDown();
    }

    Json statics(const char* family, const std::string& pipelines) {
        setenv("RADV_FORCE_FAMILY", family, 1);
        const Result result = run("statics --format json " + pipelines);
        EXPECT_EQ(result.code, 0) << result.err;
        return Json::parse(result.out, nullptr, false);
    }
};

std::vector<Figure> figures(const std::string& family, const Json& pass) {
    const Json& executable = pass["executables"].at(0);
    const Json& s = executable["statistics"];
    const auto number = [&](const char* name) { return s.at(name).get<int>(); };
    int lanes = 1;
    for (const int n : pass["group"]) lanes *= n;
    const bool wave32 = executable["subgroup_size"] == 32;
    // GCN has 8 to 10 waves of 64 per SIMD where RDNA has 16 of 32 lanes, or 32 of 64 that take turns.
    const int waves = family == "polaris10" || family == "vega10" ? 3 : wave32 ? 8 : 12;
    return {{"spilled SGPRs", number("Spilled SGPRs"), 0, false},
            {"spilled VGPRs", number("Spilled VGPRs"), 0, false},
            {"scratch bytes", number("Scratch size"), 0, false},
            // Where shared memory bounds the waves, the scheduler takes the registers that are left over.
            {"VGPRs", std::min(number("VGPRs"), number("Pre-Sched VGPRs")),
             pass["type"] == "gather" ? 128 : 96, false},
            {"waves per SIMD", number("Subgroups per SIMD"), waves, true},
            {"LDS bytes per 64 lanes", number("LDS size") * 64 / std::max(lanes, 1), 8192, false}};
}

// What stands against the targets; docs/gpu.md says why and what would help.
const std::vector<Exception>& exceptions() {
    static const std::vector<Exception> list = {
        {"navi31", "cover", "VGPRs", 126},
        {"navi31", "cover (lamps)", "VGPRs", 148},
        {"navi31", "cover_lights", "VGPRs", 164},
        {"navi31", "gather", "waves per SIMD", 8},
        {"navi31", "cascades", "waves per SIMD", 6},
        {"navi31", "cascades", "LDS bytes per 64 lanes", 12288},
        {"navi31", "radiance_reference", "VGPRs", 116},
        {"navi31", "reconnect", "VGPRs", 111},
        {"navi21", "cover", "VGPRs", 126},
        {"navi21", "cover (lamps)", "VGPRs", 148},
        {"navi21", "cover (lamps)", "waves per SIMD", 6},
        {"navi21", "cover_lights", "VGPRs", 164},
        {"navi21", "cover_lights", "waves per SIMD", 5},
        {"navi21", "gather", "waves per SIMD", 8},
        {"navi21", "cascades", "waves per SIMD", 6},
        {"navi21", "cascades", "LDS bytes per 64 lanes", 12288},
        {"navi21", "taa", "waves per SIMD", 10},
        {"navi21", "radiance_reference", "VGPRs", 109},
        {"navi21", "reconnect", "VGPRs", 111},
        {"navi21", "reconnect", "waves per SIMD", 8},
        {"polaris10", "beams", "spilled SGPRs", 22},
        {"polaris10", "beams", "VGPRs", 97},
        {"polaris10", "beams", "waves per SIMD", 2},
        {"polaris10", "cover", "VGPRs", 122},
        {"polaris10", "cover", "waves per SIMD", 2},
        {"polaris10", "cover (lamps)", "VGPRs", 144},
        {"polaris10", "cover (lamps)", "waves per SIMD", 1},
        {"polaris10", "cover_lights", "VGPRs", 160},
        {"polaris10", "cover_lights", "waves per SIMD", 1},
        {"polaris10", "cover_lights", "spilled SGPRs", 13},
        {"polaris10", "gather", "waves per SIMD", 2},
        {"polaris10", "cascades", "LDS bytes per 64 lanes", 12288},
        {"polaris10", "radiance_reference", "VGPRs", 125},
        {"polaris10", "radiance_reference", "waves per SIMD", 2},
        {"polaris10", "radiance_rays", "waves per SIMD", 2},
        {"polaris10", "intersect", "waves per SIMD", 2},
        {"polaris10", "reconnect", "VGPRs", 113},
        {"polaris10", "reconnect", "waves per SIMD", 2},
    };
    return list;
}

TEST_P(Statics, EveryPassOfEveryShippedPipelineMeetsItsTargets) {
    std::string pipelines;
    for (const auto& entry : fs::directory_iterator(PENUMBRA_SOURCE_DIR "/pipelines"))
        if (!entry.path().string().ends_with(".schema.json")) pipelines += " " + entry.path().string();
    const std::string family = GetParam();
    const Json document = statics(GetParam(), pipelines);
    ASSERT_TRUE(document.is_object());
    if (!document["driver"].get<std::string>().starts_with("radv Mesa 25")) {
        ASSERT_EQ(std::getenv("PENUMBRA_ALL_DRIVERS"), nullptr)
            << "the lines above are of Mesa 25's compiler, this is " << document["driver"];
        GTEST_SKIP() << "the lines above are of Mesa 25's compiler, this is " << document["driver"];
    }
    size_t passes = 0;
    std::map<std::pair<std::string, std::string>, int> missed;  // type, figure: the worst
    for (const Json& pipeline : document["pipelines"])
        for (const Json& pass : pipeline["passes"]) {
            ++passes;
            for (const Figure& f : figures(family, pass)) {
                if (f.met()) continue;
                // A lamp is another light for each pixel, where the sun is one for all.
                const bool lamp = pass["type"] == "cover" && pipeline["pipeline"] == "light";
                const auto [at, fresh] =
                    missed.try_emplace({lamp ? "cover (lamps)" : pass["type"], f.name}, f.value);
                if (!fresh)
                    at->second = f.at_least ? std::min(at->second, f.value) : std::max(at->second, f.value);
            }
        }
    EXPECT_GT(passes, 80u);
    for (const Exception& e : exceptions()) {
        if (e.family != family) continue;
        const auto found = missed.find({e.node_type, e.figure});
        if (found == missed.end()) {
            ADD_FAILURE() << e.node_type << " meets its target of " << e.figure << " now: take its line out";
            continue;
        }
        const Figure now{e.figure.c_str(), found->second, e.now, e.figure == "waves per SIMD"};
        EXPECT_TRUE(now.met()) << e.node_type << ": " << e.figure << " is " << now.value
                               << ", worse than its line's " << e.now;
        missed.erase(found);
    }
    for (const auto& [what, value] : missed)
        ADD_FAILURE() << "{\"" << family << "\", \"" << what.first << "\", \"" << what.second << "\", "
                      << value << "}, which misses its target";
}

INSTANTIATE_TEST_SUITE_P(Families, Statics, ::testing::Values("navi31", "navi21", "polaris10"),
                         [](const auto& test) { return std::string(test.param); });

// The figures are the driver's for this shader and this family, not a form filled in.
TEST_P(Statics, FollowTheShaderAndTheHardware) {
    const auto of = [&](const char* family, const std::string& arguments, const char* node,
                        const char* name) {
        const Json document = statics(family, arguments);
        for (const Json& pass : document["pipelines"][0]["passes"])
            if (pass["node"] == node) return pass["executables"][0]["statistics"][name].get<int>();
        return -1;
    };
    const std::string raw = "pipelines/raw.json";
    const int rays = of(GetParam(), raw, "trace", "Instructions");
    EXPECT_GT(rays, 100);
    EXPECT_NE(of(GetParam(), raw + " --set nodes.trace.params.origin=published", "trace", "Instructions"),
              rays);
    EXPECT_GT(rays, of(GetParam(), raw, "resolve", "Instructions"));
    EXPECT_NE(of("vega10", raw, "trace", "Code size"), of(GetParam(), raw, "trace", "Code size"));
}

TEST_F(Cli, StaticsOfADeviceThatTellsNoneAreAnError) {
    const Result result = run("statics pipelines/raw.json");
    if (result.code == 0) GTEST_SKIP() << "this device tells what it made of pipelines";
    EXPECT_EQ(result.code, 1);
    EXPECT_EQ(result.out, "");
    EXPECT_NE(result.err.find("VK_KHR_pipeline_executable_properties"), std::string::npos) << result.err;
    expect(run("statics pipelines/nosuch.json"), 2, "no such file");
    expect(run("statics pipelines/raw.json --facts nosuch"), 2, "there is no fact");
    expect(run("statics pipelines/raw.json --format xml"), 2, "xml");
    expect(run("statics pipelines/raw.json --device nosuch"), 2, "no usable Vulkan device is named");
}

}  // namespace
}  // namespace penumbra::test
