// SPDX-License-Identifier: MIT
// What `penumbra report --signal` measures, on small images: brute force does what brute force must, figures
// are those of the truth and of the passes that the signal needs.
#include <nlohmann/json.hpp>

#include "app/report/radiance_page.h"
#include "penumbra/shadow_nodes.h"
#include "tests/gpu_test.h"
#include "tests/test_folder.h"

namespace penumbra::report {
namespace {

namespace fs = std::filesystem;

class RadianceReport : public test::GpuTest {
  protected:
    RadianceReport() {
        fs::create_directories(folder_ / "images");
        fs::create_directories(folder_ / "shots");
        results_.signal = "specular";
        results_.device = test::gpu().info().name;
        results_.cpu = test::gpu().info().is_cpu;
        RadianceStudy& study = results_.study;
        study.size = {64, 36};
        study.seeds = 1;
        study.rays = 128;
        study.after = {1, 3};
        study.moving_frame = 3;
        study.timed_from = 2;
        study.brute_force = {1, 16};
    }

    test::TestFolder folder_;
    NodeSet nodes_ = shadow_nodes();
    Diagnostics diagnostics_;
    std::vector<std::string> warnings_;
    RadianceResults results_;
};

TEST_F(RadianceReport, BruteForceGainsWithEveryRayAndCostsMore) {
    auto contenders = radiance_contenders({"reflections"}, "specular", results_.study, PENUMBRA_SOURCE_DIR,
                                          nodes_, diagnostics_);
    ASSERT_TRUE(contenders) << diagnostics_.text();
    results_.contenders = std::move(*contenders);
    const auto shot = open_report_shot(PENUMBRA_SOURCE_DIR "/scenes/radiance/chrome.shot.json",
                                       folder_ / "shots", 3, diagnostics_);
    ASSERT_TRUE(shot) << diagnostics_.text();
    uint32_t steps = 0;
    ASSERT_TRUE(measure_radiance({test::gpu(), nodes_, folder_, [&] { ++steps; }}, *shot, results_,
                                 diagnostics_, warnings_))
        << diagnostics_.text();
    EXPECT_EQ(steps, work_of(results_));
    ASSERT_EQ(results_.rows.size(), 3u);
    const RadianceRow* before = nullptr;
    for (const RadianceRow& row : results_.rows) {
        EXPECT_GT(row.cost_ms.value_or(0), 0);
        EXPECT_TRUE(row.still.back().flicker());
        EXPECT_EQ(row.moving.nonfinite, 0u);
        if (!results_.contenders[row.contender].rays) continue;
        EXPECT_NEAR(over_brute_force(results_, row).value_or(Front::Reading{}).value, 1, 1e-6);
        if (before) {
            EXPECT_GT(*row.moving.n_eff(), 4 * *before->moving.n_eff());
            EXPECT_LT(row.flip.mean, before->flip.mean);
            EXPECT_LT(row.lit_relmse, before->lit_relmse);
            EXPECT_GT(*row.cost_ms, *before->cost_ms);
        }
        before = &row;
    }
    EXPECT_GT(*results_.rows[0].moving.n_eff(), *results_.rows[1].moving.n_eff()) << "denoised";
    const auto json = to_json(results_);
    EXPECT_EQ(json["results"].size(), 3u);
    EXPECT_EQ(json["results"][0]["moving"]["n_eff"]["value"].get<double>(), *results_.rows[0].moving.n_eff());
    const std::string page = radiance_page(results_, folder_), tables = markdown_tables(results_);
    for (const RadianceContender& c : results_.contenders) {
        EXPECT_NE(page.find(c.id), std::string::npos);
        EXPECT_NE(tables.find("| " + c.id + " |"), std::string::npos);
    }
    results_.rows[0].moving.nonfinite = 987;
    EXPECT_NE(radiance_page(results_, folder_).find(">987<"), std::string::npos);
    EXPECT_NE(markdown_tables(results_).find("| not finite |"), std::string::npos);
}

TEST_F(RadianceReport, WhatDoesNotMakeTheSignalIsAnError) {
    for (const char* name : {"shadows", "denoise_radiance"}) {
        Diagnostics diagnostics;
        EXPECT_FALSE(
            radiance_contenders({name}, "specular", results_.study, PENUMBRA_SOURCE_DIR, nodes_, diagnostics))
            << name;
        EXPECT_FALSE(diagnostics.empty());
    }
}

}  // namespace
}  // namespace penumbra::report
