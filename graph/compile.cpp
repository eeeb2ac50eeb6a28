// SPDX-License-Identifier: MIT
// Selected nodes to passes: resources with formats, extents and lifetimes on the circle of two frames,
// offsets from the packer, constants and dispatch sizes, then the dependencies.
#include "penumbra/compile.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/barriers.h"
#include "graph/compiler.h"
#include "graph/lifetimes.h"
#include "graph/limits.h"
#include "graph/rests.h"
#include "graph/settling.h"

namespace penumbra {
namespace {

// What a format must have for an image to be used so.
VkFormatFeatureFlags features_for(VkImageUsageFlags usage) {
    constexpr std::pair<VkImageUsageFlags, VkFormatFeatureFlags> pairs[] = {
        {VK_IMAGE_USAGE_SAMPLED_BIT, VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT},
        {VK_IMAGE_USAGE_STORAGE_BIT, VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT},
        {VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT},
        {VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT},
        {VK_IMAGE_USAGE_TRANSFER_SRC_BIT, VK_FORMAT_FEATURE_TRANSFER_SRC_BIT},
        {VK_IMAGE_USAGE_TRANSFER_DST_BIT, VK_FORMAT_FEATURE_TRANSFER_DST_BIT}};
    VkFormatFeatureFlags features = 0;
    for (const auto& [used, needed] : pairs)
        if (usage & used) features |= needed;
    return features;
}

}  // namespace

std::optional<Plan> Compiler::run() {
    plan_.pipeline = pipeline_.name;
    plan_.domain = pipeline_.domain;
    plan_.extent = target_.extent;
    plan_.device = target_.device.name;
    plan_.aliased = options_.alias;
    plan_.poison = options_.poison;
    const size_t errors = diagnostics_.size();
    const DeviceTable& device = target_.device;
    if (!device.supports || !device.image_memory || !device.buffer_memory) {
        error({pipeline_.file}, "",
              "Target::device tells nothing: device_table(handles), or reference_device()");
        return std::nullopt;
    }
    if (target_.extent.width == 0 || target_.extent.height == 0)
        error({pipeline_.file}, "", "the frame's extent is empty");
    const std::vector<std::string>& features = pipeline_.domain->features;
    for (const std::string& feature : device.features)
        if (std::ranges::find(features, feature) == features.end())
            error({pipeline_.file}, "features",
                  fmt::format("the host speaks of \"{}\", which is no feature that nodes ask for{}", feature,
                              did_you_mean(feature, features)));
    read_facts();
    auto selection = select_nodes(inputs_left_out(pipeline_, target_, diagnostics_));
    if (!selection) return std::nullopt;
    plan_.culled = std::move(selection->culled);
    inputs_ = resolve_inputs(pipeline_, *selection, target_, diagnostics_);
    if (diagnostics_.size() != errors) return std::nullopt;
    for (const BoundNode& node : pipeline_.nodes)
        if (!node.member.empty() &&
            members_.try_emplace(node.member, static_cast<uint32_t>(plan_.members.size())).second)
            plan_.members.push_back(node.member);
    plan_.passes.reserve(selection->nodes.size());
    made_.resize(pipeline_.resources.size());
    for (uint32_t p = 0; p < selection->nodes.size(); ++p)
        for (uint32_t i = 0; i < selection->nodes[p].sources.size(); ++i)
            if (selection->nodes[p].node->ports[i].port->output &&
                selection->nodes[p].sources[i] == Source::internal)
                make_resource(selection->nodes[p], i, p);
    make_resources();
    if (diagnostics_.size() != errors) return std::nullopt;
    lend_outputs();
    for (const SelectedNode& node : selection->nodes) lower(node);
    read_outputs();
    if (diagnostics_.size() != errors) return std::nullopt;
    for (PlanResource& r : plan_.resources) {
        if (!options_.hand_on_history || !r.lasts()) continue;
        r.image_usage |= VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
        r.buffer_usage |= VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    }
    place_lifetimes(plan_);
    place_rests(plan_);
    check_limits(*selection);  // the device is not asked about what it cannot make
    if (diagnostics_.size() != errors) return std::nullopt;
    place_memory(plan_, target_.device, options_.share_transients, options_.optimum_search_nodes,
                 options_.optimum_progress);
    if (plan_.memory.heap_bytes > target_.device.memory_bytes) {
        constexpr double mib = 1 << 20;
        const double needed = static_cast<double>(plan_.memory.heap_bytes) / mib,
                     there = static_cast<double>(target_.device.memory_bytes) / mib;
        error({pipeline_.file}, "",
              fmt::format("at {}x{} it takes {:.0f} MiB of memory, {:.0f} more than the {:.0f} of the "
                          "largest device-local heap of the device \"{}\"",
                          target_.extent.width, target_.extent.height, needed, needed - there, there,
                          plan_.device));
        return std::nullopt;
    }
    check_limits(*selection);  // of the heaps
    if (diagnostics_.size() != errors) return std::nullopt;
    place_barriers(plan_);
    for (uint32_t i = 0; i < plan_.resources.size(); ++i)
        if (plan_.resources[i].lasts()) plan_.reset.push_back({i, plan_.resources[i].clear_on_reset});
    plan_.settles = frames_to_settle(plan_);
    return std::move(plan_);
}

void Compiler::check_limits(const Selection& selection) {
    for (const NeededLimit& need : needed_limits(plan_)) {
        const auto limit = target_.device.limits.find(need.name);
        if (limit == target_.device.limits.end() || need.value <= limit->second) continue;
        const auto node = std::ranges::find_if(selection.nodes, [&](const SelectedNode& s) {
            return s.node && need.pass && s.node->id == need.why;
        });
        const std::string path = need.pass ? "nodes." + need.why : need.why;
        error(node != selection.nodes.end() ? node->node->place : Place{pipeline_.file}, path,
              fmt::format("it takes {} of {}, {} more than the {} of the device \"{}\"", need.value,
                          need.name, need.value - limit->second, limit->second, plan_.device));
    }
}

void Compiler::error(const Place& place, const std::string& path, const std::string& message) {
    diagnostics_.add(place, path, message);
}

void Compiler::read_facts() {
    for (const auto& [fact, holds] : target_.facts)
        if (const auto problem = fact_problem(*pipeline_.domain, fact))
            error({pipeline_.file}, "facts", *problem);
    for (size_t i = 0; i < pipeline_.domain->facts.size(); ++i) {
        const std::string& fact = pipeline_.domain->facts[i].name;
        const auto given = target_.facts.find(fact);
        plan_.facts[fact] = given == target_.facts.end() || given->second;
        if (plan_.facts[fact]) facts_ |= size_t{1} << i;
    }
}

// Facts become true at most, so that this ends. What is captured may be there only because of them.
std::optional<Selection> Compiler::select_nodes(const std::vector<bool>& left_out) {
    std::optional<Selection> selection;
    for (const std::vector<std::string>& captures : {std::vector<std::string>{}, options_.captures}) {
        do {
            selection = select(pipeline_, facts_, left_out, captures, diagnostics_);
        } while (selection && take_for_jittered(*selection));
    }
    return selection;
}

bool Compiler::take_for_jittered(const Selection& selection) {
    const auto asks = [](const SelectedNode& s) {
        return s.node && std::ranges::find(s.node->type().needs, "jitter") != s.node->type().needs.end();
    };
    plan_.jitter = target_.jitters.value_or(std::ranges::any_of(selection.nodes, asks));
    const size_t before = facts_;
    for (size_t i = 0; plan_.jitter && i < pipeline_.domain->facts.size(); ++i) {
        const std::string& fact = pipeline_.domain->facts[i].name;
        const auto takes = [&](const SelectedNode& s) {
            return s.node &&
                   std::ranges::find(s.node->type().jittered, fact) != s.node->type().jittered.end();
        };
        if (!std::ranges::any_of(selection.nodes, takes)) continue;
        plan_.facts[fact] = true;
        facts_ |= size_t{1} << i;
    }
    return facts_ != before;
}

// Outputs that are put into the host's own images become slots, before anything is bound to them.
void Compiler::lend_outputs() {
    for (const uint32_t id : pipeline_.outputs) {
        const auto asked = options_.outputs.find(name(id));
        if (asked == options_.outputs.end() || !asked->second.host_image) continue;
        PlanResource& r = plan_.resources[made_[id].resource];
        if (r.kind != PortKind::image || r.levels > 1 || r.kept)
            error({pipeline_.file}, "outputs." + name(id),
                  "cannot be put into an image of the host's: it is no image, has mip levels or is kept");
        r.slot = static_cast<uint32_t>(plan_.slots.size());
        plan_.slots.push_back({.name = name(id),
                               .format = r.format,
                               .extent = r.extent,
                               .layers = r.layers,
                               .layered = r.layered,
                               .follows = r.follows,
                               .output = true,
                               .accepted = {r.format}});
    }
}

void Compiler::read_outputs() {
    std::vector<std::string> names;
    for (const uint32_t id : pipeline_.outputs) {
        names.push_back(name(id));
        plan_.outputs.push_back({name(id), made_[id].resource});
        const auto asked = options_.outputs.find(name(id));
        const OutputUse use = asked == options_.outputs.end() ? OutputUse{} : asked->second;
        PlanResource& r = plan_.resources[made_[id].resource];
        plan_.outputs.back().use = {use.stages, use.access, (use.access & write_accesses) != 0};
        r.output = true;
        if (r.slot && r.history)
            error({pipeline_.file}, "outputs." + name(id),
                  "cannot be put into an image of the host's: the next frame reads its previous value");
        r.image_usage |= use.image_usage;
        r.buffer_usage |= use.buffer_usage;
        if (r.kind == PortKind::image && !target_.device.supports(r.format, features_for(use.image_usage)))
            error({pipeline_.file}, "outputs." + name(id),
                  fmt::format("the device \"{}\" has no images of {} for all that is done with it "
                              "(OutputUse::image_usage)",
                              plan_.device, info(r.format).name));
    }
    for (const auto& [output, use] : options_.outputs)
        if (!plan_.output(output))
            error({pipeline_.file}, "outputs",
                  fmt::format("the host speaks of \"{}\", which is no output{}", output,
                              did_you_mean(output, names)));
}

const PlanOutput* Plan::output(std::string_view name) const {
    for (const PlanOutput& o : outputs)
        if (o.name == name) return &o;
    return nullptr;
}

std::optional<uint32_t> Plan::slot(std::string_view name) const {
    for (uint32_t i = 0; i < slots.size(); ++i)
        if (slots[i].name == name) return i;
    return std::nullopt;
}

const PlanPass* Plan::pass(std::string_view node) const {
    for (const PlanPass& p : passes)
        if (p.node == node && p.kind != PassKind::capture) return &p;
    return nullptr;
}

Extent Follows::at(Extent frame) const {
    // What is too large to count is too large for a device, and refused as that.
    const auto through = [](uint32_t size, uint32_t div, uint32_t times) {
        return static_cast<uint32_t>(
            std::clamp<uint64_t>(uint64_t{ceil_div(size, div)} * times, 1, UINT32_MAX));
    };
    for (const Step& step : steps)
        frame = {through(frame.width, step.div[0], step.mul[0]),
                 through(frame.height, step.div[1], step.mul[1])};
    return frame;
}

std::array<uint32_t, 3> PlanPass::groups_at(Extent frame, uint32_t level) const {
    if (!over) return level_groups.empty() ? groups : level_groups[level];
    const Extent size = over->at(frame);
    return {ceil_div(std::max(size.width >> level, 1u), group_pixels[0]),
            ceil_div(std::max(size.height >> level, 1u), group_pixels[1]), groups[2]};
}

const PlanBinding* PlanPass::binding(std::string_view port) const {
    for (const PlanBinding& b : bindings)
        if (b.port == port) return &b;
    return nullptr;
}

std::optional<Plan> compile(const CheckedPipeline& pipeline, const Target& target,
                            const CompileOptions& options, Diagnostics& diagnostics) {
    return Compiler(pipeline, target, options, diagnostics).run();
}

}  // namespace penumbra
