// SPDX-License-Identifier: MIT
#include "app/report/radiance_measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "app/lit_picture.h"
#include "app/mask_passes.h"
#include "app/outputs.h"
#include "app/radiance_truth.h"
#include "app/report/statistics.h"
#include "app/shipped_files.h"
#include "app/signal_pipeline.h"

namespace penumbra::report {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<Session> open(const RadianceBench& bench, const RadianceResults& results, size_t contender,
                              const Shot& shot, KeptScene& scene, Diagnostics& diagnostics,
                              std::vector<std::string>& warnings) {
    SessionOptions options;
    options.kept = &scene;
    options.size = results.study.size;
    options.captures = {results.signal};
    options.jitter = false;  // the truth is that of pixel centres
    return Session::open(bench.device, bench.nodes, results.contenders[contender].pipeline, shot, options,
                         diagnostics, warnings);
}

// Of the passes that the signal depends on; nothing where one was not timed.
std::optional<double> cost_of(const Session& session, const FrameCost& cost, const std::string& signal,
                              bool cpu) {
    const std::vector<bool> needed = passes_of_mask(session.plan(), signal);
    double sum = 0;
    for (size_t p = 0; p < needed.size(); ++p) {
        if (!needed[p]) continue;
        const auto& pass = cpu ? cost.pass_cpu_ms[p] : cost.passes[p].ms;
        if (!pass) return std::nullopt;
        sum += *pass;
    }
    return sum;
}

bool measure_still(const RadianceBench& bench, const Shot& still, RadianceResults& results,
                   std::span<RadianceRow> rows, Diagnostics& diagnostics,
                   std::vector<std::string>& warnings) {
    const RadianceStudy& study = results.study;
    Shot sized = still;
    sized.size = study.size;
    const auto truth_session =
        open_radiance_truth(bench.device, sized, results.signal, diagnostics, warnings);
    if (!truth_session) return false;
    const PlanarImage truth = radiance_truth(bench.device, *truth_session, 0, study.rays);
    const RadianceTruth known = known_of(truth);
    const uint32_t frames = study.after.back();
    std::set<uint32_t> judged{frames - 2};
    for (const uint32_t after : study.after) judged.insert(after - 1);
    KeptScene scene;
    for (RadianceRow& row : rows) {
        row.still.resize(study.after.size());
        const auto session = open(bench, results, row.contender, still, scene, diagnostics, warnings);
        if (!session) return false;
        session->set_pass_costs(false);
        for (uint32_t seed = 1; seed <= study.seeds; ++seed) {
            session->set_param("seed", seed);
            PlanarImage before;
            for (uint32_t frame = 0; frame < frames; ++frame) {
                if (!has_history(session->plan()) && !judged.contains(frame)) continue;
                session->run_frame(frame, frame == 0);
                if (!judged.contains(frame)) continue;
                PlanarImage image = captured_image(*session, results.signal);
                const auto place = std::ranges::find(study.after, frame + 1);
                if (place != study.after.end())
                    row.still[static_cast<size_t>(place - study.after.begin())].add(
                        frame + 1 == frames ? radiance_errors(radiance_planes(image), known,
                                                              radiance_planes(before), known.signal)
                                            : radiance_errors(radiance_planes(image), known));
                before = std::move(image);
            }
        }
        bench.step();
    }
    return true;
}

// The true picture, but for one signal.
Picture with_signal(const LitTruth& truth, const std::string& signal, const RadiancePlanes& planes) {
    const bool specular = signal == "specular";
    const Picture &share = specular ? truth.specular_share : truth.diffuse_share,
                  &known = specular ? truth.specular : truth.diffuse;
    Picture out = truth.lit;
    for (size_t i = 0; i < out.rgb.size(); ++i)
        for (int c = 0; c < 3; ++c)
            out.rgb[i][c] += share.rgb[i][c] * (planes.rgb[size_t(c)][i] - known.rgb[i][c]);
    return out;
}

std::string write_picture(const RadianceBench& bench, const std::string& name, const Picture& picture) {
    const std::string file = "images/" + name + ".png";
    std::vector<float> rgb;
    for (const glm::vec3& v : picture.rgb) rgb.insert(rgb.end(), {v.x, v.y, v.z});
    write_png_light(bench.folder / file, picture.width, picture.height, rgb);
    return file;
}

bool measure_moving(const RadianceBench& bench, const Shot& shot, RadianceResults& results,
                    std::span<RadianceRow> rows, Diagnostics& diagnostics,
                    std::vector<std::string>& warnings) {
    const RadianceStudy& study = results.study;
    Shot sized = shot;
    sized.size = study.size;
    const auto truth_session =
        open_radiance_truth(bench.device, sized, results.signal, diagnostics, warnings);
    const auto lit_session = open_lit_truth(bench.device, sized, diagnostics, warnings);
    if (!truth_session || !lit_session) return false;
    const PlanarImage truth = radiance_truth(bench.device, *truth_session, study.moving_frame, study.rays);
    const LitTruth lit = lit_truth(*lit_session, study.moving_frame, study.rays);
    write_picture(bench, shot.name + ".reference", lit.lit);
    KeptScene scene;
    std::vector<std::unique_ptr<Session>> sessions;
    for (const RadianceRow& row : rows) {
        sessions.push_back(open(bench, results, row.contender, shot, scene, diagnostics, warnings));
        if (!sessions.back()) return false;
        sessions.back()->run_frame(0, true);  // shaders are compiled and memory is touched
    }
    std::vector<std::map<uint32_t, double>> costs(rows.size());
    for (uint32_t seed = 1; seed <= study.seeds; ++seed) {
        for (const auto& session : sessions) session->set_param("seed", seed);
        for (uint32_t frame = 0; frame <= study.moving_frame; ++frame)
            for (size_t turn = 0; turn < rows.size(); ++turn) {
                const size_t r = (turn + frame + seed) % rows.size();
                Session& session = *sessions[r];
                RadianceRow& row = rows[r];
                const bool timed = frame >= study.timed_from;
                if (!has_history(session.plan()) && !timed) continue;
                const FrameCost cost = session.run_frame(frame, frame == 0);
                if (const auto ms = cost_of(session, cost, results.signal, results.cpu); ms && timed) {
                    const auto [least, first] = costs[r].try_emplace(frame, *ms);
                    least->second = std::min(least->second, *ms);
                }
                if (frame < study.moving_frame) continue;
                const PlanarImage image = captured_image(session, results.signal);
                row.moving.add(radiance_errors(radiance_planes(image), known_of(truth)));
                if (seed > 1) continue;
                const Picture picture = with_signal(lit, results.signal, radiance_planes(image));
                const PictureError error = picture_error(picture, lit.lit);
                row.flip = error.flip;
                row.lit_relmse = error.relmse;
                row.image =
                    write_picture(bench, shot.name + "." + results.contenders[row.contender].id, picture);
            }
        bench.step();
    }
    for (size_t r = 0; r < rows.size(); ++r) {
        std::vector<double> samples;
        for (const auto& [frame, ms] : costs[r]) samples.push_back(ms);
        if (const auto estimate = median_of(std::move(samples))) rows[r].cost_ms = estimate->median;
    }
    return true;
}

}  // namespace

std::optional<std::vector<RadianceContender>> radiance_contenders(const std::vector<std::string>& wanted,
                                                                  const std::string& signal,
                                                                  const RadianceStudy& study,
                                                                  const fs::path& root, const NodeSet& nodes,
                                                                  Diagnostics& diagnostics) {
    std::vector<RadianceContender> out;
    const auto add = [&](const std::string& name, std::optional<uint32_t> rays) {
        const auto file = shipped_file(name, root, shipped_pipelines, diagnostics);
        if (!file) return;
        std::vector<std::string> settings;
        if (rays) settings.push_back(fmt::format("nodes.rays.params.rays_per_pixel={}", *rays));
        auto pipeline = signal_pipeline(*file, signal, settings, nodes, diagnostics);
        if (!pipeline) return;
        const std::string id = rays ? fmt::format("rays_{}", *rays) : pipeline->name;
        for (const RadianceContender& other : out)
            if (other.id == id) diagnostics.add({file->string(), 0, 0}, "name", "\"" + id + "\" twice");
        out.push_back({id, file->generic_string(), rays, settings, std::move(*pipeline)});
    };
    for (const std::string& name : wanted) add(name, std::nullopt);
    for (const uint32_t rays : study.brute_force)
        add(signal == "specular" ? "raw_reflections" : "raw_indirect", rays);
    if (!diagnostics.empty()) return std::nullopt;
    return out;
}

std::optional<FrontPoint> front_point(const RadianceRow& row) {
    const auto n_eff = row.moving.n_eff();
    if (!row.cost_ms || !n_eff) return std::nullopt;
    return FrontPoint{*row.cost_ms, *n_eff};
}

std::optional<Front::Reading> over_brute_force(const RadianceResults& results, const RadianceRow& row) {
    std::vector<FrontPoint> points;
    for (const RadianceRow& other : results.rows)
        if (other.shot == row.shot && results.contenders[other.contender].rays)
            if (const auto point = front_point(other)) points.push_back(*point);
    const auto own = front_point(row);
    auto there = own ? Front(points).worth_at(own->cost) : std::nullopt;
    if (there) there->value = own->worth / there->value;
    return there;
}

uint32_t work_of(const RadianceResults& results) {
    return static_cast<uint32_t>(results.contenders.size()) + results.study.seeds;
}

bool measure_radiance(const RadianceBench& bench, const ReportShot& shot, RadianceResults& results,
                      Diagnostics& diagnostics, std::vector<std::string>& warnings) {
    std::vector<RadianceRow> rows(results.contenders.size());
    for (size_t c = 0; c < rows.size(); ++c) {
        rows[c].shot = shot.name;
        rows[c].contender = c;
    }
    if (!measure_still(bench, *shot.still, results, rows, diagnostics, warnings) ||
        !measure_moving(bench, shot.moving, results, rows, diagnostics, warnings))
        return false;
    results.shots.push_back(shot.name);
    std::move(rows.begin(), rows.end(), std::back_inserter(results.rows));
    return true;
}

}  // namespace penumbra::report
