// SPDX-License-Identifier: MIT
// Ports to what a shader binds: host slots, resources of this frame or the last, and how a pass uses them.
#include <fmt/format.h>

#include <algorithm>

#include "graph/compiler.h"

namespace penumbra {

Compiler::Size Compiler::size_of(const Connection& c) const {
    if (c.source == Source::host) {
        const HostSlot& slot = *std::find_if(plan_.slots.begin(), plan_.slots.end(),
                                             [&](const HostSlot& s) { return s.name == c.resource; });
        return {slot.extent, slot.layers};
    }
    const PlanResource& r = plan_.resources[internal_.at(c.resource)];
    return {r.extent, r.layers};
}

// The size that a rule's `of` names, seen from one node.
std::optional<Compiler::Size> Compiler::size_named(const BoundNode& node, const SelectedNode& selected,
                                                   const std::string& of) {
    if (of == "frame") return Size{target_.extent, 1};
    for (const Connection& c : selected.ports) {
        if (c.bound->port->name != of || c.source == Source::none) continue;
        if (c.source == Source::host || internal_.contains(c.resource)) return size_of(c);
        error(c.bound->place, fmt::format("nodes.{}.in.{}", node.id, of),
              fmt::format("a size follows \"{}@-1\", whose writer comes later in the frame", c.resource));
        return Size{target_.extent, 1};
    }
    return std::nullopt;
}

void Compiler::bind_input(const BoundNode& node, const Connection& c, uint32_t binding) {
    if (c.source == Source::none) return;
    PlanPass& pass = plan_.passes.back();
    const Port& port = *c.bound->port;
    const bool updated = std::any_of(node.type->ports.begin(), node.type->ports.end(),
                                     [&](const Port& p) { return p.output && p.updates == port.name; });
    pass.reads.push_back(c.previous ? c.bound->resource + "@-1" : c.bound->resource);
    if (c.source == Source::host) {
        for (const uint32_t slot : host_slots(node, c))
            pass.bindings.push_back({&port, binding++, true, slot, c.previous, c.resource});
        return;
    }
    const auto pending = internal_.find(c.resource);
    if (pending == internal_.end()) {  // @-1 of a name that a later pass writes: resolved when it exists
        late_.push_back({plan_.passes.size() - 1, pass.bindings.size(), c.resource});
        pass.bindings.push_back({&port, binding, false, 0, true, c.resource + "@-1"});
        return;
    }
    const uint32_t resource = pending->second;
    if (!updated)
        pass.bindings.push_back(
            {&port, binding, false, resource, c.previous, c.previous ? c.resource + "@-1" : c.resource});
    if (!updated || c.previous) use_input(pass, port, resource, c.previous);
}

void Compiler::use_input(PlanPass& pass, const Port& port, uint32_t resource, bool previous) {
    PlanResource& r = plan_.resources[resource];
    pass.uses.push_back({resource, previous, input_use(pass, port)});
    if (port.indirect) r.buffer_usage |= VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
    if (r.kind == PortKind::image)
        r.image_usage |= port.storage ? VK_IMAGE_USAGE_STORAGE_BIT : VK_IMAGE_USAGE_SAMPLED_BIT;
    else if (port.kind == PortKind::texels)
        r.buffer_usage |= VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
    if (pass.kind == PassKind::host) {
        r.image_usage |= VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
        r.buffer_usage |= VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
    }
    if (previous) r.history = true;
    check_readable(r, port);
}

void Compiler::check_readable(const PlanResource& r, const Port& port) {
    const DeviceTable& device = target_.device;
    const auto lacks = [&](VkFormatFeatureFlags feature, const char* what) {
        if (!device.supports(r.format, feature))
            error({pipeline_.file}, "resources." + r.names.back(),
                  fmt::format("the device \"{}\" cannot {} {}", plan_.device, what, info(r.format).name));
    };
    if (port.kind == PortKind::texels) {
        lacks(VK_FORMAT_FEATURE_UNIFORM_TEXEL_BUFFER_BIT, "read texels of");
        if (r.count > device.max_texel_elements)
            error({pipeline_.file}, "resources." + r.names.back(),
                  fmt::format("{} texels exceed the device's largest texel buffer, {}", r.count,
                              device.max_texel_elements));
    } else if (port.kind == PortKind::image && !port.storage && port.linear) {
        lacks(VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT, "filter");
    }
}

// A host node's callback may do anything with what it reads.
Use Compiler::input_use(const PlanPass& pass, const Port& port) {
    if (pass.kind == PassKind::host)
        return {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_READ_BIT, false};
    Use use{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_READ_BIT, false};
    if ((port.kind == PortKind::image && !port.storage) || port.kind == PortKind::texels)
        use.access = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT;
    if (port.indirect) {
        use.stages |= VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT;
        use.access |= VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT;
    }
    return use;
}

// The slots behind a port's bindings, in their order: one, or those of a scene port's backend.
std::vector<uint32_t> Compiler::host_slots(const BoundNode& node, const Connection& c) {
    const Port& port = *c.bound->port;
    if (port.kind == PortKind::scene) {
        std::vector<uint32_t> slots;
        if (uses_ray_query(plan_.passes.back().variant))
            slots = {slot(node, c.resource + ".tlas", PortKind::scene, Format::r8, c, "")};
        else
            for (const SceneTexels& texels : scene_tree_slots) slots.push_back(scene_texels(node, c, texels));
        if (plan_.passes.back().variant.alpha)
            for (const SceneTexels& texels : scene_alpha_slots)
                slots.push_back(scene_texels(node, c, texels));
        slots.push_back(slot(node, c.resource, PortKind::block, Format::r8, c, "Scene"));
        return slots;
    }
    return {slot(node, c.resource, port.kind, Format::r8, c, port.element)};
}

uint32_t Compiler::scene_texels(const BoundNode& node, const Connection& c, const SceneTexels& texels) {
    return slot(node, fmt::format("{}.{}", c.resource, texels.slot), PortKind::texels, texels.format, c, "");
}

uint32_t Compiler::slot(const BoundNode& node, const std::string& name, PortKind kind, Format format,
                        const Connection& c, const std::string& element) {
    for (uint32_t i = 0; i < plan_.slots.size(); ++i)
        if (plan_.slots[i].name == name) {
            if (plan_.slots[i].readers.back() != node.id) plan_.slots[i].readers.push_back(node.id);
            return i;
        }
    HostSlot s{name, kind, format, target_.extent, 1, element, 0, {node.id}};
    if (const auto brought = inputs_.brought.find(c.bound->resource); brought != inputs_.brought.end()) {
        s.format = brought->second.format;
        s.extent = brought->second.extent;
        s.layers = brought->second.layers;
    }
    if (const auto known = nodes_.structs().find(element); known != nodes_.structs().end())
        s.bytes = known->second;
    plan_.slots.push_back(std::move(s));
    return static_cast<uint32_t>(plan_.slots.size() - 1);
}

void Compiler::bind_output(const BoundNode& node, const SelectedNode& selected, const Connection& c,
                           uint32_t binding) {
    if (c.source == Source::none) return;
    PlanPass& pass = plan_.passes.back();
    const Port& port = *c.bound->port;
    uint32_t resource = 0;
    Use use{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, true};
    if (!port.updates.empty()) {
        const auto in = std::find_if(selected.ports.begin(), selected.ports.end(), [&](const Connection& o) {
            return o.bound->port->name == port.updates;
        });
        resource = internal_.at(in->resource);
        plan_.resources[resource].names.push_back(c.resource);
        if (first_of(port, c.resource) == First::clear) clear_on_reset(plan_.resources[resource]);
        use.access |= VK_ACCESS_2_SHADER_STORAGE_READ_BIT;
    } else {
        resource = static_cast<uint32_t>(plan_.resources.size());
        make_resource(node, selected, c);
        plan_.resources.back().first_pass = static_cast<uint32_t>(plan_.passes.size() - 1);
        if (port.kind == PortKind::buffer || port.levels)  // atomics; the finer level
            use.access |= VK_ACCESS_2_SHADER_STORAGE_READ_BIT;
        if (port.writes == Writes::some) pass.clears.push_back(resource);
    }
    if (pass.kind == PassKind::host) {
        use = {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
               VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT, true};
        plan_.resources[resource].image_usage |= VK_IMAGE_USAGE_TRANSFER_DST_BIT;
        plan_.resources[resource].buffer_usage |= VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    }
    internal_[c.resource] = resource;
    pass.bindings.push_back({&port, binding, false, resource, false, c.resource});
    pass.uses.push_back({resource, false, use});
    pass.writes.push_back(c.resource);
}

}  // namespace penumbra
