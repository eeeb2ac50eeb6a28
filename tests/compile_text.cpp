// SPDX-License-Identifier: MIT
#include "tests/compile_text.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/plan_checks.h"
#include "tests/toy_nodes.h"

namespace penumbra::test {

NodeSet small_set() {
    NodeSet set;
    const auto add = [&](const char* name, const std::string& text) {
        set.add({.type = parse_toy(text, name)});
    };
    add("source", R"({ "node": "source", "doc": "d", "shader": "s.comp",
      "outputs": { "value": { "kind": "image", "format": "r16f" },
                   "extra": { "kind": "image", "format": "rgba16f", "optional": true } },
      "params": { "taps": { "type": "int", "default": 4, "constant": true, "doc": "d" },
                  "gain": { "type": "float", "default": 2, "range": [0, 8], "doc": "d" },
                  "axis": { "type": "vec3", "default": [1, 2, 3], "doc": "d" },
                  "on": { "type": "bool", "default": true, "doc": "d" },
                  "shape": { "type": "enum", "values": ["box", "tent"], "default": "tent", "doc": "d" } },
      "dispatch": { "over": "frame", "group": [8, 8] },
      "classes": { "cpu": { "group": [64, 1], "per_thread": [1, 2], "taps": 9 } } })");
    add("mix", R"({ "node": "mix", "doc": "d", "shader": "s.comp",
      "inputs": { "value": { "kind": "image", "format": "r16f" },
                  "before": { "kind": "image", "format": ["r16f", "r32f"], "as": "storage", "previous": true, "optional": true },
                  "mask": { "kind": "image", "format": "r8", "optional": true } },
      "outputs": { "mixed": { "kind": "image", "format": ["r16f", "r8"] } },
      "dispatch": { "over": "value" } })");
    add("twice", R"({ "node": "twice", "doc": "d", "shader": "s.comp",
      "inputs": { "value": { "kind": "image", "format": "r16f", "as": "storage" } },
      "outputs": { "doubled": { "kind": "image", "updates": "value" } },
      "dispatch": { "over": "value" } })");
    add("motion_reader", R"({ "node": "motion_reader", "doc": "d", "shader": "s.comp",
      "inputs": { "motion": { "kind": "image", "format": ["rg16f", "rgba16f", "r16f", "rg8"] },
                  "motion_prev": { "kind": "image", "format": ["rg16f", "rgba16f", "r32f"], "previous": true } },
      "outputs": { "seen": { "kind": "image", "format": "r16f", "extent": "motion" } },
      "dispatch": { "over": "seen" } })");
    add("tally", R"({ "node": "tally", "doc": "d", "shader": "s.comp",
      "outputs": { "kept": { "kind": "image", "format": "r16f", "writes": "kept" } },
      "dispatch": { "over": "kept" } })");
    add("picky", R"({ "node": "picky", "doc": "d", "shader": "s.comp",
      "inputs": { "motion": { "kind": "image", "format": ["rgba16f", "rg16f"] } },
      "outputs": { "picked": { "kind": "image", "format": "r16f" } }, "dispatch": { "over": "frame" } })");
    return set;
}

Target target_of(Extent extent, bool cpu) {
    Target target;
    target.extent = extent;
    target.device = reference_device(cpu);
    return target;
}

CompiledText compile_text(const NodeSet& set, const std::string& body, const Target& target,
                          const CompileOptions& options) {
    Diagnostics diagnostics;
    const std::string text = R"({ "penumbra": 1, "name": "p", )" + body + "}";
    const auto pipeline = parse_pipeline(text, "p.json", {}, diagnostics);
    const auto checked = pipeline ? check(*pipeline, set, diagnostics) : std::nullopt;
    if (!checked) throw std::runtime_error(diagnostics.text());
    CompiledText result;
    result.plan = compile(*checked, target, options, diagnostics);
    result.errors = diagnostics.text();
    return result;
}

const PlanPass& pass_of(const Plan& plan, const std::string& node) {
    for (const PlanPass& pass : plan.passes)
        if (pass.node == node) return pass;
    throw std::runtime_error("no pass " + node);
}

const PlanResource* resource_of(const Plan& plan, const std::string& name) {
    for (const PlanResource& r : plan.resources)
        if (std::find(r.names.begin(), r.names.end(), name) != r.names.end()) return &r;
    return nullptr;
}

bool is_bound(const PlanPass& pass, const std::string& port) {
    const PlanBinding* binding = pass.binding(port);
    return binding && binding->source != BindingSource::nothing;
}

size_t position(const Plan& plan, const std::string& node) {
    return static_cast<size_t>(&pass_of(plan, node) - plan.passes.data());
}

void expect_sound(const Plan& plan) {
    EXPECT_EQ(overlap_errors(plan), std::vector<std::string>{});
    EXPECT_EQ(hazard_errors(plan), std::vector<std::string>{});
}

}  // namespace penumbra::test
