// SPDX-License-Identifier: MIT
#include "app/report/results.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/device_json.h"
#include "app/metrics_json.h"
#include "app/or_null.h"
#include "app/report/front_figures.h"

namespace penumbra::report {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson estimate_json(const std::optional<Estimate>& estimate) {
    if (!estimate) return {{"median", nullptr}, {"ci95", nullptr}};
    const bool interval = estimate->low && estimate->high;
    return {{"median", estimate->median},
            {"ci95", interval ? OrderedJson{*estimate->low, *estimate->high} : OrderedJson()}};
}

OrderedJson judged_json(const std::vector<Judged>& list) {
    OrderedJson out = OrderedJson::array();
    for (const Judged& judged : list) {
        out.push_back({{"frame", judged.frame}});
        out.back().update(metrics_json(judged.metrics));
    }
    return out;
}

OrderedJson reading_json(const std::optional<Front::Reading>& reading) {
    return {{"value", reading && std::isfinite(reading->value) ? OrderedJson(reading->value) : OrderedJson()},
            {"extrapolated", reading ? OrderedJson(reading->extrapolated) : OrderedJson()}};
}

OrderedJson front_json(const FrontFigure& figure) {
    return {{"exact", figure.exact},
            {"on_front", figure.on_front},
            {"n_eff_over_plain", reading_json(figure.over_plain)},
            {"brute_force_time", reading_json(figure.brute_force_time)}};
}

OrderedJson row_json(const Results& results, const Row& row) {
    OrderedJson passes = OrderedJson::array();
    for (const PassFigure& figure : row.passes)
        passes.push_back({{"node", figure.pass.node},
                          {"type", figure.pass.type},
                          {"mask", figure.pass.mask},
                          {"ms", estimate_json(figure.ms)},
                          {"cpu_ms", estimate_json(figure.cpu_ms)}});
    return {{"shot", results.shots[row.shot].name},
            {"contender", results.contenders[row.contender].id},
            {"same_masks_as", row.same_as ? OrderedJson(results.contenders[*row.same_as].id) : OrderedJson()},
            {"mask_ms", estimate_json(row.mask_ms)},
            {"mask_cpu_ms", estimate_json(row.mask_cpu_ms)},
            {"frame_ms", estimate_json(row.frame_ms)},
            {"frame_cpu_ms", estimate_json(row.frame_cpu_ms)},
            {"maps_cpu_ms", estimate_json(row.maps_cpu_ms)},
            {"rays_per_pixel", or_null(row.rays_per_pixel)},
            {"moving", metrics_json(row.moving)},
            {"front", front_json(front_figure(results, row))},
            {"ssim", or_null(row.ssim)},
            {"bias_max_9x9", or_null(row.bias_9x9)},
            {"flip", flip_json(row.flip)},
            {"relmse", or_null(row.relmse)},
            {"flicker_rms", or_null(row.flicker)},
            {"after_cut", judged_json(row.after_cut)},
            {"over_time", judged_json(row.over_time)},
            {"passes", passes},
            {"images", row.images}};
}

OrderedJson study_json(const Study& s) {
    return {{"size", s.size},
            {"light", s.light.empty() ? OrderedJson() : OrderedJson(s.light)},
            {"seeds", s.seeds},
            {"rounds", s.rounds},
            {"rays", s.rays},
            {"after_cut", s.after_cut},
            {"moving_frames", s.moving_frames},
            {"moving_every", s.moving_every},
            {"settling", s.settling},
            {"motion_frames", s.motion_frames},
            {"edge_size", s.edge_size},
            {"edge_frame", s.edge_frame},
            {"edge_widths_px", s.edge_widths_px},
            {"edge_speeds_px", s.edge_speeds_px},
            {"analytic_border_px", s.analytic_border_px}};
}

std::string csv_number(const std::optional<double>& value) {
    return value ? fmt::format("{:.6g}", *value) : "";
}

}  // namespace

const MaskMetrics* Row::after(uint32_t frames) const {
    for (const Judged& judged : after_cut)
        if (judged.frame == frames) return &judged.metrics;
    return nullptr;
}

const Row* Results::row(size_t shot, size_t contender) const {
    for (const Row& r : rows)
        if (r.shot == shot && r.contender == contender) return &r;
    return nullptr;
}

size_t Results::original(size_t contender) const {
    std::optional<size_t> original;
    for (const Row& r : rows) {
        if (r.contender != contender) continue;
        if (!r.same_as || original.value_or(*r.same_as) != *r.same_as) return contender;
        original = r.same_as;
    }
    return original.value_or(contender);
}

const EdgePoint* Results::worst_edge(size_t contender, double width_px) const {
    const EdgePoint* worst = nullptr;
    for (const EdgePoint& point : edge)
        if (point.contender == contender && point.width_px == width_px && point.speed_px != 0 &&
            point.metrics.n_eff && (!worst || *point.metrics.n_eff < *worst->metrics.n_eff))
            worst = &point;
    return worst;
}

const EdgePoint* Results::resting_edge(size_t contender, double width_px) const {
    for (const EdgePoint& point : edge)
        if (point.contender == contender && point.width_px == width_px && point.speed_px == 0) return &point;
    return nullptr;
}

std::string Results::speed_of(const EdgePoint& worst) const {
    for (const EdgePoint& point : edge)
        if (point.contender == worst.contender && point.width_px == worst.width_px && point.speed_px != 0 &&
            point.metrics.n_eff != worst.metrics.n_eff)
            return fmt::format("{:+g}", worst.speed_px);
    return "any";
}

OrderedJson to_json(const Results& results) {
    OrderedJson contenders = OrderedJson::array(), left_out = OrderedJson::array(),
                shots = OrderedJson::array(), rows = OrderedJson::array(), edge = OrderedJson::array();
    for (const Contender& c : results.contenders)
        contenders.push_back({{"id", c.id},
                              {"file", c.file.empty() ? OrderedJson() : OrderedJson(c.file)},
                              {"settings", c.settings},
                              {"doc", c.doc},
                              {"plain_rays", c.plain ? OrderedJson(c.plain->per_pixel) : OrderedJson()},
                              {"proofs", c.plain ? OrderedJson(c.plain->proofs) : OrderedJson()}});
    for (const LeftOut& l : results.left_out) left_out.push_back({{"file", l.file}, {"why", l.why}});
    for (const ShotFacts& s : results.shots)
        shots.push_back(
            {{"name", s.name},
             {"file", s.file},
             {"still_file", s.still_file.empty() ? OrderedJson() : OrderedJson(s.still_file)},
             {"size", s.size},
             {"exact", s.exact},
             {"receivers", s.receivers},
             {"penumbra", s.penumbra},
             {"image_frame", s.image_frame},
             {"reference_image", s.reference_image},
             {"motion_image", s.motion_image.empty() ? OrderedJson() : OrderedJson(s.motion_image)},
             {"measured", s.measured}});
    for (const Row& row : results.rows) rows.push_back(row_json(results, row));
    for (const EdgePoint& point : results.edge) {
        edge.push_back({{"width_px", point.width_px},
                        {"speed_px", point.speed_px},
                        {"contender", results.contenders[point.contender].id}});
        edge.back().update(metrics_json(point.metrics));
        edge.back()["lag_px"] = or_null(point.lag_px);
    }
    OrderedJson device = device_json(results.device);
    device["subgroup"] = results.device.subgroup_size;
    return {{"penumbra", 1},
            {"version", PENUMBRA_VERSION},
            {"command", results.command},
            {"quick", results.quick},
            {"device", device},
            {"study", study_json(results.study)},
            {"contenders", contenders},
            {"left_out", left_out},
            {"shots", shots},
            {"results", rows},
            {"edge", edge}};
}

std::string csv_field(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string out = "\"";
    for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
    return out + "\"";
}

std::string to_csv(const Results& results) {
    std::string out =
        "shot,contender,plain_rays,proofs,same_masks_as,mask_ms,mask_ms_low,mask_ms_high,mask_cpu_ms,"
        "mask_cpu_ms_low,mask_cpu_ms_high,frame_ms,frame_cpu_ms,maps_cpu_ms,rays_per_pixel,rmse_all,"
        "rmse_penumbra,n_eff,n_eff_low,n_eff_high,n_eff_over_plain,n_eff_over_plain_extrapolated,"
        "brute_force_time,brute_force_time_extrapolated,on_front,ssim,flip_mean,relmse,flicker_rms,"
        "n_eff_at_1,n_eff_at_8,n_eff_at_64\r\n";
    for (const Row& row : results.rows) {
        const Contender& contender = results.contenders[row.contender];
        const auto estimate = [](const std::optional<Estimate>& e) {
            return e ? fmt::format("{:.6g},{},{}", e->median, csv_number(e->low), csv_number(e->high)) : ",,";
        };
        const auto median = [](const std::optional<Estimate>& e) {
            return csv_number(e ? std::optional(e->median) : std::nullopt);
        };
        const auto after = [&](uint32_t frames) {
            const MaskMetrics* m = row.after(frames);
            return csv_number(m ? m->n_eff : std::nullopt);
        };
        const auto reading = [](const std::optional<Front::Reading>& r) {
            return r ? fmt::format("{:.6g},{}", r->value, r->extrapolated) : ",";
        };
        const auto& interval = row.moving.n_eff_ci95;
        const FrontFigure front = front_figure(results, row);
        out += fmt::format(
            "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\r\n",
            csv_field(results.shots[row.shot].name), csv_field(contender.id),
            contender.plain ? fmt::to_string(contender.plain->per_pixel) : "",
            contender.plain ? fmt::to_string(contender.plain->proofs) : "",
            csv_field(row.same_as ? results.contenders[*row.same_as].id : ""), estimate(row.mask_ms),
            estimate(row.mask_cpu_ms), median(row.frame_ms), median(row.frame_cpu_ms),
            median(row.maps_cpu_ms), csv_number(row.rays_per_pixel), csv_number(row.moving.rmse_all),
            csv_number(row.moving.rmse_penumbra), csv_number(row.moving.n_eff),
            csv_number(interval ? std::optional((*interval)[0]) : std::nullopt),
            csv_number(interval ? std::optional((*interval)[1]) : std::nullopt), reading(front.over_plain),
            reading(front.brute_force_time), front.on_front, csv_number(row.ssim),
            csv_number(row.flip ? std::optional(row.flip->mean) : std::nullopt), csv_number(row.relmse),
            csv_number(row.flicker), after(1), after(8), after(64));
    }
    return out;
}

}  // namespace penumbra::report
