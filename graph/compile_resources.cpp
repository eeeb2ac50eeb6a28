// SPDX-License-Identifier: MIT
// Output ports to resources: format, extent or count, what must be clear, and whether the device has it.
#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "graph/compiler.h"

namespace penumbra {

namespace {

Extent apply(const ExtentRule& rule, Extent of) {
    return Follows{{{rule.div, rule.mul}}}.at(of);
}

void append(Follows& follows, const Follows::Step& step) {
    if (step != Follows::Step{}) follows.steps.push_back(step);
}

uint32_t element_bytes(const Port& port, Format format, const Domain& domain) {
    if (port.kind == PortKind::texels) return info(format).bytes;
    if (port.element == "uvec2") return 8;
    if (port.element == "uvec4" || port.element == "vec4") return 16;
    const auto known = domain.structs.find(port.element);
    return known == domain.structs.end() ? 4 : known->second;
}

}  // namespace

uint64_t PlanResource::buffer_bytes() const {
    if (kind == PortKind::image) return row_bytes * extent.height;
    return std::max<uint64_t>((count * element_bytes + 3) / 4 * 4, 4);
}

// What a reader of the previous value sees on a reset frame: the pipeline's wish, else the declaration's.
First Compiler::first_of(const BoundPort& bound) const {
    return pipeline_.resources[bound.resource].first.value_or(bound.port->first);
}

void Compiler::clear_on_reset(PlanResource& r) {
    r.clear_on_reset = true;
    r.image_usage |= VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    r.buffer_usage |= VK_BUFFER_USAGE_TRANSFER_DST_BIT;
}

// Everything but the size. In the order of the passes: what an update takes over has been made.
void Compiler::make_resource(const SelectedNode& selected, uint32_t port_index, uint32_t pass) {
    const BoundPort& bound = selected.node->ports[port_index];
    const Port& port = *bound.port;
    if (port.updated_input) {
        made_[bound.resource] = made_[selected.node->ports[*port.updated_input].resource];
        PlanResource& r = plan_.resources[made_[bound.resource].resource];
        r.names.push_back(name(bound.resource));
        r.settles = port.settles;
        r.memo = port.memo;
        r.clear_on_reset = false;  // the next frame reads the last of the chain
        if (first_of(bound) == First::clear) clear_on_reset(r);
        return;
    }
    made_[bound.resource] = {static_cast<uint32_t>(plan_.resources.size()), &selected, port_index, {}};
    PlanResource& r = plan_.resources.emplace_back();
    r.names = {name(bound.resource)};
    r.kind = port.kind;
    r.element = port.element;
    r.format = port.formats.empty() ? Format::r8 : pipeline_.resources[bound.resource].format;
    r.element_bytes = element_bytes(port, r.format, *pipeline_.domain);
    r.layered = port.layers;
    r.first_pass = pass;
    r.kept = port.writes == Writes::kept;
    r.memo = port.memo;
    r.settles = port.settles;
    r.image_usage = VK_IMAGE_USAGE_STORAGE_BIT;
    r.buffer_usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    if (r.kept || first_of(bound) == First::clear) clear_on_reset(r);
    if (port.writes == Writes::some || options_.poison) {
        r.image_usage |= VK_IMAGE_USAGE_TRANSFER_DST_BIT;
        r.buffer_usage |= VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    }
}

void Compiler::make_resources() {
    for (size_t id = 0; id < made_.size(); ++id) {
        const Made& made = made_[id];
        if (made.by && made.by->node->ports[made.port].resource == id)
            size_resource(plan_.resources[made.resource], made);
    }
}

// The size that a rule's `of` names, seen from one node.
Compiler::Size Compiler::size_of(const SelectedNode& selected, const SizeOf& of) {
    if (!of.port) return of.name.empty() ? Size{} : Size{target_.extent, 1, Follows{}};
    return size_of(selected.node->ports[*of.port].resource);
}

Compiler::Size Compiler::size_of(uint32_t id) {
    Made& made = made_[id];
    if (!made.by) {
        const size_t input = *pipeline_.resources[id].input;
        return {inputs_[input].extent, inputs_[input].layers, follows_of(pipeline_.inputs[input])};
    }
    if (!made.size) {
        const Port& port = *made.by->node->ports[made.port].port;
        const Size base = size_of(*made.by, port.extent.of);
        const uint32_t layers = port.layers_of.port ? size_of(*made.by, port.layers_of).extent.height
                                : port.layers       ? base.layers
                                                    : 1;
        made.size = Size{apply(port.extent, base.extent), layers, base.follows};
        if (made.size->follows) append(*made.size->follows, {port.extent.div, port.extent.mul});
    }
    return *made.size;
}

void Compiler::size_resource(PlanResource& r, const Made& made) {
    const BoundPort& bound = made.by->node->ports[made.port];
    const Port& port = *bound.port;
    const std::string path = fmt::format("nodes.{}.out.{}", made.by->node->id, port.name);
    const DeviceTable& device = target_.device;
    if (port.kind == PortKind::buffer) {
        const CountRule& rule = port.count;
        const Size base = size_of(*made.by, rule.of);
        const Extent of = base.extent;
        r.follows = base.follows;
        if (r.follows) {
            append(*r.follows, {rule.div, {1, 1}});
            r.follows->mul = rule.mul;
            r.follows->add = rule.add;
        }
        if (!rule.of.name.empty())
            r.count = uint64_t{ceil_div(of.width, rule.div[0])} * ceil_div(of.height, rule.div[1]) * rule.mul;
        r.count += rule.add;
    } else {
        const Size size = size_of(bound.resource);
        r.extent = size.extent;
        r.layers = size.layers;
        r.follows = size.follows;
        if (port.levels)
            r.levels = static_cast<uint32_t>(std::bit_width(std::max(r.extent.width, r.extent.height)));
        r.count = uint64_t{r.extent.width} * r.extent.height;
    }
    if (r.kind == PortKind::image) {
        if (std::max(r.extent.width, r.extent.height) > device.max_image_extent)
            error(bound.place, path,
                  fmt::format("{}x{} exceeds the device's largest image, {} per axis, by {}", r.extent.width,
                              r.extent.height, device.max_image_extent,
                              std::max(r.extent.width, r.extent.height) - device.max_image_extent));
        if (!device.supports(r.format, VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT))
            error(bound.place, path,
                  fmt::format("the device \"{}\" cannot store to {}", plan_.device, info(r.format).name));
    } else if (r.buffer_bytes() > device.max_storage_bytes) {
        error(bound.place, path,
              fmt::format("{} bytes exceed the device's largest storage buffer, {}, by {}", r.buffer_bytes(),
                          device.max_storage_bytes, r.buffer_bytes() - device.max_storage_bytes));
    }
}

}  // namespace penumbra
