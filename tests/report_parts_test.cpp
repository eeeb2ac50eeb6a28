// SPDX-License-Identifier: MIT
// Parts of `penumbra report`: medians and their intervals, axes, markup, layouts, what is kept of a
// measurement.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <random>

#include "app/bench/bench.h"
#include "app/mask_passes.h"
#include "app/progress.h"
#include "app/report/html.h"
#include "app/report/images.h"
#include "app/report/layered_layout.h"
#include "app/report/parts.h"
#include "app/report/shots.h"
#include "app/report/statistics.h"
#include "app/report/svg.h"
#include "tests/report_results.h"
#include "tests/test_folder.h"

namespace penumbra::report {
namespace {

namespace fs = std::filesystem;

// Whatever a shot has that moves: in a report's file of it as in what `bench --still` runs.
TEST(ReportShots, StandingStillNothingMoves) {
    const test::TestFolder folder;
    const fs::path file = folder / "moving.shot.json";
    std::ofstream(file) << R"({ "penumbra_shot": 1, "scene": "none.gltf", "animation": "walk", "frames": 9,
  "camera": { "keys": [{ "frame": 0, "position": [0, 1, 5], "target": [0, 0, 0] },
                       { "frame": 8, "position": [2, 1, 5], "target": [0, 0, 0] }] },
  "objects": { "box": { "keys": [{ "frame": 0 }, { "frame": 8, "translation": [1, 0, 0] }] } },
  "sun": { "keys": [{ "frame": 0, "to_sun": [0, 1, 0] }, { "frame": 8, "to_sun": [1, 1, 0] }] },
  "lights": { "bulb": { "kind": "sphere", "radius": 0.1, "luminance": 60000,
                        "keys": [{ "frame": 0, "position": [0, 3, 0] }, { "frame": 8, "position": [1, 3, 0] }] } } })";
    Diagnostics diagnostics;
    const auto shot = open_report_shot(file, folder, 4, diagnostics);
    ASSERT_TRUE(shot && shot->still) << diagnostics.text();
    for (const Shot& still : {*shot->still, bench::standing_still(shot->moving)}) {
        EXPECT_EQ(still.camera.size(), 1u);
        EXPECT_EQ(still.sun.size(), 1u);
        EXPECT_EQ(still.objects.at("box").keys.size(), 1u);
        EXPECT_EQ(still.lights.at("bulb").keys.size(), 1u);
        EXPECT_EQ(still.animation, "");
    }
}

TEST(ReportMedian, IsTheMiddleAndHasNoIntervalBelowSixSamples) {
    EXPECT_FALSE(median_of({}));
    EXPECT_EQ(median_of({3, 1, 2})->median, 2);
    EXPECT_EQ(median_of({4, 1, 2, 3})->median, 2.5);
    EXPECT_FALSE(median_of({1, 2, 3, 4, 5})->low);  // 2 * 2^-5 > 5 %: no interval can be had
    const Estimate six = *median_of({6, 5, 4, 3, 2, 1});
    EXPECT_EQ(six.low, 1);
    EXPECT_EQ(six.high, 6);
    // n = 20: P(X <= 5) = 2.07 %, P(X <= 6) = 5.8 %; so from the 6th smallest to the 6th largest.
    std::vector<double> twenty;
    for (int i = 1; i <= 20; ++i) twenty.push_back(i);
    EXPECT_EQ(median_of(twenty)->low, 6);
    EXPECT_EQ(median_of(twenty)->high, 15);
}

TEST(ReportMedian, IntervalHoldsTheTrueMedianOfALongTail) {
    std::mt19937 random(7);
    std::exponential_distribution<double> tail(1);
    int held = 0;
    constexpr int draws = 2000;
    for (int draw = 0; draw < draws; ++draw) {
        std::vector<double> samples(25);
        for (double& s : samples) s = tail(random);
        const Estimate e = *median_of(samples);
        held += *e.low <= std::log(2.0) && std::log(2.0) <= *e.high;
    }
    EXPECT_GE(held, draws * 95 / 100);  // exact: 95.7 %, and never below 95 %
    EXPECT_LE(held, draws * 98 / 100);  // nor so wide that it says nothing
}

TEST(ReportAxis, TicksAreRoundAndCoverAllValues) {
    const Axis axis = linear_axis({0.3, 7.2}, true);
    EXPECT_EQ(axis.low, 0);
    EXPECT_EQ(axis.high, 8);
    std::vector<std::string> labels;
    for (const Tick& tick : axis.ticks) labels.push_back(tick.label);
    EXPECT_EQ(labels, (std::vector<std::string>{"0", "2", "4", "6", "8"}));
    EXPECT_EQ(axis.at(4), 0.5);
    // Adding up 0.1 gives 0.30000000000000004, and such labels.
    for (const Tick& tick : linear_axis({0, 0.5}, true).ticks) EXPECT_LE(tick.label.size(), 3u);
    EXPECT_FALSE(linear_axis({}, true).ticks.empty());
    EXPECT_GT(linear_axis({5, 5}, false).high, 5);
}

TEST(ReportAxis, LogarithmsTakeWhatIsPositive) {
    const Axis axis = log_axis({0.013, 0.38, 0, -1, NAN});
    EXPECT_DOUBLE_EQ(axis.low, 0.01);
    EXPECT_DOUBLE_EQ(axis.high, 0.5);
    EXPECT_EQ(axis.at(0.01), 0);
    EXPECT_EQ(axis.at(0.5), 1);
    EXPECT_NEAR(axis.at(std::sqrt(0.01 * 0.5)), 0.5, 1e-12);
    EXPECT_EQ(axis.ticks.size(), 6u);  // .01 .02 .05 .1 .2 .5
    const Axis wide = log_axis({1, 2e4});
    for (const Tick& tick : wide.ticks)  // decades alone
        EXPECT_NEAR(std::log10(tick.value), std::round(std::log10(tick.value)), 1e-9);
    EXPECT_LT(log_axis({10, 10}).low, log_axis({10, 10}).high);
    EXPECT_LT(log_axis({}).low, log_axis({}).high);
}

TEST(ReportHtml, EscapesWhatCouldEndATextOrAnAttribute) {
    EXPECT_EQ(escape("<a href=\"x\">'&"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;");
    Svg svg(10, 10, "\"><script>");
    svg.circle({1, 1}, 1, "dot", "a < b");
    svg.text({1, 1}, "</svg>");
    EXPECT_EQ(svg.str().find("<script>"), std::string::npos);
    EXPECT_NE(svg.str().find("<title>a &lt; b</title>"), std::string::npos);
    EXPECT_EQ(svg.str().find("</svg>"), svg.str().size() - 7);
}

TEST(ReportHtml, TemplatesAreFilledWhollyOrNotAtAll) {
    EXPECT_EQ(fill("a{{x}}b{{x}}{{y}}", {{"x", "{{y}}"}, {"y", "2"}}), "a{{y}}b{{y}}2");
    EXPECT_THROW(fill("{{x}}", {}), std::logic_error);
    EXPECT_THROW(fill("", {{"x", ""}}), std::logic_error);
    EXPECT_THROW(fill("{{x", {{"x", ""}}), std::logic_error);
    Table table("c", {{"a", false}, {"b"}});
    EXPECT_THROW(table.row({"1"}), std::logic_error);
}

TEST(ReportHtml, Base64AgreesWithTheRfc) {
    const std::pair<const char*, const char*> known[] = {{"", ""},
                                                         {"f", "Zg=="},
                                                         {"fo", "Zm8="},
                                                         {"foo", "Zm9v"},
                                                         {"foob", "Zm9vYg=="},
                                                         {"fooba", "Zm9vYmE="},
                                                         {"foobar", "Zm9vYmFy"}};
    for (const auto& [plain, coded] : known) EXPECT_EQ(base64(plain), coded);
    EXPECT_EQ(base64("\xff\xfe"), "//4=");
}

TEST(ReportHtml, NumbersKeepTheirSize) {
    EXPECT_EQ(number(0.3141), "0.314");
    EXPECT_EQ(number(0.03141), "0.0314");
    EXPECT_EQ(number(31.41), "31.4");
    EXPECT_EQ(number(12345.6), "12346");
    EXPECT_EQ(number(2e-7), "2.0e-07");
    EXPECT_EQ(number(NAN), "not finite");
}

TEST(ReportImages, ErrorsOfBothSignsDifferAndRightIsWhite) {
    EXPECT_EQ(error_color(0), (std::array<float, 3>{1, 1, 1}));
    EXPECT_GT(error_color(0.3)[0], error_color(0.3)[2]);    // too bright: orange
    EXPECT_LT(error_color(-0.3)[0], error_color(-0.3)[2]);  // too dark: blue
    EXPECT_EQ(error_color(0.5), error_color(1));
    EXPECT_EQ(error_color(NAN), (std::array<float, 3>{1, 0, 1}));
}

// A ladder with its rungs crossed: the order as given has as many crossings as can be, the best has none.
TEST(ReportLayout, UncrossesWhatCanBeUncrossedAndLeavesGaps) {
    std::vector<LayoutItem> items;
    constexpr size_t rungs = 6;
    for (size_t i = 0; i < rungs; ++i) items.push_back({0, 10, {}});
    for (size_t i = 0; i < rungs; ++i) items.push_back({1, 20, {rungs - 1 - i}});
    for (size_t i = 0; i < rungs; ++i) items[rungs + i].y = items[i].y = static_cast<double>(i);
    EXPECT_EQ(crossings(items), rungs * (rungs - 1) / 2);
    arrange(items, 5);
    EXPECT_EQ(crossings(items), 0u);
    for (size_t a = 0; a < items.size(); ++a)
        for (size_t b = 0; b < items.size(); ++b)
            if (a != b && items[a].layer == items[b].layer && items[a].y <= items[b].y) {
                EXPECT_GE(items[b].y - items[a].y, items[a].height + 5 - 1e-9);
            }
}

TEST(ReportProgress, ForetellsTheTimeThatIsLeft) {
    EXPECT_EQ(time_left(10, 25, 100), "about 30 s left");
    EXPECT_EQ(time_left(600, 25, 100), "about 30 min left");
    EXPECT_EQ(time_left(3600, 25, 100), "about 3.0 h left");
    EXPECT_EQ(time_left(10, 0, 100), "");  // nothing to tell it from
    EXPECT_EQ(time_left(10, 100, 100), "");
}

// Names of materials and nodes are a file's.
TEST(ReportProgress, WarnsInPrintableLinesAndOnce) {
    testing::internal::CaptureStderr();
    print_warnings(std::vector<std::string>{"\x1b[31mred", "\x1b[31mred", "two\nlines"});
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "warning: \\x1b[31mred\nwarning: two\\x0alines\n");
}

class ReportPart : public ::testing::Test {
  protected:
    void SetUp() override {
        fs::create_directories(folder_ / "parts");
        fs::create_directories(folder_ / "images");
        results_ = test::made_up_results();
        for (Contender& contender : results_.contenders) contender.file.clear();
        results_.contenders[0].file = write("derived.json", R"({"extends": "base.json"})");
        write("base.json", "{}");
        results_.shots[0].reference_image = "images/reference.png";
        write("images/reference.png", "a picture");
        results_.shots[0].motion_image = "images/hall.motion.webp";
        write("images/hall.motion.webp", "a picture that moves");
        shot_.file = write("hall.shot.json", "{}");
        shot_.model =
            write("hall.gltf", R"({"buffers": [{"uri": "hall.bin"}], "images": [{"uri": "a%20wall.png"}]})");
        write("hall.bin", "triangles");
        write("a wall.png", "a picture of it");
        shot_.environment = EnvironmentFile{write("sky.exr", "a sky")};
    }

    std::string write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name) << text;
        return (folder_ / name).string();
    }
    Parts parts(const std::vector<std::string>& nodes = {}) const { return {folder_, results_, nodes}; }
    Parts::Name name(const Parts& parts) const { return parts.name("shot.hall", {shot_}); }
    bool found(const std::vector<std::string>& nodes = {}) const {
        const Parts now = parts(nodes);
        return now.find(name(now)).has_value();
    }

    test::TestFolder folder_;
    Results results_;
    Shot shot_;
};

TEST_F(ReportPart, IsUsedAgainWhereAllThatItDependsOnIsTheSame) {
    EXPECT_FALSE(found());
    parts().keep(name(parts()), to_json(results_));
    ASSERT_TRUE(found());
    EXPECT_EQ(*parts().find(name(parts())), to_json(results_));

    // Each of these is another measurement; what was there comes back into use with what it was measured
    // from.
    const auto changed = [&](const char* what, auto&& change, auto&& back) {
        change();
        EXPECT_FALSE(found()) << what;
        back();
        EXPECT_TRUE(found()) << what;
    };
    for (const char* file :
         {"derived.json", "base.json", "hall.shot.json", "hall.gltf", "hall.bin", "a wall.png", "sky.exr"}) {
        std::ifstream stream(folder_ / file);
        const std::string before((std::istreambuf_iterator<char>(stream)), {});
        changed(
            file, [&] { write(file, before + " "); }, [&] { write(file, before); });
    }
    const Results before = results_;
    const auto back = [&] { results_ = before; };
    changed(
        "size", [&] { results_.study.size[0] += 1; }, back);
    changed(
        "seeds", [&] { results_.study.seeds += 1; }, back);
    changed(
        "driver", [&] { results_.device.driver = "another"; }, back);
    changed(
        "contenders", [&] { results_.contenders.pop_back(); }, back);
    // Plain rays at a lamp are a file's, those at the sun the program's own.
    results_.contenders.push_back({"rays_4", write("rays.json", "{}"), "", PlainRays{4, false}, {"rays=4"}});
    parts().keep(name(parts()), to_json(results_));
    write("rays.json", "{ }");
    EXPECT_TRUE(found());
    results_.study.light = "lamp";
    parts().keep(name(parts()), to_json(results_));
    ASSERT_TRUE(found());
    write("rays.json", "{}");
    EXPECT_FALSE(found());
    results_ = before;
    parts().keep(name(parts()), to_json(results_));
    fs::create_directories(folder_ / "nodes");
    write("nodes/mine.json", "{}");
    EXPECT_FALSE(found({(folder_ / "nodes").string()}));
}

TEST_F(ReportPart, DependsOnTheFilesOfAModelWhateverItsNameIs) {
    const std::string document = R"({"buffers": [{"uri": "hall.bin"}]})";
    const std::string binary = std::string("glTF\2\0\0\0\0\0\0\0", 12) +
                               std::string{static_cast<char>(document.size()), 0, 0, 0} + "JSON" + document;
    for (const auto& [file, text] : {std::pair{"HALL.GLTF", document}, std::pair{"hall.glb", binary}}) {
        shot_.model = write(file, text);
        write("hall.bin", "triangles");
        parts().keep(name(parts()), to_json(results_));
        ASSERT_TRUE(found()) << file;
        write("hall.bin", "other triangles");
        EXPECT_FALSE(found()) << file;
    }
}

// Names are bytes, and may be longer than a file's can be.
TEST_F(ReportPart, IsKeptWhateverItsShotIsCalled) {
    results_.shots[0].file = "h\xffll.shot.json";
    parts().keep(name(parts()), to_json(results_));
    EXPECT_TRUE(found());
    EXPECT_FALSE(parts().find(parts().name("shot." + std::string(300, 'a'), {shot_})));
    shot_.model = write("hall.gltf", R"({"images": [{"uri": ")" + std::string(300, 'a') + "\"}]}");
    EXPECT_NO_THROW(name(parts()));
}

TEST_F(ReportPart, IsGoneWithItsImagesOrWhereItIsNotWhole) {
    parts().keep(name(parts()), to_json(results_));
    fs::remove(folder_ / "images/reference.png");
    EXPECT_FALSE(found());
    write("images/reference.png", "a picture");
    ASSERT_TRUE(found());
    parts().forget(name(parts()));
    EXPECT_FALSE(found());
    write("parts/shot.hall.json", R"({"key": ")");
    EXPECT_FALSE(found());
    const std::string key = R"({"key": ")" + name(parts()).key + '"';
    for (const std::string rest :
         {"", R"(, "part": 1)", R"(, "part": {"shots": [1], "results": []})", R"(, "part": {"shots": []})",
          R"(, "part": {"shots": [], "results": [{"images": [[]]}]})"}) {
        write("parts/shot.hall.json", key + rest + "}");
        EXPECT_FALSE(found()) << rest;
    }
    write("parts/shot.hall.json", R"({"key": 3, "part": {}})");
    EXPECT_FALSE(found());
}

TEST(Plans, HaveAHistoryInTheGraphOrInTheHostButNotInAMemo) {
    Plan plan;
    plan.resources.resize(1);
    plan.slots.resize(1);
    plan.slots[0].name = "color";
    EXPECT_FALSE(has_history(plan));
    plan.resources[0].kept = plan.resources[0].memo = true;
    EXPECT_FALSE(has_history(plan));
    plan.resources[0].memo = false;
    EXPECT_TRUE(has_history(plan));
    plan.resources[0].kept = false;
    plan.resources[0].history = true;
    EXPECT_TRUE(has_history(plan));
    plan.resources[0].history = false;
    plan.slots[0].name = "color@-1";
    EXPECT_TRUE(has_history(plan));
}

}  // namespace
}  // namespace penumbra::report
