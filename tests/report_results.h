// SPDX-License-Identifier: MIT
// Results that nothing has measured, for tests of what is made of them: one shot, two pipelines, plain rays.
#pragma once

#include "app/report/results.h"

namespace penumbra::test {

inline MaskMetrics made_up_metrics(double n_eff) {
    MaskMetrics metrics;
    metrics.receivers = 1000;
    metrics.penumbra = 100;
    metrics.rmse_all = 0.1 / n_eff;
    metrics.rmse_penumbra = 0.3 / n_eff;
    metrics.n_eff = n_eff;
    metrics.n_eff_ci95 = {n_eff * 0.8, n_eff * 1.3};
    return metrics;
}

inline report::Results made_up_results() {
    using namespace report;
    Results results;
    results.command = "penumbra report --out \"<x>\"";
    results.study = quick_study();
    results.study.edge_speeds_px = {-1, 0, 1};
    results.device = {"a device", "a driver", true, 0, 8, ""};
    for (const char* id : {"raw", "smooth"})
        results.contenders.push_back({id, std::string("pipelines/") + id + ".json", "A <pipeline>."});
    results.contenders[0].plain = report::PlainRays{1, false};
    for (const uint32_t rays : {4u, 16u, 64u})
        results.contenders.push_back({"rays_" + std::to_string(rays),
                                      "",
                                      "Brute force.",
                                      PlainRays{rays, false},
                                      {"rays_per_pixel=" + std::to_string(rays)}});
    results.contenders.push_back(
        {"many_rays_16", "", "Behind proofs.", PlainRays{16, true}, {"rays_per_pixel=16"}});
    results.shots.push_back({"hall", "scenes/hall.shot.json", "shots/hall.still.shot.json"});
    results.shots[0].size = {16, 9};
    for (size_t c = 0; c < results.contenders.size(); ++c) {
        const double n_eff = 1 + 3 * static_cast<double>(c);
        Row row;
        row.contender = c;
        row.mask_cpu_ms = Estimate{10 * n_eff, 9 * n_eff, 12 * n_eff};
        row.frame_cpu_ms = Estimate{11 * n_eff, {}, {}};
        row.passes = {{{"trace", "trace", true}, {}, Estimate{9 * n_eff, {}, {}}},
                      {{"shade", "shade", false}, {}, Estimate{n_eff, {}, {}}}};
        row.moving = made_up_metrics(n_eff);
        for (const uint32_t after : results.study.after_cut)
            row.after_cut.push_back({after, made_up_metrics(n_eff)});
        for (const uint32_t frame : {7u, 15u}) row.over_time.push_back({frame, made_up_metrics(n_eff)});
        results.rows.push_back(std::move(row));
        for (const double speed : results.study.edge_speeds_px)
            results.edge.push_back(
                {16, speed, c, made_up_metrics(n_eff + (speed < 0 ? 0 : 1 - speed / 2)), {}});
    }
    results.shots[0].image_frame = 15;
    return results;
}

}  // namespace penumbra::test
