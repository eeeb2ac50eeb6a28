// SPDX-License-Identifier: MIT
// What a pass is run with: the shader's variant, its constants and push constants, and how many groups.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "graph/compiler.h"
#include "graph/interface.h"

namespace penumbra {

void Compiler::lower(const SelectedNode& selected) {
    plan_.passes.emplace_back();
    if (!selected.node) return lower_capture(selected.capture);
    const BoundNode& node = *selected.node;
    PlanPass& pass = plan_.passes.back();
    pass.node = node.id;
    pass.type = node.type().name;
    pass.kind = node.type().host ? PassKind::host : PassKind::compute;
    pass.callback = node.entry->callback;
    if (!node.member.empty()) {
        pass.member = members_.at(node.member);
        pass.rests = !node.hands_on;
    }
    pass.counters = node.type().counters;
    pass.counter_base = static_cast<uint32_t>(plan_.counters.size());
    check_needs(node);
    variant_ = {};
    for (size_t i = 0; i < node.ports.size(); ++i) {
        const BoundPort& bound = node.ports[i];
        const Port& port = *bound.port;
        if (has_format_choice(port))
            variant_.formats[port.name] = bound.resource == no_resource
                                              ? port.formats.front()
                                              : pipeline_.resources[bound.resource].format;
        if (is_variant_output(node.type(), port))
            variant_.outputs[port.name] = selected.sources[i] != Source::none;
        if (port.bundle && backend_param(node.type(), *port.bundle)) {
            const std::string& backend = backend_of_port(node, *port.bundle);
            variant_.backends[port.bundle->param] = backend;
            pass.backends += (pass.backends.empty() ? "" : " ") + backend;
        } else if (port.bundle && !port.bundle->backends.empty() && selected.sources[i] != Source::none) {
            check_backend(port.bundle->backends.back(), node.place, "nodes." + node.id);
        }
    }
    if (node.type().by_class) variant_.cpu = target_.device.cpu;
    variant_.rows = lay_in_rows(selected);
    pass.variant = to_string(variant_);
    bind(selected);
    fill_constants(selected);
    fill_dispatch(selected);
    if (pass.kind == PassKind::compute) find_module(selected);
    for (const std::string& counter : node.type().counters) plan_.counters.push_back(node.id + "." + counter);
}

void Compiler::lower_capture(uint32_t captured) {
    PlanPass& pass = plan_.passes.back();
    pass.kind = PassKind::capture;
    pass.type = "capture";
    pass.node = name(captured);
    const uint32_t resource = made_[captured].resource;
    pass.uses.push_back(
        {resource, false, {VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT, false}});
    pass.bindings.push_back({.index = resource});
    if (const auto lent = plan_.resources[resource].slot)
        plan_.slots[*lent].use.stages |= VK_PIPELINE_STAGE_2_COPY_BIT;
    pass.reads.push_back(pass.node);
    plan_.resources[resource].image_usage |= VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    plan_.resources[resource].buffer_usage |= VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
}

void Compiler::check_needs(const BoundNode& node) {
    for (const std::string& need : node.type().needs) {
        if (need == "camera") plan_.camera = true;
        if (need != "jitter" && need != "camera" && !target_.device.features.contains(need))
            error(node.place, "nodes." + node.id,
                  fmt::format("the device \"{}\" lacks {} among its features", plan_.device, need));
    }
}

const std::string& Compiler::backend_of_port(const BoundNode& node, const Bundle& bundle) {
    const DeviceTable& device = target_.device;
    const Param& param = *backend_param(node.type(), bundle);
    const auto& wanted =
        std::get<std::string>(value_of(node, static_cast<size_t>(&param - node.type().params.data())));
    const std::string path = fmt::format("nodes.{}.params.{}", node.id, param.name);
    if (wanted != "auto") {
        for (const Bundle::Backend& backend : bundle.backends)
            if (wanted == backend.name) check_backend(backend, node.place, path);
        return wanted;
    }
    const Bundle::Backend* chosen = nullptr;
    for (const Bundle::Backend& backend : bundle.backends) {
        if (problem_of(backend)) continue;
        if (!(backend.gpu_only && device.cpu)) return backend.name;
        if (!chosen) chosen = &backend;  // better than none
    }
    if (chosen) return chosen->name;
    for (const Bundle::Backend& backend : bundle.backends) check_backend(backend, node.place, path);
    return bundle.backends.back().name;
}

// What keeps a backend from this target.
std::optional<std::string> Compiler::problem_of(const Bundle::Backend& backend) const {
    if (!backend.feature.empty() && !target_.device.features.contains(backend.feature))
        return fmt::format("\"{}\": the device \"{}\" lacks {} among its features", backend.name,
                           plan_.device, backend.feature);
    if (!backend.fact.empty() && !plan_.facts.at(backend.fact))
        return fmt::format("\"{}\": the fact \"{}\" does not hold for this plan", backend.name, backend.fact);
    return std::nullopt;
}

void Compiler::check_backend(const Bundle::Backend& backend, const Place& place, const std::string& path) {
    if (const auto problem = problem_of(backend)) error(place, path, *problem);
}

const ClassOverrides& Compiler::overrides(const BoundNode& node) const {
    return target_.device.cpu ? node.type().cpu : node.type().gpu;
}

// The pipeline's own value, else the device class's, else the declaration's.
const ParamValue& Compiler::value_of(const BoundNode& node, size_t param) const {
    const std::map<std::string, ParamValue>& by_class = overrides(node).params;
    const auto overridden = by_class.find(node.type().params[param].name);
    return node.set[param] || overridden == by_class.end() ? node.params[param] : overridden->second;
}

void Compiler::fill_constants(const SelectedNode& selected) {
    const BoundNode& node = *selected.node;
    const NodeType& type = node.type();
    PlanPass& pass = plan_.passes.back();
    const auto group = overrides(node).group.value_or(type.dispatch.group);
    const auto per_thread = overrides(node).per_thread.value_or(type.dispatch.per_thread);
    pass.constants = {group[0],
                      group[1],
                      group[2],
                      per_thread[0],
                      per_thread[1],
                      target_.device.cpu,
                      target_.device.lanes_in_step};
    const PushConstants layout = push_constants(type);
    pass.push.resize(layout.size);
    pass.mip_level = layout.mip_level;
    if (layout.counter_base)
        std::memcpy(pass.push.data() + *layout.counter_base, &pass.counter_base, sizeof pass.counter_base);
    for (size_t i = 0; i < type.params.size(); ++i) {
        const auto backend = variant_.backends.find(type.params[i].name);
        const std::vector<std::byte> bytes =
            value_bytes(type.params[i],
                        backend != variant_.backends.end() ? ParamValue(backend->second) : value_of(node, i));
        if (layout.offsets[i]) {
            pass.params.push_back({type.params[i], *layout.offsets[i]});
            std::memcpy(pass.push.data() + *layout.offsets[i], bytes.data(), bytes.size());
        } else {
            std::memcpy(&pass.constants.emplace_back(), bytes.data(), sizeof(uint32_t));
        }
    }
    for (const Presence& p : presence(type)) {
        bool there = p.table ? node.tables[*p.table][facts_] : selected.sources[*p.port] != Source::none;
        if (p.part) there = there && exists(type.ports[*p.port].bundle->parts[*p.part]);
        pass.constants.push_back(there);
    }
    for (const uint32_t i : row_outputs(type)) {
        if (!variant_.rows) break;
        const bool there = selected.sources[i] != Source::none;
        const PlanResource* r = there ? &plan_.resources[made_[node.ports[i].resource].resource] : nullptr;
        pass.constants.push_back(r ? static_cast<uint32_t>(r->row_bytes / row_element_bytes(r->format)) : 1);
    }
}

// All of the outputs, or none: one variant of the shader writes rows.
bool Compiler::lay_in_rows(const SelectedNode& selected) {
    const DeviceTable& device = target_.device;
    const BoundNode& node = *selected.node;
    if (!device.row_bytes || node.type().host || variant_.cpu == false) return false;
    std::vector<std::pair<PlanResource*, uint64_t>> rows;
    for (const uint32_t i : row_outputs(node.type())) {
        if (selected.sources[i] == Source::none) continue;
        const uint32_t name_id = node.ports[i].resource;
        PlanResource& r = plan_.resources[made_[name_id].resource];
        if (r.slot || !has_rows(r.format)) return false;
        // Whatever else may be done with it.
        const auto asked = options_.outputs.find(name(name_id));
        const OutputUse use = asked == options_.outputs.end() ? OutputUse{} : asked->second;
        const uint64_t row = device.row_bytes(
            {.format = r.format,
             .extent = r.extent,
             .usage = use.image_usage | VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT |
                      VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
        if (row == 0 || row % row_element_bytes(r.format) != 0 ||
            row * r.extent.height > device.max_storage_bytes)
            return false;
        rows.emplace_back(&r, row);
    }
    for (const auto& [r, row] : rows) r->row_bytes = row;
    return !rows.empty();
}

void Compiler::fill_dispatch(const SelectedNode& selected) {
    const BoundNode& node = *selected.node;
    const Dispatch& dispatch = node.type().dispatch;
    PlanPass& pass = plan_.passes.back();
    switch (dispatch.kind) {
        case Dispatch::Kind::host:
            return;
        case Dispatch::Kind::groups:
            pass.groups = dispatch.groups;
            return;
        case Dispatch::Kind::indirect: {
            const BoundPort& arguments = node.ports[dispatch.indirect_port];
            pass.indirect = made_[arguments.resource].resource;
            pass.indirect_offset = dispatch.offset;
            if (dispatch.offset + 12 > plan_.resources[*pass.indirect].buffer_bytes())
                error(arguments.place, "nodes." + node.id,
                      fmt::format("\"{}\" is too small for dispatch arguments at byte {}",
                                  name(arguments.resource), dispatch.offset));
            return;
        }
        case Dispatch::Kind::over: {
            const Size size = size_of(selected, dispatch.over);
            pass.over = size.follows;
            for (uint32_t axis = 0; axis < 2; ++axis)
                pass.group_pixels[axis] =
                    pass.constants[group_constant + axis] * pass.constants[per_thread_constant + axis];
            const auto groups = [&](uint32_t level) -> std::array<uint32_t, 3> {
                const uint32_t width = std::max(size.extent.width >> level, 1u);
                const uint32_t height = std::max(size.extent.height >> level, 1u);
                return {ceil_div(width, pass.group_pixels[0]), ceil_div(height, pass.group_pixels[1]),
                        ceil_div(size.layers, pass.constants[group_constant + 2])};
            };
            pass.groups = groups(0);
            if (const Port* chain = node.type().levelled_output()) {
                const uint32_t id = node.ports[node.type().index(*chain)].resource;
                for (uint32_t level = 0; level < plan_.resources[made_[id].resource].levels; ++level)
                    pass.level_groups.push_back(groups(level));
            }
        }
    }
}

// Passes of one variant whose ports are wired to the same sets share a module.
void Compiler::find_module(const SelectedNode& selected) {
    const BoundNode& node = *selected.node;
    if (node.entry->shaders.empty() && !node.entry->supplier) return;  // declarations alone, to plan with
    PlanPass& pass = plan_.passes.back();
    std::vector<HostBinding> host;
    std::string key = pass.variant;
    for (const PlanBinding& b : pass.bindings)
        if (b.set == 1) {
            const bool absent = b.source == BindingSource::nothing;
            host.push_back(
                {absent ? b.binding - absent_block_binding(node.type(), 0) : b.binding, b.binding});
            key += fmt::format(" {}", b.binding);
        }
    const auto [at, added] = modules_.try_emplace({node.entry.get(), key});
    if (added) {
        const size_t errors = diagnostics_.size();
        if (const std::vector<uint32_t>* spirv = find_shader(*node.entry, variant_, diagnostics_)) {
            at->second = static_cast<uint32_t>(plan_.modules.size());
            bind_to_sets(plan_.modules.emplace_back(*spirv), host);
        } else if (diagnostics_.size() == errors) {
            error({pipeline_.file}, "nodes." + node.id,
                  fmt::format("no shader was compiled for its variant \"{}\"", pass.variant));
        }
    }
    pass.module = at->second;
}

}  // namespace penumbra
