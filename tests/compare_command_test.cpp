// SPDX-License-Identifier: MIT
// penumbra compare on folders: its keys, its exit codes, and what it says where a folder is not what it
// should be.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/mask_folder.h"
#include "tests/test_folder.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

class Compare : public ::testing::Test {
  protected:
    void SetUp() override {
        for (const char* name : {"truth", "a", "b"}) fs::create_directories(root_ / name);
        write_reference_info(root_ / "truth", {"x.shot.json", {8, 4}, true, {}, {}});
        for (const uint32_t frame : {3u, 4u}) {
            write(folder("truth"), frame, 8, 0.5f, true);
            write(folder("a"), frame, 8, 0.75f, false);
        }
        write(folder("b"), 4, 8, 0.25f, false);
    }

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

    test::TestFolder root_;
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
    EXPECT_TRUE(json["lag"]["k90"].is_null() && json["flip"]["mean"].is_null());
    EXPECT_TRUE(json["misclassified"]["recall"].is_null() && json["flicker"]["rms"].is_null());
}

TEST_F(Compare, BorderAndMaskLeavePixelsOut) {
    CompareArguments a = arguments();
    a.frames = "3";
    a.border = 1;
    EXPECT_EQ(nlohmann::json::parse(run(a).out)["pixels"]["receivers"], 12);
    a.border = 2;
    EXPECT_NE(run(a).err.find("--border: leaves none of 8 x 4 pixels"), std::string::npos);
    a.border = 0;
    PlanarImage mask{8, 4, {{"Y", PlaneType::real, std::vector<float>(32, 0), {}}}};
    for (size_t p = 0; p < 5; ++p) mask.planes[0].values[p] = 1;
    a.mask = (root_ / "mask.exr").string();
    write_exr(a.mask, mask);
    EXPECT_EQ(nlohmann::json::parse(run(a).out)["pixels"]["receivers"], 4);
}

// A number that does not fit is no other number.
TEST_F(Compare, NumbersBeyond32BitsAreNotTaken) {
    const std::string json = [&] {
        std::ifstream stream(root_ / "truth/reference.json");
        return std::string(std::istreambuf_iterator<char>(stream), {});
    }();
    const auto taken = [&](const std::string& from, const std::string& to) {
        std::string text = json;
        std::ofstream(root_ / "truth/reference.json") << text.replace(text.find(from), from.size(), to);
        Diagnostics diagnostics;
        return read_reference_info(root_ / "truth", diagnostics).has_value();
    };
    for (const std::string number : {"7", "4294967300", "-4", "4.5", "1e300"}) {
        SCOPED_TRACE(number);
        const bool fits = number == "7";
        EXPECT_EQ(taken("\"rays\": null", "\"rays\": " + number), fits);
        EXPECT_EQ(taken("4\n", number + "\n"), fits);  // the height
        EXPECT_EQ(
            taken("\"frames\": []", "\"frames\": [{\"frame\": " + number +
                                        R"(, "to_sun": [0, 0, 1], "jitter": [0, 0], "contact": null}])"),
            fits);
        std::ofstream(root_ / "a/report.json")
            << R"({"shot_file": "x.shot.json", "size": [8, 4], "by_frame": [{"frame": )" << number
            << R"(, "jitter": [0, 0]}]})";
        Diagnostics diagnostics;
        EXPECT_EQ(read_rendered_frames(root_ / "a", diagnostics).has_value(), fits);
    }
    std::ofstream(root_ / "a/visibility.4294967300.exr");
    Diagnostics diagnostics;
    EXPECT_EQ(visibility_frames(root_ / "a", diagnostics), (std::vector<uint32_t>{3, 4}));
}

// A light's mask may be there twice, as an image of its own and as a layer.
TEST_F(Compare, AFrameIsListedOnce) {
    for (const char* file : {"visibility_bulb.0003.exr", "masks.bulb.0003.exr", "masks.bulb.0001.exr"})
        std::ofstream(root_ / "a" / file);
    Diagnostics diagnostics;
    EXPECT_EQ(visibility_frames(root_ / "a", diagnostics, "bulb"), (std::vector<uint32_t>{1, 3}));
}

TEST_F(Compare, OptionsThatSayNothingHereAreErrors) {
    CompareArguments a = arguments();
    const auto fails = [&](const char* because) {
        const Result result = run(a);
        EXPECT_EQ(result.code, exit_wrong);
        EXPECT_NE(result.err.find(because), std::string::npos) << result.err;
    };
    for (const char* signal : {"visibility", "transmittance", "specular"}) {
        a.signal = signal;
        a.picture = folder("picture.png");
        fails("--picture: is of pictures");
    }
    a.picture.clear();
    a.signal = "transmittance";
    a.light = "bulb";
    fails("shares no frame");
    for (const char* name : {"truth", "a"}) std::ofstream(root_ / name / "transmittance.0003.exr");
    fails("has transmittance of one: leave it out");
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

// A folder that `reference` has written into twice.
TEST_F(Compare, OlderFramesOfATruthsFolderAreNotItsOwn) {
    ReferenceInfo info{"x.shot.json", {8, 4}, true, {}, {}};
    info.frames[3] = {};
    write_reference_info(root_ / "truth", info);
    CompareArguments a = arguments();
    const Result result = run(a);
    ASSERT_EQ(result.code, exit_good) << result.err;
    EXPECT_EQ(nlohmann::json::parse(result.out)["frames"], (std::vector<uint32_t>{3}));
    a.frames = "3..4";
    const Result asked = run(a);
    EXPECT_EQ(asked.code, exit_wrong);
    EXPECT_NE(asked.err.find("frame 4 is none of this truth's"), std::string::npos) << asked.err;
}

TEST_F(Compare, ATruthOfAnotherLightOrOfOtherPointsIsRefused) {
    const auto report = [&](const std::string& light, const std::string& jitter) {
        std::ofstream(root_ / "a/report.json")
            << R"({ "shot_file": "x.shot.json", "size": [8, 4], "light": ")" << light
            << R"(", "by_frame": [ { "frame": 3, "jitter": )" << jitter << " } ] }";
    };
    const auto fails = [&](const CompareArguments& a, const std::string& because) {
        const Result result = run(a);
        EXPECT_EQ(result.code, exit_wrong);
        EXPECT_NE(result.err.find(because), std::string::npos) << result.err;
    };
    ReferenceInfo info{"x.shot.json", {8, 4}, true, {}, {}, "bulb"};
    info.frames[3] = {};
    write_reference_info(root_ / "truth", info);
    CompareArguments a = arguments();
    report("panel", "[0, 0]");
    fails(a, R"(is "panel", the reference)");
    report("bulb", "[0, 0]");
    EXPECT_EQ(run(a).code, exit_good);
    report("bulb", "[0.01, 0]");
    fails(a, "beside their centres");
    // A truth of radiance is one of centres, whatever that of visibility beside it is of.
    info.frames[3].jitter = {0.01, 0};
    write_reference_info(root_ / "truth", info);
    EXPECT_EQ(run(a).code, exit_good);
    for (const char* name : {"truth", "a"})
        fs::copy(visibility_file(folder(name), 3), root_ / name / "specular.0003.exr");
    a.signal = "specular";
    fails(a, "beside their centres");
}

// Nor is what cannot be looked at the program's own failure.
TEST_F(Compare, NamesThatNoFileCanHaveAreErrors) {
    CompareArguments a = arguments();
    a.frames = "3";
    const std::string too_long = folder(std::string(300, 'a').c_str());
    const auto fails = [&](const std::string& because) {
        const Result result = run(a);
        EXPECT_EQ(result.code, exit_wrong);
        EXPECT_NE(result.err.find(because), std::string::npos) << result.err;
    };
    a.image = too_long;
    for (const char* signal : {"visibility", "specular", "transmittance", "color"}) {
        a.signal = signal;
        fails(too_long + "/report.json: cannot be read: ");
    }
    a.frames.clear();
    fails(too_long + ": cannot be listed: ");
}

// Of a range that nobody has, one frame is told: the loop would else go on for ever.
TEST_F(Compare, TheFirstMissingFrameIsEnough) {
    CompareArguments a = arguments();
    a.frames = "5..20000";
    for (const char* signal : {"visibility", "specular", "transmittance", "color"}) {
        a.signal = signal;
        const Result result = run(a);
        EXPECT_EQ(result.code, exit_wrong);
        EXPECT_NE(result.err.find(a.signal + ".0005.exr: no such file"), std::string::npos) << result.err;
        EXPECT_EQ(result.err.find("0006"), std::string::npos) << result.err.substr(0, 1000);
    }
}

// Frames of five digits are frames, and names of files are bytes.
TEST_F(Compare, PicturesOfALongShotAreFound) {
    const fs::path image = root_ / "im\xffge";
    fs::create_directories(image);
    PlanarImage picture{8, 4, {}};
    for (const char* name : {"R", "G", "B", "receiver", "visibility"})
        picture.planes.push_back({name, PlaneType::real, std::vector<float>(32, 1), {}});
    for (const char* name : {"color.12000.exr", "transmittance.12000.exr"})
        for (const fs::path& to : {image, root_ / "truth"}) write_exr(to / name, picture);
    CompareArguments a = arguments();
    a.image = image.string();
    for (const char* signal : {"color", "transmittance"}) {
        a.signal = signal;
        const Result result = run(a);
        ASSERT_EQ(result.code, exit_good) << result.err;
        const auto json = nlohmann::json::parse(result.out);
        EXPECT_NE(json["image"].get<std::string>().find("/im\xef\xbf\xbdge"), std::string::npos);
        const auto& frame = json["frames"][0];
        EXPECT_EQ(frame.is_object() ? frame["frame"] : frame, 12000);
    }
    a.signal = "visibility";
    write(image, 3, 8, 0.5f, false);
    EXPECT_EQ(run(a).code, exit_good);
    a.signal = "color";
    a.picture = (root_ / "truth/color.12000.exr").string();
    const Result refused = run(a);
    EXPECT_EQ(refused.code, exit_wrong);
    EXPECT_NE(refused.err.find("color.12000.exr: is read, and would be written over"), std::string::npos)
        << refused.err;
    Diagnostics diagnostics;
    EXPECT_TRUE(read_exr(a.picture, diagnostics)) << diagnostics.text();
}

// What folders say of themselves must fit. Those of another program say nothing.
TEST_F(Compare, TheTruthOfAnotherShotIsRefused) {
    const auto report = [&](const std::string& shot) {
        std::ofstream(root_ / "a/report.json")
            << R"({"shot_file": ")" + shot + R"(", "size": [8, 4], "by_frame": []})";
    };
    PlanarImage picture{8, 4, {}};
    for (const char* name : {"R", "G", "B", "receiver", "visibility", "roughness", "ray_error", "noise"})
        picture.planes.push_back({name, PlaneType::real, std::vector<float>(32, 1), {}});
    for (const char* name : {"specular.0003.exr", "transmittance.0003.exr", "lit.0003.exr"})
        for (const char* to : {"a", "truth"}) write_exr(root_ / to / name, picture);
    CompareArguments a = arguments();
    for (const char* signal : {"visibility", "specular", "transmittance", "lit"}) {
        SCOPED_TRACE(signal);
        a.signal = signal;
        report("../../shots/x.shot.json");
        EXPECT_EQ(run(a).code, exit_good) << "the way to a shot is another one from elsewhere";
        report("../../shots/y.shot.json");
        const Result result = run(a);
        EXPECT_EQ(result.code, exit_wrong);
        EXPECT_NE(result.err.find(folder("a") + ": shows y.shot.json, the reference " + folder("truth") +
                                  " is of x.shot.json"),
                  std::string::npos)
            << result.err;
        EXPECT_TRUE(result.out.empty());
    }
    fs::remove(root_ / "truth/reference.json");
    a.signal = "specular";
    EXPECT_EQ(run(a).code, exit_good);
    fs::remove(root_ / "a/lit.0003.exr");
    a.signal = "lit";
    EXPECT_NE(run(a).err.find("there is no image of it: render with --capture lit"), std::string::npos);
}

TEST_F(Compare, AlsoTakesTheSameImagesUnderAnotherSeed) {
    PlanarImage picture{8, 4, {}};
    for (const char* name : {"R", "G", "B", "receiver", "visibility", "roughness", "ray_error", "noise"})
        picture.planes.push_back({name, PlaneType::real, std::vector<float>(32, 1), {}});
    fs::create_directories(root_ / "c");
    write(folder("c"), 4, 8, 0.25f, false);
    for (const char* name : {"specular.0004.exr", "transmittance.0004.exr"})
        for (const char* to : {"a", "b", "c", "truth"}) write_exr(root_ / to / name, picture);
    CompareArguments a = arguments();
    a.also = {folder("b"), folder("c")};
    const nlohmann::json first = {{"pipeline", "p"},
                                  {"shot", "x"},
                                  {"light", nullptr},
                                  {"shot_file", "x.shot.json"},
                                  {"size", {8, 4}},
                                  {"by_frame", nlohmann::json::array()},
                                  {"seed", 1},
                                  {"settings", {{"s", 1}}},
                                  {"facts", {{"alpha", false}}}};
    const auto report = [&](const char* of, const nlohmann::json& json) {
        std::ofstream(root_ / of / "report.json") << json.dump();
    };
    const auto with = [&](const char* key, const nlohmann::json& value) {
        nlohmann::json json = first;
        json["seed"] = 3;
        json[key] = value;
        return json;
    };
    for (const char* signal : {"visibility", "specular", "transmittance"}) {
        SCOPED_TRACE(signal);
        a.signal = signal;
        const auto fails = [&](const std::string& because) {
            const Result result = run(a);
            EXPECT_EQ(result.code, exit_wrong);
            EXPECT_NE(result.err.find(because), std::string::npos) << result.err;
        };
        report("a", first);
        report("b", with("seed", 2));
        fs::remove(root_ / "c/report.json");
        EXPECT_EQ(run(a).code, exit_good) << "one of them says nothing";
        report("c", with("seed", 3));
        EXPECT_EQ(run(a).code, exit_good);
        report("c", with("seed", 2));
        fails(folder("c") + ": seed: is 2 in " + folder("b") + ", too");
        report("c", with("pipeline", "q"));
        fails(folder("c") + ": pipeline: is not that of " + folder("a"));
        report("c", with("settings", nlohmann::json::object()));
        fails(folder("c") + ": settings: is not that of");
        report("c", with("facts", {{"alpha", true}}));
        EXPECT_EQ(run(a).code, exit_good) << "another device's";
        report("c", with("shot", "y"));
        fails(folder("c") + ": shot: is not that of");
        for (const char* of : {"a", "b", "c"}) fs::remove(root_ / of / "report.json");
        a.also = {folder("b"), folder("b") + "/../b"};
        fails("this folder is given twice");
        a.also = {folder("a")};
        fails("this folder is given twice");
        a.also = {folder("b"), folder("c")};
    }
}

// Left out, it would help.
TEST_F(Compare, ColoursThatAreNoNumberAreTheWorstError) {
    PlanarImage truth{8, 4, {}};
    for (const char* name : {"R", "G", "B", "receiver", "visibility"})
        truth.planes.push_back({name, PlaneType::real, std::vector<float>(32, 1), {}});
    PlanarImage image = truth;
    image.planes[1].values[5] = std::numeric_limits<float>::quiet_NaN();
    write_exr(root_ / "truth/transmittance.0003.exr", truth);
    write_exr(root_ / "a/transmittance.0003.exr", image);
    CompareArguments a = arguments();
    a.signal = "transmittance";
    const auto json = nlohmann::json::parse(run(a).out);
    EXPECT_EQ(json["nonfinite"], 1);
    EXPECT_EQ(json["all"]["pixels"], 32);
    EXPECT_NEAR(json["all"]["bias"]["G"].get<double>(), -1.0 / 32, 1e-9);
    EXPECT_EQ(json["all"]["bias"]["R"], 0);
}

TEST_F(Compare, SizesMustAgree) {
    write(folder("a"), 3, 9, 0.5f, false);
    const Result result = run(arguments());
    EXPECT_EQ(result.code, exit_wrong);
    EXPECT_NE(result.err.find("9 x 4 pixels, the reference has 8 x 4"), std::string::npos) << result.err;
}

// Folders with all that `reference` and `render --capture` write: a shadow edge that jumps at frame 2, an
// image that follows a frame later, under a sun, on a surface, decided by words.
class CompareSequence : public Compare {
  protected:
    static constexpr uint32_t width = 64, height = 32;

    static float truth(uint32_t frame, uint32_t x) {
        const float edge = frame < 2 ? 20.0f : 40.0f;  // light on the right, penumbra of 8 pixels
        return std::clamp((static_cast<float>(x) + 0.5f - edge) / 8.0f + 0.5f, 0.0f, 1.0f);
    }
    template <class Value>
    static Plane plane(const char* name, Value value) {
        Plane plane{name, PlaneType::real, {}, {}};
        for (uint32_t p = 0; p < width * height; ++p) plane.values.push_back(value(p % width, p / width));
        return plane;
    }
    static Plane constant(const char* name, float value) {
        return plane(name, [value](uint32_t, uint32_t) { return value; });
    }
    static Plane words(uint32_t value, size_t count = width / 8 * height / 4) {
        return {"W", PlaneType::uint, {}, std::vector<uint32_t>(count, value)};
    }
    static void write_image(const fs::path& folder, const char* name, uint32_t frame,
                            std::vector<Plane> planes, uint32_t div_x = 1, uint32_t div_y = 1) {
        write_exr(folder / (name + std::string(".000") + std::to_string(frame) + ".exr"),
                  {width / div_x, height / div_y, std::move(planes)});
    }
    void SetUp() override {
        Compare::SetUp();
        for (const char* name : {"truth", "a"})
            for (const auto& entry : fs::directory_iterator(root_ / name)) fs::remove(entry.path());
        ReferenceInfo info{"x.shot.json", {width, height}, true, {}, {}};
        for (uint32_t frame = 0; frame < 6; ++frame) {
            info.frames[frame] = {{0, 0, 1}, {}, ContactLine{{20, 4}, {20, 28}, {-1, 0}}};
            const fs::path t = root_ / "truth", a = root_ / "a";
            write_image(t, "visibility", frame,
                        {plane("Y", [&](uint32_t x, uint32_t) { return truth(frame, x); }),
                         constant("receiver", 1), constant("rays", 0)});
            write_image(t, "motion", frame, {constant("X", 0), constant("Y", 0), constant("Z", 0)});
            write_image(t, "depth", frame, {constant("Z", 5)});
            write_image(t, "normal", frame, {constant("X", 0), constant("Y", 0), constant("Z", 1)});
            write_image(t, "albedo", frame, {constant("R", 0.5f), constant("G", 0.5f), constant("B", 0.5f)});
            write_image(
                a, "visibility", frame,
                {plane("Y", [&](uint32_t x, uint32_t) { return truth(frame == 2 ? 1 : frame, x) * 0.98f; })});
            write_image(a, "undecided_words", frame, {words(0x0f0f0f0f)}, 8, 4);
            write_image(a, "preloaded_hits", frame, {words(0)}, 8, 4);
        }
        write_reference_info(folder("truth"), info);
    }
};

TEST_F(CompareSequence, TellsAllThatTheFilesCarry) {
    const Result result = run(arguments());
    ASSERT_EQ(result.code, exit_good) << result.err;
    const auto json = nlohmann::json::parse(result.out);
    EXPECT_EQ(json["lag"]["k90"], 1);
    EXPECT_NEAR(json["lag"]["residual"].get<double>(), 1, 0.02);
    EXPECT_NEAR(json["lag"]["lag_px"].get<double>(), 20, 0.5);  // the one frame in which the truth moved
    EXPECT_GT(json["flicker"]["rms"].get<double>(), 0.1);       // the late jump
    EXPECT_GT(json["flip"]["mean"].get<double>(), 0.001);
    EXPECT_GT(json["flip"]["p95"].get<double>(), json["flip"]["mean"].get<double>());
    EXPECT_GT(json["relmse"].get<double>(), 0);
    EXPECT_LT(json["ssim"].get<double>(), 0.99);
    EXPECT_NEAR(json["bias_max_9x9"].get<double>(), 0.98, 0.02);
    EXPECT_EQ(json["peter_panning_px"].get<double>(), 0);
    const auto& m = json["misclassified"];
    EXPECT_NEAR(m["recall"].get<double>(), 0.5, 0.1);  // every other half tile is traced
    EXPECT_GT(m["false_lit"].get<double>(), 0.1);      // nothing is decided shadowed
    EXPECT_EQ(m["false_shadow"].get<double>(), 0);
    EXPECT_TRUE(m["interval"].is_null());

    CompareArguments whole = arguments();  // one of the tile's 16 rays answers otherwise
    whole.whole_rays = folder("whole");
    fs::create_directories(root_ / "whole");
    EXPECT_EQ(run(whole).code, exit_wrong) << "asked for, and not there";
    for (uint32_t frame = 0; frame < 6; ++frame) {
        write_image(root_ / "a", "hits", frame, {words(0x00ff0001)}, 8, 4);
        write_image(root_ / "whole", "hits", frame, {words(0xf0ff0003)}, 8,
                    4);  // four of others do not count
    }
    EXPECT_NEAR(nlohmann::json::parse(run(whole).out)["misclassified"]["interval"].get<double>(), 1.0 / 16,
                1e-12);

    fs::remove(root_ / "a" / "undecided_words.0002.exr");
    const Result undecided = run(whole);
    EXPECT_EQ(undecided.code, exit_wrong);
    EXPECT_NE(undecided.err.find("needs a capture of undecided_words, and frame 2 has none"),
              std::string::npos)
        << undecided.err;

    CompareArguments text = arguments();
    text.json = false;
    EXPECT_NE(run(text).out.find("after a change 1 frames"), std::string::npos) << run(text).out;
}

TEST_F(CompareSequence, FilesOfTheWrongSizeOrKindAreErrors) {
    const auto fails = [&](const char* because) {
        const Result result = run(arguments());
        EXPECT_EQ(result.code, exit_wrong);
        EXPECT_NE(result.err.find(because), std::string::npos) << result.err;
    };
    write_image(root_ / "a", "undecided_words", 3, {words(0, 128)}, 8, 2);
    fails("8 x 16 words, the reference has 8 x 8 tiles");
    write_image(root_ / "a", "undecided_words", 3, {constant("W", 1)});
    fails("does not hold integers");
    fs::remove(root_ / "a" / "undecided_words.0003.exr");
    write_image(root_ / "truth", "motion", 3, {constant("X", 0), constant("Y", 0)});
    fails("motion.0003.exr: Z: there is no such channel");
}

TEST_F(CompareSequence, OldReferencesAreToldApart) {
    const std::string old = R"({"penumbra": 1, "shot": "x", "size": [64, 32], "exact": true, "rays": null})";
    write_file(root_ / "truth" / "reference.json", std::as_bytes(std::span(old)));
    const Result result = run(arguments());
    EXPECT_EQ(result.code, exit_wrong);
    EXPECT_NE(result.err.find("of this version"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace penumbra
