// SPDX-License-Identifier: MIT
// results.json back into results, value by value as results.cpp writes them.
#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "app/report/results.h"

namespace penumbra::report {
namespace {

using Json = nlohmann::ordered_json;

std::optional<double> known(const Json& value) {
    return value.is_null() ? std::nullopt : std::optional(value.get<double>());
}

std::optional<std::array<double, 2>> range(const Json& value) {
    return value.is_null() ? std::nullopt : std::optional(value.get<std::array<double, 2>>());
}

std::optional<Estimate> estimate(const Json& json) {
    const auto median = known(json.at("median"));
    if (!median) return std::nullopt;
    Estimate out{*median, {}, {}};
    if (const auto interval = range(json.at("ci95"))) {
        out.low = (*interval)[0];
        out.high = (*interval)[1];
    }
    return out;
}

MaskMetrics metrics(const Json& json) {
    MaskMetrics m;
    const Json &pixels = json.at("pixels"), &rmse = json.at("rmse"), &n_eff = json.at("n_eff");
    pixels.at("receivers").get_to(m.receivers);
    pixels.at("penumbra").get_to(m.penumbra);
    pixels.at("lit").get_to(m.lit);
    pixels.at("umbra").get_to(m.umbra);
    m.rmse_all = known(rmse.at("all"));
    m.rmse_penumbra = known(rmse.at("penumbra"));
    m.rmse_lit = known(rmse.at("lit"));
    m.rmse_umbra = known(rmse.at("umbra"));
    m.psnr_db = known(json.at("psnr_db"));
    m.max_abs = known(json.at("max_abs"));
    m.n_eff = known(n_eff.at("value"));
    m.n_eff_penumbra = known(n_eff.at("penumbra_only"));
    m.n_eff_ci95 = range(n_eff.at("ci95"));
    m.n_variance = known(n_eff.at("variance_part"));
    m.n_bias = known(n_eff.at("bias_part"));
    m.leak = known(json.at("leak"));
    m.acne = known(json.at("acne"));
    json.at("nonfinite").get_to(m.nonfinite);
    return m;
}

std::vector<Judged> judged(const Json& json) {
    std::vector<Judged> out;
    for (const Json& frame : json) out.push_back({frame.at("frame").get<uint32_t>(), metrics(frame)});
    return out;
}

size_t contender(const Results& results, const Json& id) {
    for (size_t c = 0; c < results.contenders.size(); ++c)
        if (results.contenders[c].id == id.get<std::string>()) return c;
    throw nlohmann::json::other_error::create(501, "no such contender", &id);
}

ShotFacts shot(const Json& json) {
    ShotFacts facts;
    json.at("name").get_to(facts.name);
    json.at("file").get_to(facts.file);
    facts.still_file = json.at("still_file").is_null() ? "" : json.at("still_file").get<std::string>();
    json.at("size").get_to(facts.size);
    json.at("exact").get_to(facts.exact);
    json.at("receivers").get_to(facts.receivers);
    json.at("penumbra").get_to(facts.penumbra);
    json.at("image_frame").get_to(facts.image_frame);
    json.at("reference_image").get_to(facts.reference_image);
    facts.motion_image = json.at("motion_image").is_null() ? "" : json.at("motion_image").get<std::string>();
    json.at("measured").get_to(facts.measured);
    return facts;
}

Row row(const Results& results, const Json& json) {
    Row out;
    out.contender = contender(results, json.at("contender"));
    if (!json.at("same_masks_as").is_null()) out.same_as = contender(results, json.at("same_masks_as"));
    out.mask_ms = estimate(json.at("mask_ms"));
    out.mask_cpu_ms = estimate(json.at("mask_cpu_ms"));
    out.frame_ms = estimate(json.at("frame_ms"));
    out.frame_cpu_ms = estimate(json.at("frame_cpu_ms"));
    out.maps_cpu_ms = estimate(json.at("maps_cpu_ms"));
    out.rays_per_pixel = known(json.at("rays_per_pixel"));
    out.moving = metrics(json.at("moving"));
    out.ssim = known(json.at("ssim"));
    out.bias_9x9 = known(json.at("bias_max_9x9"));
    const Json& flip = json.at("flip");
    if (const auto mean = known(flip.at("mean")))
        out.flip =
            FlipPool{*mean, known(flip.at("weighted_median")).value_or(0), known(flip.at("p95")).value_or(0)};
    out.relmse = known(json.at("relmse"));
    out.flicker = known(json.at("flicker_rms"));
    out.after_cut = judged(json.at("after_cut"));
    out.over_time = judged(json.at("over_time"));
    for (const Json& pass : json.at("passes"))
        out.passes.push_back({{pass.at("node").get<std::string>(), pass.at("type").get<std::string>(),
                               pass.at("mask").get<bool>()},
                              estimate(pass.at("ms")),
                              estimate(pass.at("cpu_ms"))});
    json.at("images").get_to(out.images);
    return out;
}

EdgePoint edge_point(const Results& results, const Json& json) {
    return {json.at("width_px").get<double>(), json.at("speed_px").get<double>(),
            contender(results, json.at("contender")), metrics(json), known(json.at("lag_px"))};
}

}  // namespace

void append(const nlohmann::ordered_json& json, Results& results) {
    std::vector<ShotFacts> shots;
    std::vector<Row> rows;
    std::vector<EdgePoint> edge;
    for (const Json& facts : json.at("shots")) shots.push_back(shot(facts));
    for (const Json& values : json.at("results")) {
        rows.push_back(row(results, values));
        for (rows.back().shot = 0; rows.back().shot < shots.size(); ++rows.back().shot)
            if (shots[rows.back().shot].name == values.at("shot").get<std::string>()) break;
        rows.back().shot += results.shots.size();
    }
    for (const Json& point : json.at("edge")) edge.push_back(edge_point(results, point));
    // Nothing is added before all has been read.
    std::ranges::move(shots, std::back_inserter(results.shots));
    std::ranges::move(rows, std::back_inserter(results.rows));
    std::ranges::move(edge, std::back_inserter(results.edge));
}

}  // namespace penumbra::report
