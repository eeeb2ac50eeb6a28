// SPDX-License-Identifier: MIT
#include "app/report/measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "app/report/images.h"
#include "app/report/turns.h"
#include "app/truth.h"

namespace penumbra::report {
namespace {

namespace fs = std::filesystem;
using Size = std::array<uint32_t, 2>;

// The truth of any frame of a shot.
class TruthSource {
  public:
    // Without a session after an error.
    TruthSource(Device& device, Shot shot, Size size, uint32_t rays, uint32_t analytic_border_px,
                Diagnostics& diagnostics, std::vector<std::string>& warnings)
        : shot_(std::move(shot)), rays_(rays) {
        shot_.size = size;
        border_ = exact() ? analytic_border_px : 0;
        if (!exact()) session_ = open_truth(device, shot_, diagnostics, warnings);
    }

    bool exact() const { return shot_.half_plane.has_value(); }
    bool ready() const { return exact() || session_; }

    struct Frame {
        Truth truth;
        std::vector<uint8_t> counted;
    };
    Frame at(uint32_t frame) {
        Frame out{exact() ? analytic_truth(shot_, frame) : counted_truth(*session_, frame, rays_), {}};
        const auto [width, height] = shot_.size;
        for (uint32_t y = 0; y < height; ++y)
            for (uint32_t x = 0; x < width; ++x)
                out.counted.push_back(out.truth.receiver[size_t{y} * width + x] > 0.5f && x >= border_ &&
                                      y >= border_ && x + border_ < width && y + border_ < height);
        return out;
    }

  private:
    Shot shot_;
    uint32_t rays_, border_ = 0;
    std::unique_ptr<Session> session_;
};

ComparedFrame compared(Size size, const TruthSource::Frame& truth, const Turns::Masks& masks) {
    ComparedFrame frame{size[0], size[1], truth.truth.visibility, truth.counted, {}};
    for (const std::vector<float>& mask : masks) frame.seeds.emplace_back(mask);
    return frame;
}

std::set<uint32_t> moving_frames_judged(const Study& study) {
    std::set<uint32_t> frames;
    for (uint32_t f = study.moving_every - 1; f < study.moving_frames; f += study.moving_every)
        frames.insert(f);
    return frames;
}

void judge_stillness(const Study& study, const TruthSource::Frame& truth, const Turns& turns,
                     std::span<Row> rows) {
    for (Row& row : rows)
        for (const uint32_t after : study.after_cut) {
            const MetricSums sums =
                measure(compared(study.size, truth, turns.masks(row.contender, after - 1)));
            row.after_cut.push_back({after, metrics_of(sums)});
        }
}

void write_images(const Bench& bench, ShotFacts& facts, const TruthSource::Frame& truth, const Turns& turns,
                  uint32_t frame, const std::vector<Contender>& contenders, std::span<Row> rows) {
    facts.image_frame = frame;
    facts.reference_image = fmt::format("images/{}.reference.png", facts.name);
    write_mask_image(bench.folder / facts.reference_image, facts.size, truth.truth.visibility);
    for (Row& row : rows) {
        const std::string base = fmt::format("images/{}.{}", facts.name, contenders[row.contender].id);
        const std::vector<float>& mask = turns.masks(row.contender, frame).front();
        row.images = {base + ".mask.png", base + ".error.png"};
        write_mask_image(bench.folder / row.images[0], facts.size, mask);
        write_error_image(bench.folder / row.images[1], facts.size, mask, truth.truth.visibility,
                          truth.counted);
    }
}

// Judges the moving run frame by frame, since one frame's truth is held at a time.
void judge_motion(const Bench& bench, const Study& study, TruthSource& source, const Turns& turns,
                  const std::vector<Contender>& contenders, ShotFacts& facts, std::span<Row> rows) {
    std::vector<MetricSums> pooled(rows.size());
    const std::set<uint32_t> judged = moving_frames_judged(study);
    for (const uint32_t frame : judged) {
        const TruthSource::Frame truth = source.at(frame);
        for (size_t r = 0; r < rows.size(); ++r) {
            const MetricSums sums =
                measure(compared(study.size, truth, turns.masks(rows[r].contender, frame)));
            if (frame >= study.settling) pooled[r].add(sums);
            rows[r].over_time.push_back({frame, metrics_of(sums)});
        }
        bench.step();
        if (frame != *judged.rbegin()) continue;
        const MaskMetrics& last = rows.front().over_time.back().metrics;
        facts.receivers = last.receivers;
        facts.penumbra = last.penumbra;
        write_images(bench, facts, truth, turns, frame, contenders, rows);
    }
    for (size_t r = 0; r < rows.size(); ++r) rows[r].moving = metrics_of(pooled[r]);
}

void add_costs(const Costs& costs, Size size, Row& row) {
    row.mask_ms = costs.sum(&PassCost::ms, true);
    row.frame_ms = costs.sum(&PassCost::ms, false);
    row.mask_cpu_ms = costs.sum(&PassCost::cpu_ms, true);
    row.frame_cpu_ms = costs.sum(&PassCost::cpu_ms, false);
    for (size_t p = 0; p < costs.passes.size(); ++p)
        row.passes.push_back(
            {costs.passes[p], costs.pass(p, &PassCost::ms), costs.pass(p, &PassCost::cpu_ms)});
    const double rays = std::accumulate(costs.rays.begin(), costs.rays.end(), 0.0);
    if (rays > 0)
        row.rays_per_pixel = rays / (static_cast<double>(costs.rays.size()) * size[0] * size[1]);
}

}  // namespace

bool measure_shot(const Bench& bench, const ReportShot& shot, Results& results, Diagnostics& diagnostics,
                  std::vector<std::string>& warnings) {
    const Study& study = results.study;
    const std::vector<Contender>& contenders = results.contenders;
    std::vector<Row> rows(contenders.size());
    for (size_t c = 0; c < rows.size(); ++c) {
        rows[c].shot = results.shots.size();
        rows[c].contender = c;
    }
    ShotFacts facts{shot.name, shot.moving.file.generic_string(), shot.still.file.generic_string()};
    facts.size = study.size;
    {
        const auto runners = open_runners(bench.device, bench.nodes, contenders, shot.still, study.size,
                                          diagnostics, warnings);
        TruthSource source(bench.device, shot.still, study.size, study.rays, study.analytic_border_px,
                           diagnostics, warnings);
        if (runners.empty() || !source.ready()) return false;
        facts.exact = source.exact();
        TurnsOptions options{study.after_cut.back(), study.seeds, study.warm_up, {}};
        for (const uint32_t after : study.after_cut) options.judged.insert(after - 1);
        const Turns turns(runners, contenders.size(), options, bench.step);
        judge_stillness(study, source.at(0), turns, rows);
        bench.step();
    }
    const auto runners = open_runners(bench.device, bench.nodes, contenders, shot.moving, study.size,
                                      diagnostics, warnings);
    TruthSource source(bench.device, shot.moving, study.size, study.rays, study.analytic_border_px,
                       diagnostics, warnings);
    if (runners.empty() || !source.ready()) return false;
    const Turns turns(runners, contenders.size(),
                      {study.moving_frames, study.seeds, study.warm_up, moving_frames_judged(study)},
                      bench.step);
    judge_motion(bench, study, source, turns, contenders, facts, rows);
    for (Row& row : rows) add_costs(turns.costs(row.contender), study.size, row);
    results.shots.push_back(std::move(facts));
    std::move(rows.begin(), rows.end(), std::back_inserter(results.rows));
    return true;
}

bool measure_edge(const Bench& bench, const EdgeShot& edge, Results& results, Diagnostics& diagnostics,
                  std::vector<std::string>& warnings) {
    const Study& study = results.study;
    const auto runners = open_runners(bench.device, bench.nodes, results.contenders, edge.shot,
                                      study.edge_size, diagnostics, warnings);
    if (runners.empty()) return false;
    TruthSource source(bench.device, edge.shot, study.edge_size, study.rays, study.analytic_border_px,
                       diagnostics, warnings);
    const uint32_t frame = study.edge_frame;
    const Turns turns(runners, results.contenders.size(), {frame + 1, study.seeds, study.warm_up, {frame}},
                      bench.step);
    const TruthSource::Frame truth = source.at(frame);
    for (size_t c = 0; c < results.contenders.size(); ++c)
        results.edge.push_back({edge.width_px, edge.speed_px, c,
                                metrics_of(measure(compared(study.edge_size, truth, turns.masks(c, frame))))});
    return true;
}

uint32_t steps_of(const Study& study, size_t shots, size_t edges) {
    const size_t still = size_t{study.seeds} * study.after_cut.back() + 1;
    const size_t moving = size_t{study.seeds} * study.moving_frames + moving_frames_judged(study).size();
    const size_t edge = size_t{study.seeds} * (study.edge_frame + 1);
    return static_cast<uint32_t>(shots * (still + moving) + edges * edge);
}

}  // namespace penumbra::report
