// SPDX-License-Identifier: MIT
// What a pass is run with: the shader's variant, its constants and push constants, and how many groups.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "graph/compiler.h"

namespace penumbra {

// The rule of `auto`: ray queries of a CPU device are two orders of magnitude slower than the tree in
// compute.
void Compiler::choose_backend(const BoundNode& node) {
    const Param* choice = backend_choice(*node.type);
    if (!choice) return;
    const DeviceTable& device = target_.device;
    std::string& backend = plan_.passes.back().variant.backend;
    backend = std::get<std::string>(value_of(node, *choice));
    if (backend == "auto") backend = device.ray_query && !device.cpu ? "ray_query" : "bvh";
    if (backend == "ray_query" && !device.ray_query)
        error(node.place, fmt::format("nodes.{}.params.{}", node.id, choice->name),
              fmt::format("the device \"{}\" lacks ray_query; \"bvh\" runs everywhere", plan_.device));
}

void Compiler::choose_variant(const BoundNode& node, const SelectedNode& selected) {
    choices_.emplace_back();
    for (const Connection& c : selected.ports) {
        const Port& port = *c.bound->port;
        if (port.optional || !port.condition.empty())
            plan_.passes.back().variant.present[port.name] = c.source != Source::none;
        if (has_format_choice(port)) choices_.back().push_back({&port, c.resource, c.source, node.id});
    }
    for (const Table& table : node.type->tables)
        if (!table.condition.empty())
            plan_.passes.back().variant.present[table.name] =
                holds(table.condition, target_.facts, node.params);
}

const ClassOverrides& Compiler::overrides(const BoundNode& node) const {
    return target_.device.cpu ? node.type->cpu : node.type->gpu;
}

// The pipeline's own value, else the device class's, else the declaration's.
const ParamValue& Compiler::value_of(const BoundNode& node, const Param& param) const {
    const auto set = node.set_by_user.find(param.name);
    const auto override_value = overrides(node).params.find(param.name);
    if ((set == node.set_by_user.end() || !set->second) && override_value != overrides(node).params.end())
        return override_value->second;
    return node.params.at(param.name);
}

void Compiler::fill_constants(const BoundNode& node) {
    PlanPass& pass = plan_.passes.back();
    const Dispatch& dispatch = node.type->dispatch;
    const auto group = overrides(node).group.value_or(dispatch.group);
    const auto per_thread = overrides(node).per_thread.value_or(dispatch.per_thread);
    pass.counter_base = static_cast<uint32_t>(plan_.counters.size());
    pass.constants = {group[0], group[1], group[2], per_thread[0], per_thread[1], pass.counter_base};
    if (group[0] * group[1] * group[2] > target_.device.max_workgroup_invocations)
        error(node.place, "nodes." + node.id, "the workgroup is larger than the device allows");
    const PushConstants layout = push_constants(*node.type);
    pass.push.resize(layout.size);
    for (size_t i = 0; i < node.type->params.size(); ++i) {
        const Param& param = node.type->params[i];
        const bool is_backend = &param == backend_choice(*node.type);
        const std::vector<std::byte> bytes =
            value_bytes(param, is_backend ? ParamValue(pass.variant.backend) : value_of(node, param));
        if (layout.offsets[i]) {
            std::memcpy(pass.push.data() + *layout.offsets[i], bytes.data(), bytes.size());
        } else {
            uint32_t word = 0;
            std::memcpy(&word, bytes.data(), sizeof word);
            pass.constants.push_back(word);
        }
    }
}

uint32_t Compiler::levels_of(const SelectedNode& selected, const Port& chain) const {
    for (const Connection& c : selected.ports)
        if (c.bound->port == &chain) return plan_.resources[internal_.at(c.resource)].levels;
    return 0;
}

void Compiler::fill_dispatch(const BoundNode& node, const SelectedNode& selected) {
    PlanPass& pass = plan_.passes.back();
    const Dispatch& dispatch = node.type->dispatch;
    switch (dispatch.kind) {
        case Dispatch::Kind::host:
            return;
        case Dispatch::Kind::groups:
            pass.groups = dispatch.groups;
            return;
        case Dispatch::Kind::indirect:
            for (const Connection& c : selected.ports)
                if (c.bound->port->name == dispatch.indirect) {
                    if (c.source != Source::internal || c.previous)
                        return error(c.bound->place, "nodes." + node.id,
                                     "dispatch arguments must be written by a node of the same frame");
                    pass.indirect = internal_.at(c.resource);
                    pass.indirect_offset = dispatch.offset;
                    if (dispatch.offset + 12 > plan_.resources[*pass.indirect].buffer_bytes())
                        error(c.bound->place, "nodes." + node.id,
                              fmt::format("\"{}\" is too small for dispatch arguments at byte {}", c.resource,
                                          dispatch.offset));
                }
            return;
        case Dispatch::Kind::over: {
            const auto size = size_named(node, selected, dispatch.over);
            if (!size)
                return error(
                    node.place, "nodes." + node.id,
                    fmt::format("it is dispatched over port \"{}\", which is not bound", dispatch.over));
            const auto groups = [&](uint32_t level) -> std::array<uint32_t, 3> {
                const uint32_t width = std::max(size->extent.width >> level, 1u);
                const uint32_t height = std::max(size->extent.height >> level, 1u);
                return {ceil_div(width, pass.constants[0] * pass.constants[3]),
                        ceil_div(height, pass.constants[1] * pass.constants[4]),
                        ceil_div(size->layers, pass.constants[2])};
            };
            pass.groups = groups(0);
            if (const Port* chain = node.type->levelled_output())
                for (uint32_t level = 0; level < levels_of(selected, *chain); ++level)
                    pass.level_groups.push_back(groups(level));
            if (std::max(pass.groups[0], pass.groups[1]) > 65535)
                error(node.place, "nodes." + node.id, "the dispatch exceeds 65535 groups per axis");
        }
    }
}

}  // namespace penumbra
