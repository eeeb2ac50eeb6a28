// SPDX-License-Identifier: MIT
// Selected nodes to passes: resources with formats, extents and lifetimes on the circle of two frames,
// offsets from the packer, constants and dispatch sizes, then the dependencies.
#include <fmt/format.h>

#include <set>

#include "graph/barriers.h"
#include "graph/compiler.h"
#include "graph/lifetimes.h"

namespace penumbra {

std::optional<Plan> Compiler::run() {
    plan_.pipeline = pipeline_.name;
    plan_.extent = target_.extent;
    for (const char* fact : fact_names) {
        const auto given = target_.facts.find(fact);
        plan_.facts[fact] = given == target_.facts.end() || given->second;
    }
    plan_.device = target_.device.name;
    plan_.cpu = target_.device.cpu;
    plan_.aliased = options_.alias;
    plan_.poison = options_.poison;
    const size_t errors = diagnostics_.size();
    if (target_.extent.width == 0 || target_.extent.height == 0)
        error({pipeline_.file}, "", "the frame's extent is empty");
    auto selection =
        select(pipeline_, nodes_, plan_.facts, target_.left_out, options_.captures, diagnostics_);
    if (!selection) return std::nullopt;
    plan_.culled = std::move(selection->culled);
    inputs_ = resolve_inputs(pipeline_, *selection, target_, diagnostics_);
    if (diagnostics_.size() != errors) return std::nullopt;
    for (const SelectedNode& node : selection->nodes) lower(node);
    if (diagnostics_.size() != errors) return std::nullopt;
    finish_resources();
    if (diagnostics_.size() != errors) return std::nullopt;
    place_memory(plan_, target_.device, options_.optimum_search_nodes);
    place_barriers(plan_, options_.output_use);
    return std::move(plan_);
}

void Compiler::error(const Place& place, const std::string& path, const std::string& message) {
    diagnostics_.add(place, path, message);
}

void Compiler::lower(const SelectedNode& selected) {
    plan_.passes.emplace_back();
    if (!selected.node) return lower_capture(selected);
    const BoundNode& node = *selected.node;
    PlanPass& pass = plan_.passes.back();
    pass.node = node.id;
    pass.entry = nodes_.find(node.type->name);
    pass.kind = node.type->host ? PassKind::host : PassKind::compute;
    check_needs(node);
    choose_backend(node);
    pass.variant.alpha = traces_scene(*node.type) && plan_.facts.at("alpha");
    bindings_ = port_bindings(*node.type);
    for (size_t i = 0; i < selected.ports.size(); ++i)
        if (!selected.ports[i].bound->port->output) bind_input(node, selected.ports[i], bindings_[i]);
    for (size_t i = 0; i < selected.ports.size(); ++i)
        if (selected.ports[i].bound->port->output)
            bind_output(node, selected, selected.ports[i], bindings_[i]);
    choose_variant(node, selected);
    fill_constants(node);
    fill_dispatch(node, selected);
    for (const std::string& counter : node.type->counters) plan_.counters.push_back(node.id + "." + counter);
}

void Compiler::lower_capture(const SelectedNode& selected) {
    PlanPass& pass = plan_.passes.back();
    pass.kind = PassKind::capture;
    pass.node = selected.capture;
    const uint32_t resource = internal_.at(selected.capture);
    pass.uses.push_back(
        {resource, false, {VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT, false}});
    pass.bindings.push_back({nullptr, 0, false, resource, false, selected.capture});
    pass.reads.push_back(selected.capture);
    plan_.resources[resource].image_usage |= VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    plan_.resources[resource].buffer_usage |= VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
}

void Compiler::check_needs(const BoundNode& node) {
    for (const std::string& need : node.type->needs) {
        if (need == "jitter") plan_.jitter = true;
        if ((need == "ray_query" && !target_.device.ray_query) ||
            (need == "storage8" && !target_.device.storage8))
            error(node.place, "nodes." + node.id,
                  fmt::format("the device \"{}\" lacks {}", plan_.device, need));
    }
}

void Compiler::finish_resources() {
    for (const Late& late : late_) {
        PlanBinding& binding = plan_.passes[late.pass].bindings[late.binding];
        binding.index = internal_.at(late.resource);
        use_input(plan_.passes[late.pass], *binding.port, binding.index, true);
    }
    for (const std::string& name : pipeline_.outputs) {
        const uint32_t resource = internal_.at(name);
        plan_.resources[resource].output = true;
        plan_.outputs.push_back({name, resource});
    }
    size_t compute_pass = 0;
    std::set<std::pair<const NodeEntry*, std::string>> missing;  // each is reported once
    for (PlanPass& pass : plan_.passes) {
        if (pass.kind == PassKind::capture) continue;
        for (const FormatChoice& choice : choices_[compute_pass])
            pass.variant.formats[choice.port->name] =
                choice.source == Source::internal ? plan_.resources[internal_.at(choice.resource)].format
                                                  : choice.port->formats.front();
        ++compute_pass;
        if (pass.kind != PassKind::compute || (pass.entry->shaders.empty() && !pass.entry->supplier))
            continue;
        const size_t errors = diagnostics_.size();
        const std::pair variant(pass.entry, to_string(pass.variant));
        if (missing.contains(variant) || find_shader(*pass.entry, pass.variant, diagnostics_)) continue;
        missing.insert(variant);
        if (diagnostics_.size() == errors)
            error({pipeline_.file}, "nodes." + pass.node,
                  fmt::format("no shader was compiled for its variant \"{}\"", variant.second));
    }
    place_lifetimes(plan_);
}

const PlanOutput* Plan::output(std::string_view name) const {
    for (const PlanOutput& o : outputs)
        if (o.name == name) return &o;
    return nullptr;
}

std::optional<Plan> compile(const CheckedPipeline& pipeline, const NodeSet& nodes, const Target& target,
                            const CompileOptions& options, Diagnostics& diagnostics) {
    return Compiler(pipeline, nodes, target, options, diagnostics).run();
}

}  // namespace penumbra
