// SPDX-License-Identifier: MIT
// The report's page, from made-up results and real plans: it stands by itself, it shows every figure, and in
// a browser (headless Chromium, where there is one) it loads without an error and its slider works.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "app/report/dataflow_figure.h"
#include "app/report/images.h"
#include "app/report/memory_figure.h"
#include "app/report/page.h"
#include "app/session.h"
#include "host/images/image_file.h"
#include "penumbra/graph.h"
#include "penumbra/shadow_nodes.h"
#include "tests/report_results.h"

namespace penumbra::report {
namespace {

namespace fs = std::filesystem;

size_t count(const std::string& text, const std::string& part) {
    size_t found = 0;
    for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
    return found;
}

const NodeSet& nodes() {
    static const NodeSet set = shadow_nodes();
    return set;
}

Plan shipped_plan(const std::string& name) {
    Diagnostics diagnostics;
    const auto pipeline =
        load_pipeline(std::string(PENUMBRA_SOURCE_DIR "/pipelines/") + name + ".json", {}, diagnostics);
    const auto checked = pipeline ? check(*pipeline, nodes(), diagnostics) : std::nullopt;
    Target target;
    target.extent = {64, 48};
    target.device = reference_device();
    auto plan = checked ? compile(*checked, target, {}, diagnostics) : std::nullopt;
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
        EXPECT_EQ(count(figure, "class=\"life "), boxes) << name;
        EXPECT_EQ(count(figure, "class=\"bound\""), plan.heaps.size());
    }
}

class ReportPage : public ::testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("penumbra_page_" + std::to_string(getpid()));
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
    void TearDown() override { fs::remove_all(folder_); }

    std::string page() const { return report_page(results_, plans_, folder_); }

    fs::path folder_;
    Results results_;
    std::vector<PipelinePlan> plans_;
};

TEST_F(ReportPage, NeedsNoOtherFile) {
    const std::string text = page();
    for (const char* outside : {"src=\"http", "href=\"http", "<link", "@import", "url(", "src=\"images"})
        EXPECT_EQ(text.find(outside), std::string::npos) << outside;
    EXPECT_EQ(count(text, "src=\"data:image/png;base64,"), 1 + 2 * results_.rows.size());
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
    EXPECT_EQ(count(text, "class=\"front\""), 2u);
    EXPECT_NE(text.find("brute force&#39;s time"), std::string::npos);
}

TEST_F(ReportPage, ShowsWhatItIsGivenAsText) {
    const std::string text = page();
    EXPECT_NE(text.find("penumbra report --out &quot;&lt;x&gt;&quot;"), std::string::npos);
    EXPECT_NE(text.find("A &lt;pipeline&gt;."), std::string::npos);
    EXPECT_EQ(text.find("A <pipeline>."), std::string::npos);
}

TEST_F(ReportPage, AMissingImageIsAnErrorAndNoPage) {
    fs::remove(folder_ / results_.rows[1].images[0]);
    EXPECT_THROW(page(), FileError);
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
// the dump of the document shows.
constexpr const char* watch = R"(<script>
var errors = []; addEventListener("error", e => errors.push(e.message));
</script>)";
constexpr const char* work = R"(<script>
addEventListener("load", () => {
  const note = (name, value) => document.documentElement.setAttribute("data-" + name, value);
  const input = document.querySelector(".stage input"), stage = document.querySelector(".stage");
  const left = document.querySelector(".left-image"), right = document.querySelector(".right-image");
  note("before", getComputedStyle(left).clipPath);
  input.focus();
  note("focus", document.activeElement === input);
  input.value = 25;
  input.dispatchEvent(new Event("input"));
  note("split", stage.style.getPropertyValue("--split"));
  note("after", getComputedStyle(left).clipPath);
  note("differ", left.src !== right.src && left.naturalWidth === 16);
  const choice = document.querySelector(".left-choice");
  choice.selectedIndex = 0;
  choice.dispatchEvent(new Event("change"));
  note("chosen", left.alt);
  for (const name of ["pareto-rmse", "pareto-n-eff"])
    note(name, document.querySelectorAll("." + name + " circle").length);
  document.querySelector('.legend button[data-style="p1"]').click();
  note("hidden", [...document.querySelectorAll(".plots svg .p1")].every(e => getComputedStyle(e).display === "none"));
  note("wide", document.documentElement.scrollWidth <= innerWidth);
  note("errors", errors.length + " " + errors.join("; "));
});
</script>)";

TEST_F(ReportPage, WorksInABrowser) {
    const Finished which = run("command -v chromium || command -v chromium-browser || true");
    if (which.out.empty()) GTEST_SKIP() << "no chromium here; scripts/setup.sh --test installs it";
    const std::string chromium = which.out.substr(0, which.out.find('\n'));
    std::string text = page();
    const std::string plain = (folder_ / "plain.html").string(), worked = (folder_ / "worked.html").string();
    std::ofstream(plain) << text;
    text.insert(text.find("<style>"), watch);
    text.insert(text.find("</body>"), work);
    std::ofstream(worked) << text;
    // Of its own: the user's profile stays alone, and two runs at once do not meet. No sandbox: tests may be
    // root's.
    const std::string browser =
        chromium +
        " --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --window-size=1200,900 "
        "--enable-logging=stderr --virtual-time-budget=4000 --user-data-dir=" +
        (folder_ / "profile").string() + " --dump-dom file://";
    const Finished as_it_is = run("timeout 120 " + browser + plain + " 2>&1");
    ASSERT_EQ(as_it_is.status, 0) << as_it_is.out;
    EXPECT_EQ(as_it_is.out.find("CONSOLE"), std::string::npos) << as_it_is.out.substr(0, 4000);

    const Finished used = run("timeout 120 " + browser + worked + " 2>/dev/null");
    ASSERT_EQ(used.status, 0);
    const std::string root = used.out.substr(0, used.out.find("<head>"));
    const auto noted = [&](const std::string& what) {
        EXPECT_NE(root.find(what), std::string::npos) << what << " in " << root;
    };
    noted("data-errors=\"0 \"");
    noted("data-focus=\"true\"");
    noted("data-before=\"inset(0px 50% 0px 0px)\"");
    noted("data-split=\"25%\"");
    noted("data-after=\"inset(0px 75% 0px 0px)\"");
    noted("data-differ=\"true\"");
    noted("data-chosen=\"reference\"");
    noted("data-pareto-rmse=\"" + std::to_string(results_.rows.size()) + "\"");
    noted("data-pareto-n-eff=\"" + std::to_string(results_.rows.size()) + "\"");
    noted("data-hidden=\"true\"");
    noted("data-wide=\"true\"");
}

}  // namespace
}  // namespace penumbra::report
