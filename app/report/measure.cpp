// SPDX-License-Identifier: MIT
#include "app/report/measure.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <set>

#include "app/progress.h"
#include "app/report/images.h"
#include "app/report/motion_image.h"
#include "app/report/truth_source.h"
#include "app/report/turns.h"

namespace penumbra::report {
namespace {

namespace fs = std::filesystem;
using Size = std::array<uint32_t, 2>;

// Finding the truth of a frame and judging all masks by it takes about as long as so many frames of all
// contenders.
constexpr uint64_t judging_work = 12;
// Behind edges, where most contenders run in one frame only or not at all.
constexpr uint64_t edge_share = 2;

std::string now_utc() {
    return fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(std::time(nullptr)));
}

ComparedFrame compared(Size size, const TruthSource::Frame& truth, const Turns::Masks& masks) {
    ComparedFrame frame{size[0], size[1], truth.truth.visibility, truth.counted, {}};
    if (!truth.exact) frame.reference_rays = truth.truth.rays;
    for (const std::vector<float>& mask : masks) frame.seeds.emplace_back(mask);
    return frame;
}

std::set<uint32_t> moving_frames_judged(const Study& study) {
    std::set<uint32_t> frames;
    for (uint32_t f = study.moving_every - 1; f < study.moving_frames; f += study.moving_every)
        frames.insert(f);
    return frames;
}

// Costs are of the frames whose errors are pooled.
std::set<uint32_t> moving_frames_timed(const Study& study) {
    std::set<uint32_t> frames = moving_frames_judged(study);
    std::erase_if(frames, [&](uint32_t frame) { return frame < study.settling; });
    return frames;
}

// Rows of contenders have their places in `originals`; what is judged is the same for the same masks.
bool is_original(const std::vector<size_t>& originals, const Row& row) {
    return originals[row.contender] == row.contender;
}

void judge_stillness(const Study& study, const TruthSource::Frame& truth, const Turns& turns,
                     const std::vector<size_t>& originals, std::span<Row> rows) {
    // Nothing moves: a point stays where it is, and so does the truth.
    const std::vector<float> nowhere(truth.counted.size(), 0.0f), everywhere(truth.counted.size(), 1.0f);
    for (Row& row : rows) {
        if (!is_original(originals, row)) continue;
        for (const uint32_t after : study.after_cut) {
            const MetricSums sums =
                measure(compared(study.size, truth, turns.masks(row.contender, after - 1)));
            row.after_cut.push_back({after, metrics_of(sums)});
        }
        const uint32_t last = study.after_cut.back() - 1;
        const ComparedFrame now = compared(study.size, truth, turns.masks(row.contender, last));
        const ComparedFrame before = compared(study.size, truth, turns.masks(row.contender, last - 1));
        FlickerSums sums;
        add_flicker({now, before, nowhere, nowhere, nowhere, everywhere, everywhere}, sums);
        row.flicker = sums.rms();
    }
    for (Row& row : rows) {
        row.after_cut = rows[originals[row.contender]].after_cut;
        row.flicker = rows[originals[row.contender]].flicker;
    }
}

// What the masks make of the picture that the sun lights, under the first seed.
void judge_picture(const Study& study, TruthSource& source, const TruthSource::Frame& truth, uint32_t frame,
                   const Turns& turns, const std::vector<size_t>& originals, std::span<Row> rows) {
    const LitSurfaces lit = source.surfaces(frame);
    const Surfaces surfaces{lit.albedo, lit.normal, lit.to_sun};
    for (Row& row : rows) {
        if (!is_original(originals, row)) continue;
        const Turns::Masks& masks = turns.masks(row.contender, frame);
        const ComparedFrame one = compared(study.size, truth, {masks.front()});
        const std::vector<glm::vec3> image = shade_surfaces(surfaces, one, masks.front()),
                                     reference = shade_surfaces(surfaces, one, one.truth);
        row.relmse = relative_error(one, image, reference).mean();
        const std::vector<float> map =
            flip_map(one.width, one.height, display_linear(reference), display_linear(image));
        std::vector<float> counted;
        for (size_t p = 0; p < map.size(); ++p)
            if (one.counted[p]) counted.push_back(map[p]);
        row.flip = pool_flip(std::move(counted));
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

void write_motion(const Bench& bench, const TurnsOptions& options, const Turns& turns, ShotFacts& facts) {
    if (options.shown.empty() || options.showing.empty()) return;
    std::vector<std::vector<std::span<const float>>> masks;
    for (const size_t contender : options.showing) {
        masks.emplace_back();
        for (const uint32_t frame : options.shown) masks.back().emplace_back(turns.shown(contender, frame));
    }
    facts.motion_image = fmt::format("images/{}.motion.webp", facts.name);
    write_motion_image(bench.folder / facts.motion_image, facts.size, masks);
}

// Judges the moving run frame by frame, since one frame's truth is held at a time.
void judge_motion(const Bench& bench, const Study& study, TruthSource& source, const Turns& turns,
                  const std::vector<size_t>& originals, const std::vector<Contender>& contenders,
                  ShotFacts& facts, std::span<Row> rows) {
    std::vector<MetricSums> pooled(rows.size());
    std::vector<SsimSum> ssim(rows.size());
    const std::set<uint32_t> judged = moving_frames_judged(study);
    for (const uint32_t frame : judged) {
        const TruthSource::Frame truth = source.at(frame);
        for (size_t r = 0; r < rows.size(); ++r) {
            if (!is_original(originals, rows[r])) continue;
            const ComparedFrame one = compared(study.size, truth, turns.masks(rows[r].contender, frame));
            const MetricSums sums = measure(one);
            if (frame >= study.settling) {
                pooled[r].add_frame(frame, sums);
                ssim[r].add(ssim_near_penumbra(one));
                if (const auto bias = largest_bias_9x9(one))
                    rows[r].bias_9x9 = std::max(rows[r].bias_9x9.value_or(0), *bias);
            }
            rows[r].over_time.push_back({frame, metrics_of(sums)});
        }
        bench.step(study.size[0] * study.size[1] * judging_work);
        if (frame != *judged.rbegin()) continue;
        const MaskMetrics& last =
            rows[originals.front()].over_time.back().metrics;  // all have the same truth
        facts.receivers = last.receivers;
        facts.penumbra = last.penumbra;
        if (!source.of_lamp()) judge_picture(study, source, truth, frame, turns, originals, rows);
        write_images(bench, facts, truth, turns, frame, contenders, rows);
    }
    for (size_t r = 0; r < rows.size(); ++r) {
        rows[r].moving = metrics_of(pooled[r]);
        rows[r].ssim = ssim[r].mean();
    }
    for (Row& row : rows) {
        const Row& original = rows[originals[row.contender]];
        if (&original == &row) continue;
        row.moving = original.moving;
        row.ssim = original.ssim;
        row.bias_9x9 = original.bias_9x9;
        row.over_time = original.over_time;
        row.flip = original.flip;
        row.relmse = original.relmse;
    }
}

void add_costs(const Costs& costs, Size size, Row& row) {
    std::vector<double> maps;
    double rays = 0;
    for (const auto& [number, frame] : costs.frames) {
        if (frame.maps_cpu_ms) maps.push_back(*frame.maps_cpu_ms);
        rays += frame.rays;
    }
    row.maps_cpu_ms = median_of(std::move(maps));
    row.mask_ms = costs.sum(&PassCost::ms, true);
    row.frame_ms = costs.sum(&PassCost::ms, false);
    row.mask_cpu_ms = costs.sum(&PassCost::cpu_ms, true);
    row.frame_cpu_ms = costs.sum(&PassCost::cpu_ms, false);
    for (size_t p = 0; p < costs.passes.size(); ++p)
        row.passes.push_back(
            {costs.passes[p], costs.pass(p, &PassCost::ms), costs.pass(p, &PassCost::cpu_ms)});
    if (rays > 0) row.rays_per_pixel = rays / (static_cast<double>(costs.frames.size()) * size[0] * size[1]);
}

bool measure_stillness(const Bench& bench, const Study& study, const Shot& still,
                       const std::vector<Contender>& contenders, std::span<Row> rows,
                       std::vector<size_t>& originals, Diagnostics& diagnostics,
                       std::vector<std::string>& warnings) {
    const auto runners =
        open_runners(bench.device, bench.nodes, contenders, still, study.size, false, diagnostics, warnings);
    TruthSource source(bench.device, still, study.size, study.rays, study.analytic_border_px, diagnostics,
                       warnings);
    if (runners.empty() || !source.ready()) return false;
    TurnsOptions options;
    options.frames = study.after_cut.back();
    options.seeds = study.seeds;
    options.still = true;
    options.judged = {study.after_cut.back() - 2};  // beside the last one, for flicker
    for (const uint32_t after : study.after_cut) options.judged.insert(after - 1);
    const Turns turns(runners, options, [&] { bench.step(study.size[0] * study.size[1]); });
    originals = turns.originals();
    judge_stillness(study, source.at(0), turns, originals, rows);
    bench.step(study.size[0] * study.size[1] * judging_work);
    return true;
}

// Each contender runs once before anything is timed: shaders are compiled and memory is touched then. This
// says how long all of their turns will take, at most: contenders of the same masks are left out of later
// ones.
void warm_up(const Bench& bench, const std::string& shot, const std::vector<std::unique_ptr<Runner>>& runners,
             const TurnsOptions& options) {
    double seconds = 0;
    for (size_t contender = 0; contender < runners.size(); ++contender) {
        const auto& runner = runners[contender];
        std::chrono::duration<double> once{};
        constexpr double short_s = 0.5;  // the second time says more, and costs little
        for (int again = 0; again < 2 && (again == 0 || once.count() < short_s); ++again) {
            const auto start = std::chrono::steady_clock::now();
            runner->run(0, true, false);
            once = std::chrono::steady_clock::now() - start;
        }
        for (uint32_t round = 0; round < options.rounds(); ++round)
            for (uint32_t frame = 0; frame < options.frames; ++frame)
                if (options.shows(contender, round, frame) ||
                    takes_turn(options, *runner, true, round, frame))
                    seconds += once.count();
    }
    bench.say(fmt::format("{}: about {} for {} contenders in {} rounds, besides the truth of {} frames", shot,
                          duration_text(seconds), runners.size(), options.rounds(), options.judged.size()));
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
    ShotFacts facts{shot.name, shot.moving.file.generic_string(),
                    shot.still ? shot.still->file.generic_string() : ""};
    facts.size = study.size;
    facts.measured = now_utc();
    std::vector<size_t> originals_still;
    if (shot.still && !measure_stillness(bench, study, *shot.still, contenders, rows, originals_still,
                                         diagnostics, warnings))
        return false;
    const auto runners = open_runners(bench.device, bench.nodes, contenders, shot.moving, study.size, true,
                                      diagnostics, warnings);
    TruthSource source(bench.device, shot.moving, study.size, study.rays, study.analytic_border_px,
                       diagnostics, warnings);
    if (runners.empty() || !source.ready()) return false;
    facts.exact = source.exact();
    TurnsOptions options;
    options.frames = study.moving_frames;
    options.seeds = study.seeds;
    options.timings = study.rounds;
    options.judged = moving_frames_judged(study);
    options.timed = moving_frames_timed(study);
    options.showing = shown_in_motion(contenders);
    for (uint32_t shown = 0; shown < std::min(study.motion_frames, study.moving_frames); ++shown)
        options.shown.insert(study.moving_frames - 1 - shown);
    warm_up(bench, shot.name, runners, options);
    const Turns turns(runners, options, [&] { bench.step(study.size[0] * study.size[1]); });
    const std::vector<size_t> originals = turns.originals();
    judge_motion(bench, study, source, turns, originals, contenders, facts, rows);
    write_motion(bench, options, turns, facts);
    for (Row& row : rows) {
        add_costs(turns.costs(row.contender), study.size, row);
        const size_t original = originals[row.contender];
        if (original != row.contender && (!shot.still || original == originals_still[row.contender]))
            row.same_as = original;
    }
    results.shots.push_back(std::move(facts));
    std::move(rows.begin(), rows.end(), std::back_inserter(results.rows));
    return true;
}

bool measure_edge(const Bench& bench, const EdgeShot& edge, Results& results, Diagnostics& diagnostics,
                  std::vector<std::string>& warnings) {
    const Study& study = results.study;
    std::vector<Contender> originals;
    std::vector<size_t> place(results.contenders.size());  // among the originals
    for (size_t c = 0; c < place.size(); ++c) {
        if (results.original(c) != c) continue;
        place[c] = originals.size();
        originals.push_back(results.contenders[c]);
    }
    const auto runners = open_runners(bench.device, bench.nodes, originals, edge.shot, study.edge_size, false,
                                      diagnostics, warnings);
    if (runners.empty()) return false;
    TruthSource source(bench.device, edge.shot, study.edge_size, study.rays, study.analytic_border_px,
                       diagnostics, warnings);
    if (!source.ready()) return false;
    const uint32_t frame = study.edge_frame;
    TurnsOptions options;
    options.frames = frame + 1;
    options.seeds = study.seeds;
    options.judged = {frame};
    const Turns turns(runners, options,
                      [&] { bench.step(uint64_t{study.edge_size[0]} * study.edge_size[1] / edge_share); });
    const TruthSource::Frame truth = source.at(frame), before = source.at(frame - 1);
    std::vector<EdgePoint> points;
    for (size_t c = 0; c < originals.size(); ++c) {
        const ComparedFrame one = compared(study.edge_size, truth, turns.masks(c, frame));
        points.push_back({edge.width_px, edge.speed_px, c, metrics_of(measure(one)),
                          lag_px(one, before.truth.visibility)});
    }
    for (size_t c = 0; c < place.size(); ++c) {
        results.edge.push_back(points[place[results.original(c)]]);
        results.edge.back().contender = c;
    }
    return true;
}

uint64_t work_of_shot(const Study& study) {
    const uint64_t pixels = uint64_t{study.size[0]} * study.size[1];
    const uint64_t still =
        study.after_cut.empty() ? 0 : study.seeds * uint64_t{study.after_cut.back()} + judging_work;
    return pixels * (still + std::max(study.seeds, study.rounds) * uint64_t{study.moving_frames} +
                     judging_work * moving_frames_judged(study).size());
}

uint64_t work_of_edge(const Study& study) {
    const uint64_t frame = uint64_t{study.edge_size[0]} * study.edge_size[1] / edge_share;
    return frame * study.seeds * (study.edge_frame + 1);
}

}  // namespace penumbra::report
