// SPDX-License-Identifier: MIT
// Output ports to resources: format, extent or count, what must be clear, and whether the device has it.
#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "graph/compiler.h"

namespace penumbra {

namespace {

Extent apply(const ExtentRule& rule, Extent of) {
    return {std::max(ceil_div(of.width, rule.div[0]) * rule.mul[0], 1u),
            std::max(ceil_div(of.height, rule.div[1]) * rule.mul[1], 1u)};
}

uint32_t element_bytes(const Port& port, Format format, const NodeSet& nodes) {
    if (port.kind == PortKind::texels) return info(format).bytes;
    if (port.element == "uvec2") return 8;
    if (port.element == "uvec4" || port.element == "vec4") return 16;
    const auto known = nodes.structs().find(port.element);
    return known == nodes.structs().end() ? 4 : known->second;
}

}  // namespace

uint64_t PlanResource::buffer_bytes() const {
    return std::max<uint64_t>((count * element_bytes + 3) / 4 * 4, 4);
}

// What a reader of `name`@-1 sees on a reset frame: the pipeline's wish, else the declaration's.
First Compiler::first_of(const Port& port, const std::string& name) const {
    for (const ResourceSetting& setting : pipeline_.resources)
        if (setting.name == name && setting.first) return *setting.first;
    return port.first;
}

void Compiler::clear_on_reset(PlanResource& r) {
    r.clear_on_reset = true;
    r.image_usage |= VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    r.buffer_usage |= VK_BUFFER_USAGE_TRANSFER_DST_BIT;
}

void Compiler::make_resource(const BoundNode& node, const SelectedNode& selected, const Connection& c) {
    const Port& port = *c.bound->port;
    PlanResource r;
    r.names = {c.resource};
    r.kind = port.kind;
    r.element = port.element;
    if (!port.formats.empty()) r.format = port.formats.front();
    for (const ResourceSetting& setting : pipeline_.resources)
        if (setting.name == c.resource && setting.format) r.format = *setting.format;
    if (const auto kept = inputs_.kept.find(c.resource); kept != inputs_.kept.end()) r.format = kept->second;
    r.element_bytes = element_bytes(port, r.format, nodes_);
    r.clear_on_activation = port.writes == Writes::some;
    const std::string path = fmt::format("nodes.{}.out.{}", node.id, port.name);
    const std::string& of = port.kind == PortKind::buffer ? port.count.of : port.extent.of;
    const auto base = of.empty() ? std::optional<Size>{Size{}} : size_named(node, selected, of);
    if (!base)
        error(c.bound->place, path, fmt::format("its size follows port \"{}\", which is not bound", of));
    const Extent of_extent = base.value_or(Size{}).extent;
    if (port.kind == PortKind::buffer) {
        const CountRule& rule = port.count;
        if (!of.empty())
            r.count = uint64_t{ceil_div(of_extent.width, rule.div[0])} *
                      ceil_div(of_extent.height, rule.div[1]) * rule.mul;
        r.count += rule.add;
        r.buffer_usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    } else {
        r.extent = apply(port.extent, of_extent);
        r.layered = port.layers;
        if (port.layers) r.layers = base.value_or(Size{}).layers;
        if (port.levels)
            r.levels = static_cast<uint32_t>(std::bit_width(std::max(r.extent.width, r.extent.height)));
        r.count = uint64_t{r.extent.width} * r.extent.height;
        r.image_usage = VK_IMAGE_USAGE_STORAGE_BIT;
        r.buffer_usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
        if (port.kind == PortKind::image &&
            std::max(r.extent.width, r.extent.height) > target_.device.max_image_extent)
            error(c.bound->place, path,
                  fmt::format("{}x{} exceeds the device's largest image, {} per axis", r.extent.width,
                              r.extent.height, target_.device.max_image_extent));
        if (port.kind == PortKind::image &&
            !target_.device.supports(r.format, VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT))
            error(c.bound->place, path,
                  fmt::format("the device \"{}\" cannot store to {}", plan_.device, info(r.format).name));
    }
    if (r.kind != PortKind::image && r.buffer_bytes() > target_.device.max_storage_bytes)
        error(c.bound->place, path,
              fmt::format("{} bytes exceed the device's largest storage buffer, {}", r.buffer_bytes(),
                          target_.device.max_storage_bytes));
    r.kept = port.writes == Writes::kept;
    r.memo = port.memo;
    if (r.kept || first_of(port, c.resource) == First::clear) clear_on_reset(r);
    if (r.clear_on_activation || options_.poison) {
        r.image_usage |= VK_IMAGE_USAGE_TRANSFER_DST_BIT;
        r.buffer_usage |= VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    }
    plan_.resources.push_back(std::move(r));
}

}  // namespace penumbra
