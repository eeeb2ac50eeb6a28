// SPDX-License-Identifier: MIT
// Ports to what a shader binds: host slots, resources of this frame or the last, tables, or nothing that is
// read; and how a pass uses each resource.
#include <fmt/format.h>

#include <algorithm>

#include "graph/compiler.h"

namespace penumbra {

namespace {

VkDescriptorType descriptor_type(PortKind kind, bool storage, bool output) {
    switch (kind) {
        case PortKind::image:
            return storage ? VK_DESCRIPTOR_TYPE_STORAGE_IMAGE : VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
        case PortKind::texels:
            return output    ? VK_DESCRIPTOR_TYPE_STORAGE_BUFFER
                   : storage ? VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER
                             : VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
        case PortKind::block:
            return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
        case PortKind::structure:
            return VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR;
        default:
            return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    }
}

PlanBinding binding_of(const Port& port, uint32_t binding) {
    PlanBinding b{.binding = binding, .type = descriptor_type(port.kind, port.storage, port.output)};
    b.linear = port.linear;
    b.layered = port.layers;
    if (!port.formats.empty()) b.format = port.formats.front();
    b.port = port.name;
    b.output = port.output;
    return b;
}

// A host node's callback may do anything with what it reads.
Use input_use(const PlanPass& pass, const Port& port) {
    if (pass.kind == PassKind::host)
        return {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_READ_BIT, false};
    Use use{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_READ_BIT, false};
    if ((port.kind == PortKind::image || port.kind == PortKind::texels) && !port.storage)
        use.access = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT;
    if (port.indirect) {
        use.stages |= VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT;
        use.access |= VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT;
    }
    return use;
}

// As the kind of a slot has it, which of a bundle's parts is not the port's.
VkAccessFlags2 slot_access(PortKind kind, VkAccessFlags2 access) {
    if (kind == PortKind::block) return VK_ACCESS_2_UNIFORM_READ_BIT;
    if (kind == PortKind::structure) return VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR;
    return access;
}

Use output_use(const PlanPass& pass, const Port& port) {
    if (pass.kind == PassKind::host)
        return {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT, true};
    Use use{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, true};
    if (port.updated_input || port.kind == PortKind::buffer ||
        port.levels)  // the value before, atomics, the finer level
        use.access |= VK_ACCESS_2_SHADER_STORAGE_READ_BIT;
    return use;
}

}  // namespace

void Compiler::bind(const SelectedNode& selected) {
    const BoundNode& node = *selected.node;
    PlanPass& pass = plan_.passes.back();
    if (pass.kind == PassKind::compute) {
        pass.bindings.push_back({.set = 1,
                                 .binding = frame_binding,
                                 .type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
                                 .source = BindingSource::frame_block});
        if (!pass.counters.empty())
            pass.bindings.push_back(
                {.set = 1, .binding = counters_binding, .source = BindingSource::counters});
    }
    const std::vector<uint32_t> bindings = port_bindings(node.type());
    for (uint32_t i = 0; i < bindings.size(); ++i)
        if (!node.ports[i].port->output) bind_input(selected, i, bindings[i]);
    for (uint32_t i = 0; i < bindings.size(); ++i)
        if (node.ports[i].port->output && selected.sources[i] != Source::none)
            bind_output(selected, i, bindings[i]);
    if (pass.kind == PassKind::compute) bind_tables(node);
}

void Compiler::bind_input(const SelectedNode& selected, uint32_t index, uint32_t binding) {
    const BoundNode& node = *selected.node;
    const BoundPort& bound = node.ports[index];
    const Port& port = *bound.port;
    const Source source = selected.sources[index];
    if (source != Source::none) plan_.passes.back().reads.push_back(pipeline_.name_of(bound));
    if (port.updater) return;  // bound and used through the output
    if (port.bundle) return bind_bundle(node, bound, binding, source != Source::none);
    if (source == Source::none) return bind_nothing(node.type(), port, binding);
    if (source == Source::internal) {
        const uint32_t resource = made_[bound.resource].resource;
        bind_resource(port, resource, bound.previous, binding);
        return use_input(port, resource, bound.previous);
    }
    const uint32_t input = *pipeline_.resources[bound.resource].input;
    HostSlot slot{
        .name = pipeline_.name_of(bound),
        .input = pipeline_.inputs[input].name,
        .previous = bound.previous,
        .kind = port.kind,
        .format = inputs_[input].format,
        .extent = inputs_[input].extent,
        .layers = inputs_[input].layers,
        .layered = port.layers,
        .follows = port.kind == PortKind::image ? follows_of(pipeline_.inputs[input]) : std::nullopt,
        .element = port.element};
    bind_slot(node, port, std::move(slot), binding);
}

void Compiler::bind_resource(const Port& port, uint32_t resource, bool previous, uint32_t binding) {
    PlanPass& pass = plan_.passes.back();
    PlanBinding b = binding_of(port, binding);
    b.index = resource;
    b.previous = previous;
    b.format = plan_.resources[resource].format;
    if (plan_.resources[resource].slot) b.set = 1;  // another image every frame
    if (port.output && port.levels) b.level = PlanBinding::Level::written;
    pass.bindings.push_back(b);
    if (b.level != PlanBinding::Level::written) return;
    b.level = PlanBinding::Level::finer;
    ++b.binding;
    pass.bindings.push_back(b);
}

void Compiler::bind_nothing(const NodeType& type, const Port& port, uint32_t binding) {
    PlanBinding b = binding_of(port, binding);
    b.source = BindingSource::nothing;
    if (port.kind == PortKind::block) {
        b.set = 1;
        b.binding = absent_block_binding(type, binding);
    }
    if (const auto chosen = variant_.formats.find(port.name); chosen != variant_.formats.end())
        b.format = chosen->second;
    if (plan_.passes.back().kind == PassKind::compute) plan_.passes.back().bindings.push_back(b);
}

void Compiler::bind_slot(const BoundNode& node, const Port& port, HostSlot slot, uint32_t binding) {
    PlanBinding b = binding_of(port, binding);
    b.set = 1;
    b.source = BindingSource::host;
    b.type = descriptor_type(slot.kind, slot.kind == PortKind::texels && port.storage, false);
    if (slot.kind == PortKind::buffer) b.type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    b.format = slot.format;
    const auto same = std::ranges::find_if(plan_.slots, [&](const HostSlot& s) {
        return s.input == slot.input && s.part == slot.part && s.previous == slot.previous &&
               s.kind == slot.kind;
    });
    b.index = static_cast<uint32_t>(same - plan_.slots.begin());
    plan_.passes.back().bindings.push_back(b);
    if (same == plan_.slots.end()) {
        const auto known = pipeline_.domain->structs.find(slot.element);
        if (known != pipeline_.domain->structs.end()) slot.bytes = known->second;
        const HostInput& input = *pipeline_.input(slot.input);
        slot.required = !input.optional;
        if (slot.kind == PortKind::image || slot.kind == PortKind::texels)
            slot.accepted = input.format ? std::vector{*input.format} : port.formats;
        plan_.slots.push_back(std::move(slot));
    }
    HostSlot& made = plan_.slots[b.index];
    std::erase_if(made.accepted,
                  [&](Format f) { return std::ranges::find(port.formats, f) == port.formats.end(); });
    const Use use = input_use(plan_.passes.back(), port);
    made.use.stages |= use.stages;
    made.use.access |= slot_access(made.kind, use.access);
    std::vector<std::string>& readers = made.readers;
    if (readers.empty() || readers.back() != node.id) readers.push_back(node.id);
}

bool Compiler::exists(const Bundle::Part& part) const {
    if (!part.fact.empty() && !plan_.facts.at(part.fact)) return false;
    const bool many = target_.device.max_texel_elements >= large_texel_buffer;
    switch (part.on) {
        case Bundle::Texels::few:
            return !many;
        case Bundle::Texels::fetched:
            return many && !target_.device.loads_texels;
        case Bundle::Texels::loaded:
            return many && target_.device.loads_texels;
        default:
            return true;
    }
}

void Compiler::bind_bundle(const BoundNode& node, const BoundPort& bound, uint32_t binding, bool present) {
    const Port& port = *bound.port;
    const Bundle& bundle = *port.bundle;
    const std::string& backend = backend_of(variant_, bundle).name;
    for (const Bundle::Part& part : bundle.parts) {
        const uint32_t at = binding++;
        if (!part.backend.empty() && part.backend != backend) continue;
        Port shape = port;  // a port of the part's own kind
        shape.kind = part.kind;
        shape.formats = {part.format};
        shape.storage = part.on == Bundle::Texels::loaded;
        if (!present || !exists(part)) {
            bind_nothing(node.type(), shape, at);
            continue;
        }
        const std::string& input = pipeline_.inputs[*pipeline_.resources[bound.resource].input].name;
        HostSlot slot{.name = part.name.empty() ? input : fmt::format("{}.{}", input, part.slot_name()),
                      .input = input,
                      .part = part.slot_name(),
                      .kind = part.kind,
                      .format = part.format,
                      .extent = target_.extent,
                      .element = part.element};
        bind_slot(node, shape, std::move(slot), at);
    }
}

void Compiler::bind_tables(const BoundNode& node) {
    uint32_t binding = first_table_binding(node.type());
    for (size_t t = 0; t < node.type().tables.size(); ++t) {
        const Table& table = node.type().tables[t];
        PlanBinding b{.binding = binding++,
                      .type = table.storage ? VK_DESCRIPTOR_TYPE_STORAGE_IMAGE
                                            : VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                      .source = BindingSource::table,
                      .format = table.format,
                      .port = table.name};
        if (!node.tables[t][facts_]) {
            b.source = BindingSource::nothing;
        } else {
            const std::string full = node.type().name + "/" + table.name;
            const auto same = std::ranges::find(plan_.tables, full, &PlanTable::name);
            b.index = static_cast<uint32_t>(same - plan_.tables.begin());
            if (same == plan_.tables.end()) {
                const std::vector<TableData>& all = node.entry->tables;
                const auto data = std::ranges::find(all, table.name, &TableData::name);
                const size_t bytes = size_t{table.extent[0]} * table.extent[1] * info(table.format).bytes;
                if (data != all.end() && data->texels.size() == bytes)
                    plan_.tables.push_back(
                        {full, table.format, table.extent, table.storage, {node.entry, &data->texels}});
                else if (!node.entry->shaders.empty() || node.entry->supplier)
                    error(node.place, "nodes." + node.id,
                          fmt::format("table {} does not hold {} bytes", full, bytes));
            }
        }
        plan_.passes.back().bindings.push_back(b);
    }
}

void Compiler::use_input(const Port& port, uint32_t resource, bool previous) {
    PlanPass& pass = plan_.passes.back();
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
    if (r.slot) plan_.slots[*r.slot].use.stages |= pass.uses.back().use.stages;
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
                  fmt::format("{} texels exceed the device's largest texel buffer, {}, by {}", r.count,
                              device.max_texel_elements, r.count - device.max_texel_elements));
    } else if (port.kind == PortKind::image && !port.storage) {
        lacks(VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT, "sample");
        if (port.linear) lacks(VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT, "filter");
    }
}

void Compiler::bind_output(const SelectedNode& selected, uint32_t index, uint32_t binding) {
    const BoundPort& bound = selected.node->ports[index];
    const Port& port = *bound.port;
    PlanPass& pass = plan_.passes.back();
    const uint32_t resource = made_[bound.resource].resource;
    PlanResource& r = plan_.resources[resource];
    if (port.writes == Writes::some && !port.updated_input) pass.clears.push_back(resource);
    if (pass.kind == PassKind::host) {
        r.image_usage |= VK_IMAGE_USAGE_TRANSFER_DST_BIT;
        r.buffer_usage |= VK_BUFFER_USAGE_TRANSFER_DST_BIT;
        if (r.kind == PortKind::image &&
            target_.device.supports(r.format, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT))
            r.image_usage |= VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;  // a callback may draw
    }
    bind_resource(port, resource, false, binding);
    if (pass.kind == PassKind::host && port.updated_input) {  // a callback asks for either by its name
        pass.bindings.push_back(pass.bindings.back());
        pass.bindings.back().port = selected.node->type().ports[*port.updated_input].name;
        pass.bindings.back().output = false;
    }
    if (variant_.rows && port.in_rows)  // the graph's own: what is put out is the image
        pass.bindings.push_back(
            {.binding = binding + 1, .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .index = resource});
    pass.uses.push_back({resource, false, output_use(pass, port)});
    if (r.slot) {
        HostSlot& slot = plan_.slots[*r.slot];
        slot.readers.push_back(pass.node);
        slot.use.stages |= pass.uses.back().use.stages;
        slot.use.access |= pass.uses.back().use.access;
    }
    pass.writes.push_back(name(bound.resource));
}

}  // namespace penumbra
