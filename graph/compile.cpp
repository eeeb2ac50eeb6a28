// SPDX-License-Identifier: MIT
// Selected nodes to passes: resources with formats, extents and lifetimes on the circle of two frames,
// offsets from the packer, constants and dispatch sizes, then the dependencies.
#include "graph/compile.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <set>

#include "graph/barriers.h"
#include "graph/host_inputs.h"
#include "graph/lifetimes.h"
#include "graph/select.h"

namespace penumbra {
namespace {

uint32_t ceil_div(uint32_t a, uint32_t b) {
    return a / b + (a % b != 0);
}

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

class Compiler {
  public:
    Compiler(const CheckedPipeline& pipeline, const NodeSet& nodes, const Target& target,
             const CompileOptions& options, Diagnostics& diagnostics)
        : pipeline_(pipeline), nodes_(nodes), target_(target), options_(options), diagnostics_(diagnostics) {}

    std::optional<Plan> run() {
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

  private:
    void error(const Place& place, const std::string& path, const std::string& message) {
        diagnostics_.add(place, path, message);
    }

    // --- one node
    // ---------------------------------------------------------------------------------------------

    void lower(const SelectedNode& selected) {
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
        for (const std::string& counter : node.type->counters)
            plan_.counters.push_back(node.id + "." + counter);
    }

    void lower_capture(const SelectedNode& selected) {
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

    void check_needs(const BoundNode& node) {
        for (const std::string& need : node.type->needs) {
            if (need == "jitter") plan_.jitter = true;
            if ((need == "ray_query" && !target_.device.ray_query) ||
                (need == "storage8" && !target_.device.storage8))
                error(node.place, "nodes." + node.id,
                      fmt::format("the device \"{}\" lacks {}", plan_.device, need));
        }
    }

    struct Size {
        Extent extent;
        uint32_t layers = 1;
    };

    Size size_of(const Connection& c) const {
        if (c.source == Source::host) {
            const HostSlot& slot = *std::find_if(plan_.slots.begin(), plan_.slots.end(),
                                                 [&](const HostSlot& s) { return s.name == c.resource; });
            return {slot.extent, slot.layers};
        }
        const PlanResource& r = plan_.resources[internal_.at(c.resource)];
        return {r.extent, r.layers};
    }

    // The size that a rule's `of` names, seen from one node.
    std::optional<Size> size_named(const BoundNode& node, const SelectedNode& selected,
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

    void bind_input(const BoundNode& node, const Connection& c, uint32_t binding) {
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

    void use_input(PlanPass& pass, const Port& port, uint32_t resource, bool previous) {
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

    void check_readable(const PlanResource& r, const Port& port) {
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
    static Use input_use(const PlanPass& pass, const Port& port) {
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
    std::vector<uint32_t> host_slots(const BoundNode& node, const Connection& c) {
        const Port& port = *c.bound->port;
        if (port.kind == PortKind::scene) {
            std::vector<uint32_t> slots;
            if (uses_ray_query(plan_.passes.back().variant))
                slots = {slot(node, c.resource + ".tlas", PortKind::scene, Format::r8, c, "")};
            else
                for (const SceneTexels& texels : scene_tree_slots)
                    slots.push_back(scene_texels(node, c, texels));
            if (plan_.passes.back().variant.alpha)
                for (const SceneTexels& texels : scene_alpha_slots)
                    slots.push_back(scene_texels(node, c, texels));
            slots.push_back(slot(node, c.resource, PortKind::block, Format::r8, c, "Scene"));
            return slots;
        }
        return {slot(node, c.resource, port.kind, Format::r8, c, port.element)};
    }

    uint32_t scene_texels(const BoundNode& node, const Connection& c, const SceneTexels& texels) {
        return slot(node, fmt::format("{}.{}", c.resource, texels.slot), PortKind::texels, texels.format, c,
                    "");
    }

    uint32_t slot(const BoundNode& node, const std::string& name, PortKind kind, Format format,
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

    void bind_output(const BoundNode& node, const SelectedNode& selected, const Connection& c,
                     uint32_t binding) {
        if (c.source == Source::none) return;
        PlanPass& pass = plan_.passes.back();
        const Port& port = *c.bound->port;
        uint32_t resource = 0;
        Use use{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, true};
        if (!port.updates.empty()) {
            const auto in =
                std::find_if(selected.ports.begin(), selected.ports.end(),
                             [&](const Connection& o) { return o.bound->port->name == port.updates; });
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

    // What a reader of `name`@-1 sees on a reset frame: the pipeline's wish, else the declaration's.
    First first_of(const Port& port, const std::string& name) const {
        for (const ResourceSetting& setting : pipeline_.resources)
            if (setting.name == name && setting.first) return *setting.first;
        return port.first;
    }

    static void clear_on_reset(PlanResource& r) {
        r.clear_on_reset = true;
        r.image_usage |= VK_IMAGE_USAGE_TRANSFER_DST_BIT;
        r.buffer_usage |= VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    }

    void make_resource(const BoundNode& node, const SelectedNode& selected, const Connection& c) {
        const Port& port = *c.bound->port;
        PlanResource r;
        r.names = {c.resource};
        r.kind = port.kind;
        r.element = port.element;
        if (!port.formats.empty()) r.format = port.formats.front();
        for (const ResourceSetting& setting : pipeline_.resources)
            if (setting.name == c.resource && setting.format) r.format = *setting.format;
        if (const auto kept = inputs_.kept.find(c.resource); kept != inputs_.kept.end())
            r.format = kept->second;
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
        if (first_of(port, c.resource) == First::clear) clear_on_reset(r);
        if (r.clear_on_activation || options_.poison) {
            r.image_usage |= VK_IMAGE_USAGE_TRANSFER_DST_BIT;
            r.buffer_usage |= VK_BUFFER_USAGE_TRANSFER_DST_BIT;
        }
        plan_.resources.push_back(std::move(r));
    }

    // --- variants, constants, dispatch
    // ----------------------------------------------------------------------------

    // The rule of `auto`: ray queries of a CPU device are two orders of magnitude slower than the tree in
    // compute.
    void choose_backend(const BoundNode& node) {
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

    void choose_variant(const BoundNode& node, const SelectedNode& selected) {
        choices_.emplace_back();
        for (const Connection& c : selected.ports) {
            const Port& port = *c.bound->port;
            if (port.optional || !port.condition.empty())
                plan_.passes.back().variant.present[port.name] = c.source != Source::none;
            if (port.kind == PortKind::image && port.storage && port.formats.size() > 1 &&
                port.updates.empty())
                choices_.back().push_back({&port, c.resource, c.source, node.id});
        }
        for (const Table& table : node.type->tables)
            if (!table.condition.empty())
                plan_.passes.back().variant.present[table.name] =
                    holds(table.condition, target_.facts, node.params);
    }

    const ClassOverrides& overrides(const BoundNode& node) const {
        return target_.device.cpu ? node.type->cpu : node.type->gpu;
    }

    // The pipeline's own value, else the device class's, else the declaration's.
    const ParamValue& value_of(const BoundNode& node, const Param& param) const {
        const auto set = node.set_by_user.find(param.name);
        const auto override_value = overrides(node).params.find(param.name);
        if ((set == node.set_by_user.end() || !set->second) && override_value != overrides(node).params.end())
            return override_value->second;
        return node.params.at(param.name);
    }

    void fill_constants(const BoundNode& node) {
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

    uint32_t levels_of(const SelectedNode& selected, const Port& chain) const {
        for (const Connection& c : selected.ports)
            if (c.bound->port == &chain) return plan_.resources[internal_.at(c.resource)].levels;
        return 0;
    }

    void fill_dispatch(const BoundNode& node, const SelectedNode& selected) {
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
                                  fmt::format("\"{}\" is too small for dispatch arguments at byte {}",
                                              c.resource, dispatch.offset));
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

    // --- after all passes
    // -----------------------------------------------------------------------------------------

    struct Late {
        size_t pass, binding;
        std::string resource;
    };
    struct FormatChoice {
        const Port* port;
        std::string resource;
        Source source;
        std::string node;
    };

    void finish_resources() {
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

    const CheckedPipeline& pipeline_;
    const NodeSet& nodes_;
    const Target& target_;
    const CompileOptions& options_;
    Diagnostics& diagnostics_;
    Plan plan_;
    ResolvedInputs inputs_;
    std::vector<uint32_t> bindings_;
    std::map<std::string, uint32_t> internal_;  // name -> resource
    std::vector<Late> late_;
    std::vector<std::vector<FormatChoice>> choices_;  // per non-capture pass
};

}  // namespace

uint64_t PlanResource::buffer_bytes() const {
    return std::max<uint64_t>((count * element_bytes + 3) / 4 * 4, 4);
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
