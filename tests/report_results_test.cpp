// SPDX-License-Identifier: MIT
// What `penumbra report` makes of its results: rows of tables and files, costs, the front of speed against
// error.
#include "tests/report_results.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/report/front_figures.h"
#include "app/report/markdown_tables.h"
#include "app/report/plots.h"
#include "app/report/turns.h"
#include "tests/substring.h"

namespace penumbra::report {
namespace {

using test::occurrences;

TEST(ReportResults, EveryRowIsAPointWithItsNumbers) {
    const Results results = test::made_up_results();
    for (const Quality quality : {Quality::rmse, Quality::n_eff}) {
        const std::string plot = pareto_plot(results, 0, quality);
        EXPECT_EQ(occurrences(plot, "<circle"), results.contenders.size());
        for (const Contender& contender : results.contenders)
            EXPECT_NE(plot.find(label(contender) + ":"), std::string::npos) << contender.id;
    }
    EXPECT_EQ(occurrences(after_cut_plot(results, 0), "<circle"),
              results.contenders.size() * results.study.after_cut.size());
    // A row that could not be timed is no point at a made-up place.
    Results untimed = results;
    untimed.rows[0].mask_cpu_ms.reset();
    EXPECT_EQ(occurrences(pareto_plot(untimed, 0, Quality::rmse), "<circle"), results.contenders.size() - 1);
}

TEST(ReportResults, JsonAndCsvHoldTheSameRowsAndNullForTheUnknown) {
    Results results = test::made_up_results();
    results.contenders[0].id = "a,\"b\"";
    const auto json = to_json(results);
    ASSERT_EQ(json["results"].size(), results.rows.size());
    EXPECT_EQ(json["results"][0]["contender"], "a,\"b\"");
    EXPECT_EQ(json["results"][0]["moving"]["rmse"]["all"], *results.rows[0].moving.rmse_all);
    EXPECT_TRUE(json["results"][0]["mask_ms"]["median"].is_null());
    EXPECT_TRUE(json["results"][0].contains("ssim") && json["results"][0]["ssim"].is_null());
    const std::string csv = to_csv(results);
    EXPECT_EQ(occurrences(csv, "\r\n"), results.rows.size() + 1);
    EXPECT_NE(csv.find("\"a,\"\"b\"\"\""), std::string::npos);
    const size_t columns = occurrences(csv.substr(0, csv.find("\r\n")), ",");
    const size_t second = csv.find("\r\n", csv.find("\r\n") + 2) + 2;  // a row without quoted commas
    EXPECT_EQ(occurrences(csv.substr(second, csv.find("\r\n", second) - second), ","), columns);
}

TEST(ReportResults, AreTheSameAfterBeingWrittenAndRead) {
    Results results = test::made_up_results();
    results.shots.push_back(results.shots.front());
    results.shots[1].name = "yard";
    results.rows.push_back(results.rows.front());
    results.rows.back().shot = 1;
    results.rows.back().same_as = 1;
    results.rows.back().images = {"a.png", "b.png"};
    results.rows.back().flip = FlipPool{.1, .2, .3};
    results.rows.back().maps_cpu_ms = Estimate{4, {}, {}};
    Results read;
    read.command = results.command;
    read.study = results.study;
    read.device = results.device;
    read.contenders = results.contenders;
    append(to_json(results), read);
    EXPECT_EQ(to_json(read), to_json(results));
    EXPECT_EQ(to_csv(read), to_csv(results));
    // A second part goes behind the first.
    append(to_json(results), read);
    ASSERT_EQ(read.shots.size(), 4u);
    EXPECT_EQ(read.rows.back().shot, 3u);
    // What it does not know adds nothing.
    auto foreign = to_json(results);
    foreign["edge"].back()["contender"] = "nobody";
    EXPECT_THROW(append(foreign, read), nlohmann::json::exception);
    EXPECT_EQ(read.shots.size(), 4u);
}

TEST(ReportResults, TheSameMasksShareARowOfTheTables) {
    Results results = test::made_up_results();
    EXPECT_EQ(results.original(1), 1u);
    results.rows[1].same_as = 0;
    EXPECT_EQ(results.original(1), 0u);
    const std::string tables = markdown_tables(results);
    EXPECT_EQ(occurrences(tables, "| raw, smooth |"), 2u);  // after a cut, and the edge
    EXPECT_EQ(occurrences(tables, "\n| smooth |"),
              2u);  // its cost is its own, and so is its place on the front
    EXPECT_EQ(occurrences(after_cut_plot(results, 0), "<circle"),
              (results.contenders.size() - 1) * results.study.after_cut.size());
    EXPECT_EQ(occurrences(pareto_plot(results, 0, Quality::n_eff), "<circle"), results.contenders.size());
    // Another shot says otherwise.
    results.shots.push_back(results.shots.front());
    results.rows.push_back(results.rows[1]);
    results.rows.back().shot = 1;
    results.rows.back().same_as.reset();
    EXPECT_EQ(results.original(1), 1u);
    for (const char* name : {"4 rays", "16 rays", "64 rays"})
        EXPECT_EQ(occurrences(markdown_tables(results), std::string("\n| ") + name + " |"), 4u) << name;
}

TEST(ReportCosts, CountEachPassAtItsLeastAndOnlyThoseOfTheMask) {
    Costs costs;
    costs.passes = {{"trace", "trace", true}, {"soften", "soften", true}, {"shade", "shade", false}};
    const auto sample = [](double trace, double soften, double shade) {
        Sample out;
        for (const double ms : {trace, soften, shade}) out.passes.push_back({std::nullopt, ms});
        return out;
    };
    costs.add(7, sample(5, 2, 100));
    costs.add(7, sample(3, 4, 90));
    costs.add(7, sample(9, 9, 900));
    EXPECT_EQ(costs.sum(&PassCost::cpu_ms, true)->median, 5);  // no round was as good in both
    EXPECT_EQ(costs.sum(&PassCost::cpu_ms, false)->median, 95);
    EXPECT_FALSE(costs.sum(&PassCost::ms, true));
    costs.add(15, sample(10, 10, 0));
    costs.add(11, sample(1, 1, 0));
    EXPECT_EQ(costs.sum(&PassCost::cpu_ms, true)->median, 5);  // over frames: the median
    EXPECT_EQ(costs.pass(0, &PassCost::cpu_ms)->median, 3);
}

// The made-up rows all lie on N_eff = cost / 10; then one of them does not.
TEST(ReportFront, FactorsAreOverPlainRaysAtTheSameTimeAndError) {
    Results results = test::made_up_results();
    for (const Row& row : results.rows) {
        const FrontFigure figure = front_figure(results, row);
        ASSERT_TRUE(figure.over_plain && figure.brute_force_time);
        EXPECT_NEAR(figure.over_plain->value, 1, 1e-12);
        EXPECT_NEAR(figure.brute_force_time->value, 1, 1e-12);
        EXPECT_FALSE(figure.over_plain->extrapolated);
        EXPECT_TRUE(figure.on_front);
        // Brute force ends at 64 rays, many_rays of made-up cost beyond it.
        EXPECT_EQ(figure.brute_force_time->extrapolated,
                  results.contenders[row.contender].id == "many_rays_16");
    }
    Row& smooth = results.rows[1];
    smooth.mask_cpu_ms = Estimate{20, {}, {}};
    smooth.moving.n_eff = 200;
    FrontFigure figure = front_figure(results, smooth);
    EXPECT_NEAR(figure.over_plain->value, 100, 1e-9);        // plain rays of 20 ms are worth 2
    EXPECT_NEAR(figure.brute_force_time->value, 100, 1e-9);  // it would take 2000 ms
    EXPECT_FALSE(figure.over_plain->extrapolated);
    EXPECT_TRUE(figure.brute_force_time->extrapolated);
    EXPECT_TRUE(figure.on_front);
    EXPECT_TRUE(front_figure(results, results.rows[0]).on_front);   // worse, but faster
    EXPECT_FALSE(front_figure(results, results.rows[2]).on_front);  // slower and worse

    // Rays behind proofs are plain rays, and no brute force.
    results.rows.back().mask_cpu_ms = Estimate{5, {}, {}};
    figure = front_figure(results, smooth);
    EXPECT_FALSE(figure.over_plain);  // 16 in 5 ms beat all others: a point alone
    EXPECT_NEAR(figure.brute_force_time->value, 100, 1e-9);
    EXPECT_NEAR(front_figure(results, results.rows.back()).brute_force_time->value, 32, 1e-9);

    // No error that could be seen; no penumbra at all; no time.
    smooth.moving.n_eff.reset();
    figure = front_figure(results, smooth);
    EXPECT_TRUE(figure.exact && figure.on_front);
    EXPECT_EQ(over_plain_text(figure), "exact");
    EXPECT_TRUE(to_json(results)["results"][1]["front"]["n_eff_over_plain"]["value"].is_null());
    smooth.moving.penumbra = 0;
    EXPECT_FALSE(front_point(results, smooth));
    smooth = test::made_up_results().rows[1];
    smooth.mask_cpu_ms.reset();
    EXPECT_FALSE(front_point(results, smooth));
    EXPECT_FALSE(front_figure(results, smooth).on_front);
    EXPECT_EQ(over_plain_text(front_figure(results, smooth)), "–");
}

TEST(ReportFront, IsDrawnThroughThoseThatNobodyBeats) {
    Results results = test::made_up_results();
    results.rows[1].mask_cpu_ms = Estimate{5, {}, {}};
    results.rows[1].moving.n_eff = 10000;  // and its error is the least
    results.rows[1].moving.rmse_all = 1e-5;
    results.rows[0].mask_cpu_ms = Estimate{1, {}, {}};
    for (const Quality quality : {Quality::rmse, Quality::n_eff}) {
        const std::string plot = pareto_plot(results, 0, quality);
        const size_t end = plot.find("\" class=\"front\"");
        ASSERT_NE(end, std::string::npos);
        const size_t start = plot.rfind("points=\"", end);
        EXPECT_EQ(occurrences(plot.substr(start, end - start), ","),
                  2u);  // raw, and the one that beats all others
        EXPECT_EQ(occurrences(plot, "class=\"line pb\""), 1u);
        EXPECT_EQ(occurrences(plot, "class=\"line pm\""), 0u);  // of one number of rays alone
    }
    // A table has its factor, in bold.
    EXPECT_NE(markdown_tables(results).find("| **5.00 / 10000 / "), std::string::npos)
        << markdown_tables(results);
}

TEST(ReportFront, IsAllThatAPageOfItShows) {
    Results results = test::made_up_results();
    results.study = front_study();
    results.edge.clear();
    for (Row& row : results.rows) row.after_cut.clear();
    const std::string tables = markdown_tables(results);
    EXPECT_NE(tables.find("brute force's time"), std::string::npos);
    EXPECT_NE(tables.find("1 seed, "), std::string::npos);
    EXPECT_NE(tables.find("as it moves, frame 15: "), std::string::npos);
    EXPECT_EQ(tables.find("standing still"), std::string::npos);
    EXPECT_EQ(tables.find("straight edge"), std::string::npos);
}

TEST(ReportResults, TheWorstEdgeIsAMovingOne) {
    Results results = test::made_up_results();
    const EdgePoint* worst = results.worst_edge(0, 16);
    ASSERT_TRUE(worst);
    EXPECT_EQ(worst->speed_px, -1);
    EXPECT_FALSE(results.worst_edge(0, 5));
}

}  // namespace
}  // namespace penumbra::report
