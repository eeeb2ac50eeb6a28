// SPDX-License-Identifier: MIT
// The report's page, from made-up results and real plans: it stands by itself, it shows every figure, and in
// a browser (headless Chromium, where there is one) it loads without an error and its slider works.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "app/report/crops.h"
#include "app/report/dataflow_figure.h"
#include "app/report/html.h"
#include "app/report/images.h"
#include "app/report/memory_figure.h"
#include "app/report/motion_image.h"
#include "app/report/page.h"
#include "app/session.h"
#include "host/images/image_file.h"
#include "penumbra/graph.h"
#include "tests/report_results.h"
#include "tests/shipped.h"
#include "tests/substring.h"
#include "tests/test_folder.h"

namespace penumbra::report {
namespace {

using test::occurrences;

namespace fs = std::filesystem;

Plan shipped_plan(const std::string& name) {
    Diagnostics diagnostics;
    Target target;
    target.extent = {64, 48};
    target.device = reference_device();
    auto plan = compile(test::shipped_pipeline(name), target, {}, diagnostics);
    EXPECT_TRUE(plan) << diagnostics.text();
    return *plan;
}

TEST(ReportFigures, TheMapHasEveryPassValueAndReader) {
    for (const char* name : {"raw", "fidelityfx", "shadows"}) {
        const Plan plan = shipped_plan(name);
        const std::string map = dataflow_figure(plan, "p0");
        for (const PlanPass& pass : plan.passes) {
            EXPECT_NE(map.find(">" + pass.node + "</text>"), std::string::npos) << pass.node;
            for (const std::string& value : pass.writes)
                EXPECT_NE(map.find(">" + value + "</text>"), std::string::npos) << value;
            for (const std::string& value : pass.reads)
                EXPECT_NE(map.find("<title>" + value + " into " + pass.node + "</title>"), std::string::npos)
                    << value << " into " << pass.node;
        }
        for (const PlanOutput& output : plan.outputs)
            EXPECT_NE(map.find("<title>" + output.name + " into " + output.name + "</title>"),
                      std::string::npos);
    }
}

TEST(ReportFigures, MemoryHasABoxPerResourceAndFrameOrTwoWhereALifeWrapsAround) {
    for (const char* name : {"raw", "fidelityfx", "shadows"}) {
        const Plan plan = shipped_plan(name);
        size_t boxes = 0;
        for (const PlanResource& r : plan.resources)
            for (uint32_t parity = 0; parity < 2; ++parity)
                boxes +=
                    (r.first_pass + parity * plan.period() / 2) % plan.period() + r.length > plan.period()
                        ? 2
                        : 1;
        const std::string figure = memory_figure(plan, "p0");
        EXPECT_EQ(occurrences(figure, "class=\"life "), boxes) << name;
        EXPECT_EQ(occurrences(figure, "class=\"bound\""), plan.heaps.size());
    }
}

// The crop with most of the error, not the one with its peak.
TEST(ReportCrops, AreWhereTheErrorIsLargest) {
    constexpr std::array<uint32_t, 2> size{16, 8};
    std::vector<uint8_t> errors(16 * 8);
    EXPECT_EQ(worst_crop(size, errors), (std::array{0.5, 0.5}));
    errors[0] = 50;  // in the upper left corner
    for (const size_t texel : {12 + 16 * 5, 13 + 16 * 5, 12 + 16 * 6}) errors[texel] = 40;
    const auto [x, y] = worst_crop(size, errors);  // of 4x2 texels, the first that holds the three
    EXPECT_GE(x, 12.0 / 16);
    EXPECT_LE(x, 14.0 / 16);
    EXPECT_EQ(y, 6.0 / 8);
    EXPECT_EQ(crop_fragment("a/b", "rays 4, error", "x", {0.25, 1}),
              "crop/a%2Fb/rays%204%2C%20error/x/0.2500/1.0000/4");
}

TEST(ReportMotion, PanelsLieApartAndInOneRowWhereThereAreFew) {
    constexpr std::array<uint32_t, 2> panel{20, 10};
    for (size_t count = 1; count <= 17; ++count) {
        const MotionGrid grid(count);
        const auto [width, height] = grid.size(panel);
        EXPECT_EQ(grid.columns > 4, false);
        std::vector<uint8_t> taken(size_t{width} * height);
        for (size_t i = 0; i < count; ++i) {
            const auto [left, top] = grid.corner(i, panel);
            ASSERT_LE(left + panel[0], width);
            ASSERT_LE(top + panel[1], height);
            for (uint32_t y = 0; y < panel[1]; ++y)
                for (uint32_t x = 0; x < panel[0]; ++x)
                    EXPECT_EQ(taken[size_t{top + y} * width + left + x]++, 0);
        }
    }
    EXPECT_EQ(MotionGrid(3).rows, 1u);
}

class ReportPage : public ::testing::Test {
  protected:
    void SetUp() override {
        fs::create_directories(folder_ / "images");
        results_ = test::made_up_results();
        const std::vector<float> truth(16 * 9, 0.5f);
        const std::vector<uint8_t> counted(16 * 9, 1);
        results_.shots[0].reference_image = "images/reference.png";
        write_mask_image(folder_ / "images/reference.png", {16, 9}, truth);
        for (Row& row : results_.rows) {
            const std::vector<float> mask(16 * 9, 1.0f / static_cast<float>(1 + row.contender));
            const std::string base = "images/" + results_.contenders[row.contender].id;
            row.images = {base + ".mask.png", base + ".error.png"};
            write_mask_image(folder_ / row.images[0], {16, 9}, mask);
            write_error_image(folder_ / row.images[1], {16, 9}, mask, truth, counted);
        }
        plans_.push_back({0, shipped_plan("raw")});
        plans_.push_back({1, shipped_plan("shadows")});
    }

    std::string page() const { return report_page(results_, plans_, folder_); }

    // The part of the address that opens where this row's mask is farthest off.
    std::string crop_of(size_t row) const {
        const std::string text = page(), start = "#crop/hall/" + results_.contenders[row].id + "/reference/";
        const size_t at = text.find(start);
        return at == std::string::npos ? "" : text.substr(at + start.size(), 13);
    }

    // Two frames of two pipelines: the first gets darker, the second stays.
    void add_motion() {
        const std::vector<float> light(16 * 9, 0.9f), dark(16 * 9, 0.1f);
        results_.shots[0].motion_image = "images/hall.motion.webp";
        write_motion_image(folder_ / results_.shots[0].motion_image, {16, 9},
                           {{light, dark}, {light, light}});
    }

    test::TestFolder folder_;
    Results results_;
    std::vector<PipelinePlan> plans_;
};

TEST_F(ReportPage, NeedsNoOtherFile) {
    const std::string text = page();
    for (const char* outside : {"src=\"http", "href=\"http", "<link", "@import", "url(", "src=\"images"})
        EXPECT_EQ(text.find(outside), std::string::npos) << outside;
    EXPECT_EQ(occurrences(text, "src=\"data:image/png;base64,"), 1 + 2 * results_.rows.size());
    EXPECT_EQ(text.find("In motion"), std::string::npos);
    add_motion();
    EXPECT_EQ(occurrences(page(), "src=\"data:image/webp;base64,"), 1u);
    EXPECT_EQ(text.find("{{"), std::string::npos);
}

TEST_F(ReportPage, HasNoSectionOfWhatWasNotMeasured) {
    results_.study = front_study();
    results_.edge.clear();
    for (Row& row : results_.rows) row.after_cut.clear();
    const std::string text = page();
    for (const char* gone : {"id=\"headline\"", "#headline", "id=\"edge\"", "#edge", "class=\"after-cut\"",
                             "class=\"over-time\"", "{{"})
        EXPECT_EQ(text.find(gone), std::string::npos) << gone;
    EXPECT_EQ(occurrences(text, "class=\"front\""), 2u);
    EXPECT_NE(text.find("brute force&#39;s time"), std::string::npos);
}

// Of a lamp no edges are measured, and all else is.
TEST_F(ReportPage, OfALampSaysSo) {
    results_.quick = false;
    results_.study.light = "<spot>";
    results_.study.edge_widths_px.clear();
    results_.edge.clear();
    const std::string text = page();
    for (const char* said : {"soft shadows of the light \"&lt;spot&gt;\"", "id=\"headline\"",
                             "the pipeline light_raw with N rays", "<dd>full</dd>"})
        EXPECT_NE(text.find(said), std::string::npos) << said;
    for (const char* gone :
         {"soft sun shadows", "over the sun", "worst edge", "straight edge", "many_rays N"})
        EXPECT_EQ(text.find(gone), std::string::npos) << gone;
}

TEST_F(ReportPage, ShowsWhatItIsGivenAsText) {
    const std::string text = page();
    EXPECT_NE(text.find("penumbra report --out &quot;&lt;x&gt;&quot;"), std::string::npos);
    EXPECT_NE(text.find("A &lt;pipeline&gt;."), std::string::npos);
    EXPECT_EQ(text.find("A <pipeline>."), std::string::npos);
    results_.shots[0].file = "my scenes/it's.shot.json";
    EXPECT_NE(page().find("--shot " + escape(R"('my scenes/it'\''s.shot.json')")), std::string::npos);
}

// What does not count is no error, however far off the mask is there.
TEST_F(ReportPage, LinksOpenAtTheLargestErrorOfReceivers) {
    std::vector<float> truth(16 * 9, 0.5f), mask = truth;
    std::vector<uint8_t> counted(16 * 9, 1);
    for (size_t y = 0; y < 9; ++y)
        for (size_t x = 0; x < 4; ++x) {
            mask[16 * y + x] = 1;
            counted[16 * y + x] = 0;
        }
    mask[16 * 4 + 15] = 0.3f;
    write_error_image(folder_ / results_.rows[1].images[1], {16, 9}, mask, truth, counted);
    EXPECT_EQ(crop_of(1).substr(0, 6), "0.8750");
}

TEST_F(ReportPage, AMissingImageIsAnErrorAndNoPage) {
    add_motion();
    const std::string whole = page();
    for (const std::string& image :
         {results_.rows[1].images[0], results_.rows[1].images[1], results_.shots[0].motion_image}) {
        fs::rename(folder_ / image, folder_ / "aside");
        EXPECT_THROW(page(), FileError) << image;
        std::ofstream(folder_ / image) << "no picture";
        if (image.ends_with(".error.png")) {
            EXPECT_THROW(page(), FileError) << image;
        }
        fs::rename(folder_ / "aside", folder_ / image);
    }
    EXPECT_EQ(page(), whole);
}

struct Finished {
    int status = -1;
    std::string out;
};

Finished run(const std::string& command) {
    Finished finished;
    FILE* pipe = popen(command.c_str(), "r");
    if (!pipe) return finished;
    char buffer[4096];
    for (size_t read; (read = fread(buffer, 1, sizeof buffer, pipe)) > 0;) finished.out.append(buffer, read);
    finished.status = pclose(pipe);
    return finished;
}

// Works the page as a person would and writes down what came of it, as attributes of the root element, which
// the dump of the document shows. The page lies in a frame of 400 pixels, narrower than a browser's window
// can be, and says what it has noted to the document around it, whose load ends with that: the second frame
// is a document that is still being written until then. No time is waited for, so a slow machine is only
// slow.
constexpr const char* watch = R"(<script>
var errors = []; addEventListener("error", e => errors.push(e.message));
</script>)";
constexpr const char* work = R"(<script>
addEventListener("load", async () => {
  const noted = {}, note = (name, value) => noted[name] = value;
  const style = (element) => getComputedStyle(element);
  const input = document.querySelector(".stage input"), stage = document.querySelector(".stage");
  const left = document.querySelector(".left-image"), right = document.querySelector(".right-image");
  const side = document.querySelector(".left-side");
  note("before", style(side).clipPath);
  input.focus();
  note("focus", document.activeElement === input);
  input.value = 25;
  input.dispatchEvent(new Event("input"));
  note("split", stage.style.getPropertyValue("--split"));
  note("after", style(side).clipPath);
  note("differ", left.src !== right.src && left.naturalWidth === 16);
  const choice = document.querySelector(".left-choice");
  choice.selectedIndex = 0;
  choice.dispatchEvent(new Event("change"));
  note("chosen", left.alt);
  for (const name of ["pareto-rmse", "pareto-n-eff"])
    note(name, document.querySelectorAll("." + name + " circle").length);
  document.querySelector('.legend button[data-style="p1"]').click();
  note("hidden", [...document.querySelectorAll(".plots svg .p1")].every(e => style(e).display === "none"));
  const follow = async (address) => {
    const followed = new Promise(done => addEventListener("hashchange", done, {once: true}));
    location.hash = address;
    await followed;  // the page's own listener was there first
  };
  await follow("crop/hall/smooth/reference/0.9000/0.5000/4");
  note("crop", [left.alt, right.alt, style(left).scale, style(left).transformOrigin].join(" "));
  // The middle of what is seen is as near to nine tenths as the border lets it: seven eighths.
  const box = left.getBoundingClientRect(), frame = stage.getBoundingClientRect();
  note("middle", ((frame.left + frame.width / 2 - box.left) / box.width).toFixed(3));
  note("link", document.querySelector(".crop-link").getAttribute("href"));
  for (const wrong of ["crop/hall/nobody/reference/0.9/0.5/4", "crop/hall/smooth/reference/9/0.5/4", "crop/%", "crop/nowhere"])
    await follow(wrong);
  note("kept", style(left).scale);
  input.dispatchEvent(new MouseEvent("dblclick", {clientX: frame.left + 1, clientY: frame.top + 1}));
  note("closer", style(left).scale);
  const motion = document.querySelector(".motion img");
  await motion.decode();
  note("motion", motion.naturalWidth + "x" + motion.naturalHeight);
  note("names", [...document.querySelectorAll(".panels span")].map(e => e.textContent).join(" "));
  note("width", innerWidth);
  const wide = [...document.querySelectorAll("body *")].filter(e => e.getBoundingClientRect().right > innerWidth + 0.5 &&
    !e.closest(".table, .scroll, pre, .side, svg"));
  note("wide", document.documentElement.scrollWidth <= innerWidth ? wide.map(e => e.tagName + "." + e.className).join(" ") : "scrolls");
  // The least contrast of words on their ground, by WCAG's measure.
  const light = (color) => color.match(/[\d.]+/g).slice(0, 3).map(c => c / 255)
    .map(c => c <= .04045 ? c / 12.92 : ((c + .055) / 1.055) ** 2.4).reduce((sum, c, i) => sum + c * [.2126, .7152, .0722][i], 0);
  const ground = light(style(document.body).backgroundColor);
  const contrast = (e) => {
    const a = light(style(e).color);
    return (Math.max(a, ground) + .05) / (Math.min(a, ground) + .05);
  };
  note("dark", ground < .2);
  note("readable", Math.min(...[...document.querySelectorAll("h1, p, a, td, figcaption, dt")].map(contrast)) >= 4.5);
  note("errors", errors.length + " " + errors.join("; "));
  parent.postMessage(noted, "*");
});
</script>)";
constexpr const char* around =
    R"(<!DOCTYPE html><html><body><iframe src="worked.html" width="WIDTH" height="800" style="border:0"></iframe>
<iframe hidden></iframe><script>
const open = document.querySelector("[hidden]").contentDocument;
open.open();
addEventListener("message", e => {
  for (const [name, value] of Object.entries(e.data)) document.documentElement.setAttribute("data-" + name, value);
  open.close();
});</script></body></html>)";

TEST_F(ReportPage, WorksInABrowser) {
    const Finished which = run("command -v chromium || command -v chromium-browser || true");
    if (which.out.empty()) GTEST_SKIP() << "no chromium here; scripts/setup.sh --test installs it";
    const std::string chromium = which.out.substr(0, which.out.find('\n'));
    add_motion();
    std::string text = page();
    std::ofstream(folder_ / "plain.html") << text;
    text.insert(text.find("<style>"), watch);
    text.insert(text.find("</body>"), work);
    std::ofstream(folder_ / "worked.html") << text;
    // Of its own: the user's profile stays alone, and two runs at once do not meet. No sandbox: tests may be
    // root's.
    const auto open = [&](const char* file, const std::string& options) {
        return run("timeout 120 " + chromium +
                   " --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --window-size=1200,900 "
                   "--enable-logging=stderr " +
                   options + " --user-data-dir=" + (folder_ / "profile").string() + " --dump-dom file://" +
                   (folder_ / file).string() + " 2>&1");
    };
    const Finished as_it_is = open("plain.html", "");
    ASSERT_EQ(as_it_is.status, 0) << as_it_is.out;
    EXPECT_EQ(as_it_is.out.find("CONSOLE"), std::string::npos) << as_it_is.out.substr(0, 4000);

    for (const auto& [width, dark] : {std::pair(1100, false), std::pair(400, true), std::pair(400, false)}) {
        SCOPED_TRACE(width);
        std::string frame = around;
        frame.replace(frame.find("WIDTH"), 5, std::to_string(width));
        std::ofstream(folder_ / "frame.html") << frame;
        const Finished used = open("frame.html", dark ? "--force-dark-mode" : "");
        ASSERT_EQ(used.status, 0) << used.out.substr(0, 4000);
        const size_t begin = used.out.find("<html");
        const std::string root = used.out.substr(begin, used.out.find("<head>") - begin);
        const auto noted = [&](const std::string& name, const std::string& value) {
            const std::string what = "data-" + name + "=\"" + value + "\"";
            EXPECT_NE(root.find(what), std::string::npos) << what << " in " << root;
        };
        const std::string rows = std::to_string(results_.rows.size());
        noted("errors", "0 ");
        noted("focus", "true");
        noted("before", "inset(0px 50% 0px 0px)");
        noted("split", "25%");
        noted("after", "inset(0px 75% 0px 0px)");
        noted("differ", "true");
        noted("chosen", "reference");
        noted("pareto-rmse", rows);
        noted("pareto-n-eff", rows);
        noted("hidden", "true");
        noted("middle", "0.875");
        noted("link", "#crop/hall/smooth/reference/0.9000/0.5000/4");
        noted("kept", "4");
        noted("closer", "8");
        noted("motion", "34x9");  // two panels and the gap between
        noted("names", "raw smooth");
        noted("width", std::to_string(width));
        noted("wide", "");
        noted("dark", dark ? "true" : "false");
        noted("readable", "true");
        EXPECT_NE(root.find("data-crop=\"smooth reference 4 "), std::string::npos) << root;
    }
}

}  // namespace
}  // namespace penumbra::report
