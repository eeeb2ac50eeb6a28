// SPDX-License-Identifier: MIT
// Unknown values are null, never absent.
#include "app/plan_json.h"

#include <nlohmann/json.hpp>

namespace penumbra {

using OrderedJson = nlohmann::ordered_json;

namespace {

OrderedJson groups_json(const PlanPass& pass) {
    if (pass.kind != PassKind::compute) return nullptr;
    if (pass.indirect) return "indirect";
    return pass.groups;
}

}  // namespace

OrderedJson passes_json(const Plan& plan) {
    OrderedJson passes = OrderedJson::array();
    for (const PlanPass& pass : plan.passes)
        passes.push_back({{"node", pass.node},
                          {"type", pass.type},
                          {"groups", groups_json(pass)},
                          {"backend", pass.backends.empty() ? OrderedJson() : OrderedJson(pass.backends)},
                          {"reads", pass.reads},
                          {"writes", pass.writes}});
    return passes;
}

OrderedJson culled_json(const Plan& plan) {
    OrderedJson culled = OrderedJson::array();
    for (const Culled& c : plan.culled)
        culled.push_back({{"node", c.node},
                          {"why", c.why},
                          {"cond", c.cond.empty() ? OrderedJson() : OrderedJson(c.cond)}});
    return culled;
}

OrderedJson facts_json(const Plan& plan) {
    OrderedJson facts = OrderedJson::object();
    for (const auto& [name, value] : plan.facts) facts[name] = value;
    return facts;
}

OrderedJson memory_json(const Plan& plan) {
    const MemoryReport& m = plan.memory;
    OrderedJson heaps = OrderedJson::array(), resources = OrderedJson::array();
    for (const Heap& heap : plan.heaps) heaps.push_back({{"type", heap.type}, {"bytes", heap.bytes}});
    for (const PlanResource& r : plan.resources)
        resources.push_back({{"name", r.names.back()},
                             {"bytes", r.bytes},
                             {"first_pass", r.first_pass},
                             {"length", r.length},
                             {"offset", r.offset},
                             {"history", r.history}});
    const double pixels = static_cast<double>(plan.extent.width) * plan.extent.height;
    return {{"heap_bytes", m.heap_bytes},
            {"live_bound_bytes", m.live_bound_bytes},
            {"optimum_bytes", m.optimum_bytes ? OrderedJson(*m.optimum_bytes) : OrderedJson()},
            {"unaliased_bytes", m.unaliased_bytes},
            {"dedicated_history_bytes", m.dedicated_history_bytes},
            {"persistent_bytes", m.persistent_bytes},
            {"bytes_per_pixel", static_cast<double>(m.heap_bytes) / pixels},
            {"heaps", heaps},
            {"resources", resources}};
}

OrderedJson to_json(const Plan& plan) {
    return {{"pipeline", plan.pipeline},   {"size", {plan.extent.width, plan.extent.height}},
            {"device", plan.device},       {"facts", facts_json(plan)},
            {"passes", passes_json(plan)}, {"culled", culled_json(plan)},
            {"memory", memory_json(plan)}};
}

}  // namespace penumbra
