// SPDX-License-Identifier: MIT
// Pipelines and declarations; and pipelines that ship, changed (changed_pipeline.h).
#include <stdexcept>

#include "penumbra/graph.h"
#include "penumbra/shadow_nodes.h"
#include "tests/fuzz/changed_pipeline.h"
#include "tests/fuzz/targets.h"
#include "tests/plan_checks.h"

namespace penumbra::test {
namespace {

const NodeSet& nodes() {
    static const NodeSet set = shadow_nodes();
    return set;
}

std::string_view text_of(Bytes bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Every phase either succeeds or says why not, and a plan is sound.
void run_pipeline(std::string_view text) {
    Diagnostics diagnostics;
    const auto pipeline = parse_pipeline(text, "p.json", {}, diagnostics);
    promise(pipeline.has_value() == diagnostics.empty(), "the reader: " + diagnostics.text());
    if (!pipeline) return;
    const auto checked = check(*pipeline, nodes(), diagnostics);
    promise(checked.has_value() == diagnostics.empty(), "check: " + diagnostics.text());
    if (!checked) return;
    Target target;
    target.extent = {64, 36};
    target.device = reference_device();
    const auto plan = compile(*checked, target, {}, diagnostics);
    promise(plan.has_value() == diagnostics.empty(), "compile: " + diagnostics.text());
    if (!plan || plan->passes.size() > 40) return;  // the checks below are quadratic, and plain
    for (const auto& errors : {overlap_errors(*plan), hazard_errors(*plan, 1)})
        promise(errors.empty(), "the plan: " + (errors.empty() ? "" : errors.front()));
}

}  // namespace

void fuzz_pipeline(Bytes bytes) {
    run_pipeline(text_of(bytes));
}

void fuzz_mutant(Bytes bytes) {
    run_pipeline(changed_pipeline(bytes));
}

void fuzz_declaration(Bytes bytes) {
    Diagnostics diagnostics;
    const auto json = parse_json(text_of(bytes), "n.json", diagnostics);
    promise(json.has_value() == diagnostics.empty(), "the reader: " + diagnostics.text());
    if (!json) return;
    const auto type = parse_node_type(*json, "n", nodes().domain(), diagnostics);
    promise(type.has_value() == diagnostics.empty(), "the declaration: " + diagnostics.text());
}

}  // namespace penumbra::test
