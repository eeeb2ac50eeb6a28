// SPDX-License-Identifier: MIT
// penumbra compare on folders: its keys, its exit codes, and what it says where a folder is not what it
// should be.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/mask_folder.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

class Compare : public ::testing::Test {
  protected:
    void SetUp() override {
        root_ = fs::temp_directory_path() / ("penumbra_compare_" + std::to_string(getpid()));
        for (const char* name : {"truth", "a", "b"}) fs::create_directories(root_ / name);
        write_reference_info(root_ / "truth", {"x.shot.json", {8, 4}, true, {}, {}});
        for (const uint32_t frame : {3u, 4u}) {
            write(folder("truth"), frame, 8, 0.5f, true);
            write(folder("a"), frame, 8, 0.75f, false);
        }
        write(folder("b"), 4, 8, 0.25f, false);
    }
    void TearDown() override { fs::remove_all(root_); }

    std::string folder(const char* name) const { return (root_ / name).string(); }

    static void write(const fs::path& folder, uint32_t frame, uint32_t width, float value, bool reference) {
        PlanarImage image{width, 4, {{"Y", PlaneType::real, std::vector<float>(width * 4, value), {}}}};
        if (reference) {
            image.planes.push_back({"receiver", PlaneType::real, std::vector<float>(width * 4, 1), {}});
            image.planes.back().values[0] = 0;
        }
        write_exr(visibility_file(folder, frame), image);
    }

    struct Result {
        int code;
        std::string out, err;
    };
    static Result run(const CompareArguments& arguments) {
        testing::internal::CaptureStdout();
        testing::internal::CaptureStderr();
        const int code = run_compare(arguments);
        std::fflush(stdout);
        std::string out = testing::internal::GetCapturedStdout();
        return {code, std::move(out), testing::internal::GetCapturedStderr()};
    }
    CompareArguments arguments() const {
        CompareArguments a;
        a.image = folder("a");
        a.reference = folder("truth");
        a.json = true;
        return a;
    }

    fs::path root_;
};

TEST_F(Compare, SaysWhatItKnowsAndNullForTheRest) {
    CompareArguments a = arguments();
    a.also = {folder("b")};
    const Result result = run(a);
    ASSERT_EQ(result.code, exit_good) << result.err;
    const auto json = nlohmann::json::parse(result.out);
    EXPECT_EQ(json["frames"], (std::vector<uint32_t>{4}));  // the one that all have
    EXPECT_EQ(json["seeds"], 2);
    EXPECT_EQ(json["pixels"]["receivers"], 31);
    EXPECT_EQ(json["pixels"]["penumbra"], 31);
    EXPECT_NEAR(json["rmse"]["all"].get<double>(), 0.25, 1e-6);
    EXPECT_NEAR(json["n_eff"]["value"].get<double>(), 4, 1e-5);          // .25 / .0625
    EXPECT_NEAR(json["n_eff"]["variance_part"].get<double>(), 2, 1e-5);  // .25 / .125
    EXPECT_TRUE(json["n_eff"]["bias_part"].is_null());
    EXPECT_EQ(json["n_eff"]["exact"], true);
    EXPECT_TRUE(json["rmse"]["umbra"].is_null());
    const std::vector<std::string> keys = {
        "image",          "reference", "frames",  "seeds",    "pixels",       "eps",
        "reference_rays", "rmse",      "psnr_db", "max_abs",  "bias_max_9x9", "ssim",
        "flip",           "relmse",    "n_eff",   "leak",     "acne",         "peter_panning_px",
        "misclassified",  "flicker",   "lag",     "nonfinite"};
    for (const std::string& key : keys) EXPECT_TRUE(json.contains(key)) << key;
    EXPECT_EQ(json.size(), keys.size());
    EXPECT_TRUE(json["lag"]["k90"].is_null() && json["ssim"].is_null());
}

TEST_F(Compare, BorderAndMaskLeavePixelsOut) {
    CompareArguments a = arguments();
    a.frames = "3";
    a.border = 1;
    EXPECT_EQ(nlohmann::json::parse(run(a).out)["pixels"]["receivers"], 12);
    a.border = 0;
    PlanarImage mask{8, 4, {{"Y", PlaneType::real, std::vector<float>(32, 0), {}}}};
    for (size_t p = 0; p < 5; ++p) mask.planes[0].values[p] = 1;
    a.mask = (root_ / "mask.exr").string();
    write_exr(a.mask, mask);
    EXPECT_EQ(nlohmann::json::parse(run(a).out)["pixels"]["receivers"], 4);
}

TEST_F(Compare, MissingPartsAreErrorsWithNames) {
    CompareArguments a = arguments();
    const auto fails = [&](const char* because) {
        const Result result = run(a);
        EXPECT_EQ(result.code, exit_wrong);
        EXPECT_NE(result.err.find(because), std::string::npos) << result.err;
        EXPECT_TRUE(result.out.empty());
    };
    a.frames = "3..5";
    fails("visibility.0005.exr: no such file");
    a.frames = "5..x";
    fails("is not A..B");
    a.frames.clear();
    a.image = folder("nowhere");
    fails("nowhere");
    a.image = folder("a");
    a.reference = folder("b");  // rendered, not a reference
    fails("reference.json");
    a.reference = folder("truth");
    a.mask = folder("no_mask.exr");
    fails("no_mask.exr");
    a.mask.clear();
    fs::remove(visibility_file(folder("b"), 4));
    a.also = {folder("b")};
    fails("no visibility.NNNN.exr");
    write(folder("b"), 9, 8, 0.5f, false);
    fails("shares no frame");
}

TEST_F(Compare, SizesMustAgree) {
    write(folder("a"), 3, 9, 0.5f, false);
    const Result result = run(arguments());
    EXPECT_EQ(result.code, exit_wrong);
    EXPECT_NE(result.err.find("9 x 4 pixels, the reference has 8 x 4"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace penumbra
