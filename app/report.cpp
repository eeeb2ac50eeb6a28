// SPDX-License-Identifier: MIT
// Medians rather than means: these figures are read on machines that do other things too.
#include "app/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/device_json.h"
#include "app/mask_passes.h"
#include "app/mebibytes.h"
#include "app/plan_json.h"

namespace penumbra {
namespace {

using OrderedJson = nlohmann::ordered_json;
using Samples = std::vector<double>;

OrderedJson quantile(Samples samples, double q) {
    if (samples.empty()) return {};
    std::sort(samples.begin(), samples.end());
    return samples[std::min(samples.size() - 1,
                            static_cast<size_t>(q * static_cast<double>(samples.size())))];
}

OrderedJson median(const Samples& samples) {
    return quantile(samples, 0.5);
}

// Quantiles are values that occurred, so those of counts are whole numbers.
OrderedJson median_count(const Samples& samples) {
    const OrderedJson value = median(samples);
    return value.is_null() ? value : OrderedJson(static_cast<uint64_t>(value.get<double>()));
}

std::span<const FrameCost> warmed_up(const std::vector<FrameCost>& costs) {
    return std::span(costs).subspan(costs.size() > 2 ? 2 : 0);
}

template <class Get>
Samples collect(std::span<const FrameCost> costs, Get&& get) {
    Samples samples;
    for (const FrameCost& cost : costs)
        if (const std::optional<double> value = get(cost)) samples.push_back(*value);
    return samples;
}

// Values of a node's parameters; null for those that the pipeline does not have, as what was added to look at
// it.
OrderedJson params_json(const CheckedPipeline& pipeline, const std::string& id) {
    const auto node = std::ranges::find(pipeline.nodes, id, &BoundNode::id);
    if (node == pipeline.nodes.end()) return nullptr;
    OrderedJson out = OrderedJson::object();
    for (size_t i = 0; i < node->params.size(); ++i)
        std::visit([&](const auto& value) { out[node->type().params[i].name] = value; }, node->params[i]);
    return out;
}

OrderedJson passes_with_costs(const Plan& plan, const CheckedPipeline& pipeline,
                              std::span<const FrameCost> costs) {
    OrderedJson passes = passes_json(plan);
    const std::vector<bool> mask = passes_of_mask(plan);
    for (size_t p = 0; p < plan.passes.size(); ++p) {
        passes[p]["mask"] = bool{mask[p]};
        passes[p]["params"] = params_json(pipeline, plan.passes[p].node);
        const Samples ms = collect(costs, [&](const FrameCost& c) { return c.passes[p].ms; });
        const Samples cpu = collect(costs, [&](const FrameCost& c) { return c.pass_cpu_ms[p]; });
        passes[p]["ms"] = {{"median", median(ms)}, {"p95", quantile(ms, 0.95)}};
        passes[p]["cpu_ms"] = {{"median", median(cpu)}};
        OrderedJson counters = OrderedJson::object();
        for (size_t i = 0; i < plan.passes[p].counters.size(); ++i)
            counters[plan.passes[p].counters[i]] = median_count(collect(
                costs, [&](const FrameCost& c) { return std::optional<double>(c.passes[p].counters[i]); }));
        passes[p]["counters"] = counters;
    }
    return passes;
}

OrderedJson counts(const Plan& plan, const OrderedJson& passes) {
    const uint64_t tiles = uint64_t{(plan.extent.width + 7) / 8} * ((plan.extent.height + 3) / 4);
    OrderedJson out = {{"pixels", uint64_t{plan.extent.width} * plan.extent.height}};
    const auto counted = [&](const char* name) {
        OrderedJson sum;
        for (const OrderedJson& pass : passes)
            if (const auto it = pass["counters"].find(name); it != pass["counters"].end() && !it->is_null())
                sum = (sum.is_null() ? 0 : sum.get<uint64_t>()) + it->get<uint64_t>();
        return sum;
    };
    // Passes that decide one after the other leave open what the last of them leaves open.
    const auto left = [&](const char* name) {
        OrderedJson last;
        for (const OrderedJson& pass : passes)
            if (const auto it = pass["counters"].find(name); it != pass["counters"].end()) last = *it;
        return last;
    };
    for (const char* name : {"receivers", "lit", "shadowed"}) out[name] = counted(name);
    out["unknown"] = left("unknown");
    out["tiles"] = tiles;
    out["tiles_listed"] = left("tiles_listed");
    out["rays"] = counted("rays");
    out["penumbra_pixels"] = nullptr;  // known to the reference alone
    return out;
}

// Every frame that was executed, the first ones included.
OrderedJson by_frame_json(const Session& session, const RenderedFrames& rendered) {
    const Plan& plan = session.plan();
    const std::vector<bool> mask = passes_of_mask(plan);
    OrderedJson frames = OrderedJson::array();
    for (const FrameCost& cost : rendered.costs) {
        const uint32_t frame = rendered.start + static_cast<uint32_t>(frames.size());
        std::optional<double> mask_cpu_ms = 0;
        OrderedJson counted = {{"receivers", nullptr}, {"sunward", nullptr}, {"rays", nullptr}};
        for (size_t p = 0; p < plan.passes.size(); ++p) {
            if (mask[p])
                mask_cpu_ms = mask_cpu_ms && cost.pass_cpu_ms[p]
                                  ? std::optional(*mask_cpu_ms + *cost.pass_cpu_ms[p])
                                  : std::nullopt;
            for (size_t i = 0; i < plan.passes[p].counters.size(); ++i)
                if (const auto sum = counted.find(plan.passes[p].counters[i]); sum != counted.end())
                    *sum = (sum->is_null() ? 0 : sum->get<uint64_t>()) + cost.passes[p].counters[i];
        }
        frames.push_back({{"frame", frame},
                          {"reset", frames.empty() || session.host().cut(frame)},
                          {"jitter", session.host().jitter(frame)},
                          {"ms", cost.ms ? OrderedJson(*cost.ms) : OrderedJson()},
                          {"cpu_ms", cost.cpu_ms},
                          {"mask_cpu_ms", mask_cpu_ms ? OrderedJson(*mask_cpu_ms) : OrderedJson()},
                          {"receivers", counted["receivers"]},
                          {"sunward", counted["sunward"]},
                          {"rays", counted["rays"]}});
    }
    return frames;
}

// The sun's shadow maps, which the host draws before the graph's passes; null where the pipeline reads none.
OrderedJson cascades_json(const Session& session, std::array<uint32_t, 2> frames,
                          std::span<const FrameCost> costs) {
    if (!session.cascade_maps()) return nullptr;
    const CascadeFit fit = session.host().cascade_fit(frames[1]);
    OrderedJson texels = OrderedJson::array();
    for (uint32_t i = 0; i < fit.count; ++i) texels.push_back(fit.areas[i].texel_m);
    const auto cpu = [&](bool drawn) {
        return median(collect(costs, [&](const FrameCost& c) {
            return (c.cascades_drawn > 0) == drawn ? c.cascades_cpu_ms : std::nullopt;
        }));
    };
    return {
        {"size", fit.size},
        {"texel_m", texels},
        {"drawn_share",
         costs.empty() ? OrderedJson()
                       : OrderedJson(double(std::ranges::count_if(
                                         costs, [](const FrameCost& c) { return c.cascades_drawn > 0; })) /
                                     double(costs.size()))},
        {"cpu_ms", {{"drawn", cpu(true)}, {"kept", cpu(false)}}}};
}

// {"nodes.filter0.params.step": 2}, the last setting of a path wins.
OrderedJson settings_json(const std::vector<std::string>& settings) {
    OrderedJson out = OrderedJson::object();
    for (const std::string& setting : settings) {
        const size_t at = setting.find('=');
        const std::string value = setting.substr(at + 1);
        const OrderedJson parsed = OrderedJson::parse(value, nullptr, false);
        out[setting.substr(0, at)] = parsed.is_discarded() ? OrderedJson(value) : parsed;
    }
    return out;
}

// Which of the shot's lights the pipeline's one mask is of; null where it has none, or one of each of
// several.
OrderedJson light_json(const Session& session, const CheckedPipeline& pipeline) {
    const StandaloneHost& host = session.host();
    const bool of_one = pipeline.input("light") || (pipeline.input("sun") && host.shot().has_sun);
    return of_one ? OrderedJson(host.light_name()) : OrderedJson();
}

OrderedJson outputs_json(const OutputWriter& outputs) {
    OrderedJson list = OrderedJson::array();
    for (const WrittenOutput& o : outputs.written())
        list.push_back({{"resource", o.resource},
                        {"frame", o.frame},
                        {"file", o.file},
                        {"channels", o.channels},
                        {"min", o.min},
                        {"max", o.max},
                        {"nonfinite", o.nonfinite},
                        {"hash", fmt::format("{:016x}", o.hash)}});
    return list;
}

std::string number(const OrderedJson& value) {
    return value.is_null() ? "-" : fmt::format("{:.3f}", value.get<double>());
}

}  // namespace

OrderedJson render_report(const RenderArguments& arguments, const Session& session,
                          const CheckedPipeline& pipeline, const DeviceInfo& device,
                          const RenderedFrames& rendered, const std::vector<Finding>& findings,
                          const OutputWriter& outputs, const std::vector<std::string>& warnings,
                          const std::filesystem::path& shot_file) {
    const Plan& plan = session.plan();
    const auto warm = warmed_up(rendered.costs);
    const Samples ms = collect(warm, [](const FrameCost& c) { return c.ms; });
    const Samples cpu = collect(warm, [](const FrameCost& c) { return std::optional<double>(c.cpu_ms); });
    const OrderedJson passes = passes_with_costs(plan, pipeline, warm);
    OrderedJson of_device = device_json(device);
    of_device["api"] = fmt::format("{}.{}", VK_API_VERSION_MAJOR(device.api_version),
                                   VK_API_VERSION_MINOR(device.api_version));
    of_device["subgroup"] = device.subgroup_size;
    return {{"penumbra", 1},
            {"version", PENUMBRA_VERSION},
            {"pipeline", plan.pipeline},
            {"shot", session.host().shot().name},
            {"shot_file", shot_file.generic_string()},
            {"light", light_json(session, pipeline)},
            {"seed", session.seed()},
            {"size", {plan.extent.width, plan.extent.height}},
            {"frames", rendered.wanted},
            {"settings", settings_json(arguments.settings)},
            {"captures", arguments.captures},
            {"device", of_device},
            {"facts", facts_json(plan)},
            {"frame_ms", {{"median", median(ms)}, {"p95", quantile(ms, 0.95)}, {"min", quantile(ms, 0)}}},
            {"cpu_ms", {{"median", median(cpu)}, {"p95", quantile(cpu, 0.95)}}},
            {"cascades", cascades_json(session, rendered.wanted, warm)},
            {"passes", passes},
            {"culled", culled_json(plan)},
            {"memory", memory_json(plan)},
            {"counts", counts(plan, passes)},
            {"by_frame", by_frame_json(session, rendered)},
            {"validate", findings_json(plan, findings)},
            {"warnings", warnings},  // about the scene: what of it is not shown as its file says
            {"outputs", outputs_json(outputs)}};
}

void print_summary(const OrderedJson& report) {
    fmt::print("{} on {} at {}x{}, {} ({})\n", report["pipeline"].get<std::string>(),
               report["shot"].get<std::string>(), report["size"][0].get<uint32_t>(),
               report["size"][1].get<uint32_t>(), report["device"]["name"].get<std::string>(),
               report["device"]["driver"].get<std::string>());
    fmt::print("  {:<12} {:>10} {:>10}\n", "pass", "ms", "cpu ms");
    for (const OrderedJson& pass : report["passes"])
        if (pass["type"] != "capture" && pass["type"] != "validate")
            fmt::print("  {:<12} {:>10} {:>10}\n", pass["node"].get<std::string>(),
                       number(pass["ms"]["median"]), number(pass["cpu_ms"]["median"]));
    fmt::print("  {:<12} {:>10} {:>10}\n", "frame", number(report["frame_ms"]["median"]),
               number(report["cpu_ms"]["median"]));
    const auto memory = [&](const char* key) { return mebibytes(report["memory"][key].get<uint64_t>()); };
    fmt::print("  heap {}   live bound {}   unaliased {}\n", memory("heap_bytes"), memory("live_bound_bytes"),
               memory("unaliased_bytes"));
    const OrderedJson& counts = report["counts"];
    fmt::print("  pixels {}   receivers {}   rays {}\n", counts["pixels"].dump(), counts["receivers"].dump(),
               counts["rays"].dump());
}

}  // namespace penumbra
