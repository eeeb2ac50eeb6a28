// SPDX-License-Identifier: MIT
#include "app/validation.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace penumbra {
namespace {

using OrderedJson = nlohmann::ordered_json;

TexelCounts counts_of(const std::vector<uint32_t>& counters) {  // nodes/tools/validate.json has their order
    return {counters.at(0), counters.at(1), counters.at(2), counters.at(3)};
}

}  // namespace

std::vector<Finding> no_findings(const Plan& plan) {
    std::vector<Finding> findings;
    for (ValidatePass& pass : validate_passes(plan)) findings.push_back({std::move(pass), {}, {}, {}});
    return findings;
}

void add_frame(std::vector<Finding>& findings, uint32_t frame, const std::vector<PassStatistics>& passes) {
    for (Finding& finding : findings) {
        const TexelCounts counts = counts_of(passes[finding.pass.pass].counters);
        finding.all.checked += counts.checked;
        finding.all.nan += counts.nan;
        finding.all.inf += counts.inf;
        finding.all.out_of_range += counts.out_of_range;
        if (finding.first_frame || counts.bad() == 0) continue;
        finding.first_frame = frame;
        finding.first = counts;
    }
}

std::string complaint(const std::vector<Finding>& findings) {
    std::vector<const Finding*> bad;
    for (const Finding& finding : findings)
        if (finding.first_frame) bad.push_back(&finding);
    std::ranges::stable_sort(bad, {}, [](const Finding* f) { return *f->first_frame; });
    std::string text;
    for (const Finding* f : bad)
        text += fmt::format(
            "{}: frame {}: of {} texels {} NaN, {} infinite, {} out of range ({}, {}, {} in all frames)\n",
            f->pass.origin, *f->first_frame, f->first.checked, f->first.nan, f->first.inf,
            f->first.out_of_range, f->all.nan, f->all.inf, f->all.out_of_range);
    return text;
}

OrderedJson findings_json(const Plan& plan, const std::vector<Finding>& findings) {
    if (findings.empty()) return nullptr;
    OrderedJson out = OrderedJson::object();
    for (const Finding& f : findings) {
        // A resource may be looked at by a node of the pipeline's own too.
        const std::string& key =
            out.contains(f.pass.resource) ? plan.passes[f.pass.pass].node : f.pass.resource;
        out[key] = {{"checked", f.all.checked},
                    {"nan", f.all.nan},
                    {"inf", f.all.inf},
                    {"out_of_range", f.all.out_of_range},
                    {"first_frame", f.first_frame ? OrderedJson(*f.first_frame) : OrderedJson()}};
    }
    for (const PlanPass& pass : plan.passes)
        for (const std::string& name : pass.writes)
            if (!out.contains(name)) out[name] = nullptr;
    return out;
}

}  // namespace penumbra
