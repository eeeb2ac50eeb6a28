// SPDX-License-Identifier: MIT
#include "app/gates/gates.h"

#include <algorithm>
#include <cmath>

#include "app/outputs.h"
#include "app/truth.h"
#include "host/metrics/lag.h"
#include "host/metrics/mask_error.h"
#include "host/truth/analytic.h"

namespace penumbra::gates {
namespace {

const glm::dvec3 to_sun(0.3, 0.2, 1);

Shot edge_shot(const Study& study, double width_px, uint32_t frames) {
    Shot shot;
    shot.name = "edge";
    shot.analytic = AnalyticScene{width_px, study.edge_deg, 0, 0, HalfPlane{}};
    shot.size = study.size;
    shot.frames = frames;
    shot.sun = {{0, to_sun}};
    return shot;
}

// A frame's truth and the pixels that count.
struct Judge {
    std::array<uint32_t, 2> size;
    std::vector<float> truth;
    std::vector<uint8_t> counted;

    Judge(const Study& study, const Shot& shot, uint32_t frame) : size(shot.size) {
        const Truth exact = analytic_truth(shot, frame);
        truth = exact.visibility;
        for (uint32_t y = 0; y < size[1]; ++y)
            for (uint32_t x = 0; x < size[0]; ++x) {
                const uint32_t border = std::min(std::min(x, y), std::min(size[0] - 1 - x, size[1] - 1 - y));
                counted.push_back(exact.receiver[counted.size()] > 0.5f && border >= study.border_px);
            }
    }
    ComparedFrame compare(std::span<const float> image) const {
        return {size[0], size[1], truth, counted, {image}};
    }
    double n_eff(std::span<const float> image) const {
        return metrics_of(measure(compare(image))).n_eff.value_or(0);
    }
};

// Frames from `from` on are shown to `look`, for one seed after the other.
using Look = std::function<void(uint32_t frame, std::span<const float> image)>;

bool run(const Bench& bench, const Shot& shot, uint32_t seeds, uint32_t from, const Look& look,
         const Facts& facts = {}) {
    if (const auto problem = analytic_problem(shot, shot.frames - 1)) {
        bench.diagnostics.add({}, problem->key, problem->text);
        return false;
    }
    SessionOptions options;
    options.size = shot.size;
    options.captures = {"visibility"};
    options.jitter = false;  // the truth is that of pixel centres
    options.facts = facts;
    const auto session = Session::open(bench.device, bench.nodes, bench.pipeline, shot, options,
                                       bench.diagnostics, bench.warnings);
    if (!session) return false;
    for (uint32_t seed = 1; seed <= seeds; ++seed) {
        session->set_param("seed", seed);
        for (uint32_t frame = 0; frame < shot.frames; ++frame) {
            session->run_frame(frame, frame == 0);
            if (frame >= from) look(frame, captured_image(*session, "visibility").planes.front().values);
        }
        bench.step();
    }
    return true;
}

Shot jump_shot(const Study& study, double width_px, double distance_px) {
    Shot shot = edge_shot(study, width_px, study.jump_frame + study.frames_after_jump);
    shot.analytic->offset_px = -0.5 * distance_px;
    // The shadow of what hangs at a height h moves by -h times what the sun's direction, 1 upwards, moves.
    const AnalyticGeometry geometry = analytic_geometry(shot, 0);
    const glm::dvec3 jumped =
        to_sun - glm::dvec3(distance_px * analytic_pixel_m / geometry.height * geometry.normal, 0);
    shot.sun = {{0, to_sun}, {double(study.jump_frame - 1), to_sun}, {double(study.jump_frame), jumped}};
    return shot;
}

std::optional<StepFinder::Step> step_of(const Study& study, const Judge& before, const Judge& after) {
    StepFinder finder;
    finder.add(study.jump_frame - 1, before.truth, before.counted);
    finder.add(study.jump_frame, after.truth, after.counted);
    return finder.step();
}

Estimate estimate(std::vector<double> samples) {
    return report::median_of(std::move(samples)).value();
}

// Sums of squares of what has changed, in the penumbra and everywhere.
struct Changes {
    std::vector<float> before;
    double penumbra = 0, all = 0;
    size_t soft = 0, counted = 0;

    void add(const Judge& judge, std::span<const float> image) {
        for (size_t p = 0; p < before.size(); ++p) {
            if (!judge.counted[p]) continue;
            const auto d = static_cast<double>(image[p] - before[p]);
            const double square = std::isfinite(d) ? d * d : 1;
            all += square;
            ++counted;
            if (!in_penumbra(judge.truth[p])) continue;
            penumbra += square;
            ++soft;
        }
        before.assign(image.begin(), image.end());
    }
};

}  // namespace

bool has_penumbra(const Study& study, double width_px) {
    const Judge judge(study, edge_shot(study, width_px, 1), 0);
    for (size_t p = 0; p < judge.truth.size(); ++p)
        if (judge.counted[p] && in_penumbra(judge.truth[p])) return true;
    return false;
}

bool has_jump(const Study& study, double width_px) {
    return std::ranges::all_of(std::array{-study.jump_px, study.jump_px}, [&](double distance_px) {
        const Shot shot = jump_shot(study, width_px, distance_px);
        return step_of(study, {study, shot, study.jump_frame - 1}, {study, shot, study.jump_frame})
            .has_value();
    });
}

std::optional<Still> measure_still(const Bench& bench, double width_px) {
    const Study& study = bench.study;
    const Shot shot = edge_shot(study, width_px, study.still_frames);
    const Judge judge(study, shot, 0);
    std::vector<double> first, last, flicker, flicker_all;
    Changes changes;
    const auto look = [&](uint32_t frame, std::span<const float> image) {
        if (frame == 0) first.push_back(judge.n_eff(image));
        if (frame + 1 >= study.flicker_from) changes.add(judge, image);
        if (frame + 1 < shot.frames) return;
        last.push_back(judge.n_eff(image));
        flicker.push_back(255 * std::sqrt(changes.penumbra / static_cast<double>(changes.soft)));
        flicker_all.push_back(255 * std::sqrt(changes.all / static_cast<double>(changes.counted)));
        changes = {};
    };
    if (!run(bench, shot, study.seeds, 0, look)) return std::nullopt;
    return Still{estimate(first), estimate(last), estimate(flicker), estimate(flicker_all)};
}

std::optional<std::vector<Moving>> measure_moving(const Bench& bench, double width_px) {
    const Study& study = bench.study;
    std::vector<Moving> out;
    for (const double speed : study.speeds_px) {
        Shot shot = edge_shot(study, width_px, study.moving_frame + 1);
        shot.analytic->speed_px = speed;
        shot.analytic->offset_px = -speed * study.moving_frame;  // in the middle when it is judged
        add_analytic_motion(shot);
        const Judge judge(study, shot, study.moving_frame);
        std::vector<double> n_eff;
        const auto look = [&](uint32_t, std::span<const float> image) {
            n_eff.push_back(judge.n_eff(image));
        };
        if (!run(bench, shot, study.seeds, study.moving_frame, look)) return std::nullopt;
        out.push_back({speed, estimate(n_eff)});
    }
    return out;
}

std::optional<Jump> measure_jump(const Bench& bench, double width_px, double distance_px, bool told) {
    const Study& study = bench.study;
    const Shot shot = jump_shot(study, width_px, distance_px);
    const Judge before(study, shot, study.jump_frame - 1), judge(study, shot, study.jump_frame);
    const auto step = step_of(study, before, judge);
    if (!step) {
        bench.diagnostics.add({}, "jump", "no pixel changes by more than a half");
        return std::nullopt;
    }
    std::vector<std::vector<double>> left(study.frames_after_jump);
    std::vector<double> k90, n_eff, remainders;
    const auto look = [&](uint32_t frame, std::span<const float> image) {
        remainders.push_back(step_remainder(*step, judge.compare(image)));
        left[frame - study.jump_frame].push_back(remainders.back());
        if (frame == study.jump_frame + 1) n_eff.push_back(judge.n_eff(image));
        if (frame + 1 < shot.frames) return;
        k90.push_back(step_response(remainders).k90.value_or(study.frames_after_jump));
        remainders.clear();
    };
    const Facts facts = told ? Facts{} : Facts{{"sun_moves", false}, {"moves", true}};
    if (!run(bench, shot, study.seeds, study.jump_frame, look, facts)) return std::nullopt;
    Jump out{estimate(k90), estimate(n_eff), {}};
    for (std::vector<double>& shares : left) out.left.push_back(estimate(std::move(shares)).median);
    return out;
}

std::optional<Tilted> measure_tilted(const Bench& bench, double width_px, double tilt_deg) {
    const Study& study = bench.study;
    Tilted out{0, INFINITY, 0};
    for (const double edge_deg : study.tilted_edges_deg) {
        Shot shot = edge_shot(study, width_px, study.still_frames);
        shot.analytic->edge_deg = edge_deg;
        shot.analytic->shape = HalfPlane{tilt_deg};
        const Judge judge(study, shot, 0);
        std::vector<double> n_eff;
        const auto look = [&](uint32_t, std::span<const float> image) {
            n_eff.push_back(judge.n_eff(image));
        };
        if (!run(bench, shot, study.tilted_seeds, shot.frames - 1, look)) return std::nullopt;
        const double median = estimate(n_eff).median;
        out.mean += median / static_cast<double>(study.tilted_edges_deg.size());
        if (median < out.worst) {
            out.worst = median;
            out.worst_edge_deg = edge_deg;
        }
    }
    return out;
}

}  // namespace penumbra::gates
