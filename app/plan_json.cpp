// SPDX-License-Identifier: MIT
// Unknown values are null, never absent.
#include "app/plan_json.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "app/or_null.h"
#include "graph/flag_words.h"
#include "graph/vocabulary.h"
#include "host/images/image_file.h"
#include "penumbra/frame_block.h"
#include "penumbra/requirements.h"

namespace penumbra {

using OrderedJson = nlohmann::ordered_json;

namespace {

OrderedJson groups_json(const PlanPass& pass) {
    if (pass.kind != PassKind::compute) return nullptr;
    if (pass.indirect) return "indirect";
    return pass.groups;
}

}  // namespace

OrderedJson passes_json(const Plan& plan) {
    OrderedJson passes = OrderedJson::array();
    for (const PlanPass& pass : plan.passes)
        passes.push_back({{"node", pass.node},
                          {"type", pass.type},
                          {"groups", groups_json(pass)},
                          {"backend", pass.backends.empty() ? OrderedJson() : OrderedJson(pass.backends)},
                          {"reads", pass.reads},
                          {"writes", pass.writes}});
    return passes;
}

OrderedJson culled_json(const Plan& plan) {
    OrderedJson culled = OrderedJson::array();
    for (const Culled& c : plan.culled)
        culled.push_back({{"node", c.node},
                          {"why", c.why},
                          {"cond", c.cond.empty() ? OrderedJson() : OrderedJson(c.cond)}});
    return culled;
}

OrderedJson facts_json(const Plan& plan) {
    OrderedJson facts = OrderedJson::object();
    for (const auto& [name, value] : plan.facts) facts[name] = value;
    return facts;
}

OrderedJson memory_json(const Plan& plan) {
    const MemoryReport& m = plan.memory;
    OrderedJson heaps = OrderedJson::array(), resources = OrderedJson::array();
    for (const Heap& heap : plan.heaps) heaps.push_back({{"type", heap.type}, {"bytes", heap.bytes}});
    for (const PlanResource& r : plan.resources)
        resources.push_back({{"name", r.names.back()},
                             {"bytes", r.bytes},
                             {"first_pass", r.first_pass},
                             {"length", r.length},
                             {"offset", r.offset},
                             {"history", r.history}});
    const double pixels = static_cast<double>(plan.extent.width) * plan.extent.height;
    return {{"heap_bytes", m.heap_bytes},
            {"live_bound_bytes", m.live_bound_bytes},
            {"optimum_bytes", m.optimum_bytes ? OrderedJson(*m.optimum_bytes) : OrderedJson()},
            {"unaliased_bytes", m.unaliased_bytes},
            {"dedicated_history_bytes", m.dedicated_history_bytes},
            {"persistent_bytes", m.persistent_bytes},
            {"bytes_per_pixel", static_cast<double>(m.heap_bytes) / pixels},
            {"heaps", heaps},
            {"resources", resources}};
}

namespace {

// Throws for a bit without a word: a plan that lacks one is none.
template <size_t n>
OrderedJson flags_json(uint64_t flags, const FlagWord (&words)[n]) {
    OrderedJson list = OrderedJson::array();
    if (const uint64_t rest = say_flags(flags, words, [&](const char* word) { list.push_back(word); }))
        throw std::logic_error(fmt::format("no word for the flags {:#x}", rest));
    return list;
}

const char* word_of(VkDescriptorType type) {
    switch (type) {
        case VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER:
            return "sampled_image";
        case VK_DESCRIPTOR_TYPE_STORAGE_IMAGE:
            return "storage_image";
        case VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER:
            return "texel_buffer";
        case VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER:
            return "storage_texel_buffer";
        case VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER:
            return "uniform_buffer";
        case VK_DESCRIPTOR_TYPE_STORAGE_BUFFER:
            return "storage_buffer";
        case VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR:
            return "acceleration_structure";
        default:
            throw std::logic_error("no word for a descriptor type");
    }
}

OrderedJson extent_json(Extent extent) {
    return {extent.width, extent.height};
}

bool has_texels(PortKind kind) {
    return kind == PortKind::image || kind == PortKind::texels;
}

OrderedJson dependency_json(const Dependency& d) {
    OrderedJson activations = OrderedJson::array();
    for (const Activation& a : d.activations)
        activations.push_back({{"resource", a.resource},
                               {"from_stages", flags_json(a.src_stages, stage_words)},
                               {"from_access", flags_json(a.src_access, access_words)},
                               {"to_stages", flags_json(a.dst_stages, stage_words)},
                               {"to_access", flags_json(a.dst_access, access_words)}});
    return {{"from_stages", flags_json(d.src_stages, stage_words)},
            {"from_access", flags_json(d.src_access, access_words)},
            {"to_stages", flags_json(d.dst_stages, stage_words)},
            {"to_access", flags_json(d.dst_access, access_words)},
            {"activations", activations}};
}

OrderedJson by_parity(const std::array<Dependency, 2>& pair) {
    return {dependency_json(pair[0]), dependency_json(pair[1])};
}

OrderedJson follows_json(const std::optional<Follows>& follows) {
    if (!follows) return {};
    OrderedJson steps = OrderedJson::array();
    for (const Follows::Step& step : follows->steps)
        steps.push_back({step.div[0], step.div[1], step.mul[0], step.mul[1]});
    return steps;
}

OrderedJson slots_json(const Plan& plan) {
    OrderedJson slots = OrderedJson::array();
    for (const HostSlot& slot : plan.slots) {
        OrderedJson accepted = OrderedJson::array();
        for (const Format format : slot.accepted) accepted.push_back(info(format).name);
        const bool image = slot.kind == PortKind::image;
        slots.push_back(
            {{"name", slot.name},
             {"input", slot.input.empty() ? OrderedJson() : OrderedJson(slot.input)},
             {"kind", kind_name(slot.kind)},
             {"previous", slot.previous},
             {"output", slot.output},
             {"required", slot.required},
             {"format", has_texels(slot.kind) ? OrderedJson(info(slot.format).name) : OrderedJson()},
             {"accepted", accepted},
             {"size", image ? extent_json(slot.extent) : OrderedJson()},
             {"follows", follows_json(slot.follows)},
             {"array", slot.layered},
             {"layers", image ? OrderedJson(slot.layers) : OrderedJson()},
             {"element", slot.element.empty() ? OrderedJson() : OrderedJson(slot.element)},
             {"bytes", slot.bytes ? OrderedJson(slot.bytes) : OrderedJson()},
             {"layout", !image ? OrderedJson() : OrderedJson(slot.output ? "general" : "read_only")},
             {"stages", flags_json(slot.use.stages, stage_words)},
             {"access", flags_json(slot.use.access, access_words)},
             {"nodes", slot.readers}});
    }
    return slots;
}

OrderedJson resources_json(const Plan& plan) {
    OrderedJson resources = OrderedJson::array();
    for (const PlanResource& r : plan.resources) {
        const bool image = r.kind == PortKind::image;
        const auto passes = static_cast<uint32_t>(plan.passes.size());
        resources.push_back(
            {{"names", r.names},
             {"kind", kind_name(r.kind)},
             {"format", has_texels(r.kind) ? OrderedJson(info(r.format).name) : OrderedJson()},
             {"size", has_texels(r.kind) ? extent_json(r.extent) : OrderedJson()},
             {"follows", has_texels(r.kind) ? follows_json(r.follows) : OrderedJson()},
             {"array", r.layered},
             {"layers", r.layers},
             {"levels", r.levels},
             {"element", r.element.empty() ? OrderedJson() : OrderedJson(r.element)},
             {"buffer_bytes", image && !r.row_bytes ? OrderedJson() : OrderedJson(r.buffer_bytes())},
             {"row_bytes", r.row_bytes ? OrderedJson(r.row_bytes) : OrderedJson()},
             {"usage", image ? flags_json(r.image_usage, image_usage_words)
                             : flags_json(r.buffer_usage, buffer_usage_words)},
             {"history", r.history},
             {"kept", r.kept},
             {"output", r.output},
             {"slot", or_null(r.slot)},
             {"first_pass", r.first_pass},
             {"last_pass", (r.first_pass + r.length - 1) % (passes ? passes : 1)},
             {"length", r.length},
             {"heap", r.slot ? OrderedJson() : OrderedJson(r.heap)},
             {"memory_bytes", r.bytes},
             {"alignment", r.alignment},
             {"offset", r.offset}});
    }
    return resources;
}

OrderedJson binding_json(const PlanBinding& b) {
    constexpr const char* sources[] = {"resource", "slot", "table", "frame_block", "counters", "nothing"};
    constexpr const char* levels[] = {"finest", "written", "finer"};
    const bool indexed = b.source == BindingSource::resource || b.source == BindingSource::host ||
                         b.source == BindingSource::table;
    const bool texels = b.type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER ||
                        b.type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE || b.is_texels();
    const bool sampled = b.type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    return {{"set", b.set},
            {"binding", b.binding},
            {"type", word_of(b.type)},
            {"source", sources[static_cast<size_t>(b.source)]},
            {"index", indexed ? OrderedJson(b.index) : OrderedJson()},
            {"previous", b.previous},
            {"level", levels[static_cast<size_t>(b.level)]},
            {"filter", sampled ? OrderedJson(b.linear ? "linear" : "nearest") : OrderedJson()},
            {"array", b.layered},
            {"format", texels ? OrderedJson(info(b.format).name) : OrderedJson()},
            {"port", b.port.empty() ? OrderedJson() : OrderedJson(b.port)}};
}

// What a frame runs of a pass, beside what passes_json says to people.
OrderedJson pass_json(const PlanPass& pass, OrderedJson json) {
    constexpr const char* kinds[] = {"compute", "host", "capture"};
    const bool compute = pass.kind == PassKind::compute;
    json["kind"] = kinds[static_cast<size_t>(pass.kind)];
    json["module"] = or_null(pass.module);
    json["entry"] = compute ? OrderedJson("main") : OrderedJson();
    json["workgroup"] =
        compute ? OrderedJson{pass.constants[0], pass.constants[1], pass.constants[2]} : OrderedJson();
    json["constants"] = pass.constants;  // by id, as bits
    std::vector<uint32_t> push(pass.push.size() / 4);
    if (!push.empty()) std::memcpy(push.data(), pass.push.data(), 4 * push.size());
    json["push"] = push;
    json["params"] = OrderedJson::array();
    static const std::vector<std::string> types = param_type_words();
    for (const PlanParam& p : pass.params)
        json["params"].push_back({{"name", p.param.name},
                                  {"type", types[static_cast<size_t>(p.param.type)]},
                                  {"offset", p.offset}});
    json["mip_level"] = or_null(pass.mip_level);
    json["level_groups"] = pass.level_groups;
    json["follows"] = follows_json(pass.over);
    json["group_pixels"] = pass.over ? OrderedJson(pass.group_pixels) : OrderedJson();
    json["indirect"] = pass.indirect
                           ? OrderedJson{{"resource", *pass.indirect}, {"offset", pass.indirect_offset}}
                           : OrderedJson();
    json["bindings"] = OrderedJson::array();
    for (const PlanBinding& b : pass.bindings)
        if (compute) json["bindings"].push_back(binding_json(b));
    json["resource"] =
        pass.kind == PassKind::capture ? OrderedJson(pass.bindings.front().index) : OrderedJson();
    json["before"] = by_parity(pass.before);
    json["clears"] = pass.clears;
    json["after_clears"] = by_parity(pass.after_clears);
    json["member"] = or_null(pass.member);
    json["rests"] = pass.rests;
    json["zero_at_rest"] = pass.zero_at_rest;
    json["counters"] = pass.counters;
    json["counter_base"] = pass.counter_base;
    return json;
}

OrderedJson frame_block_json() {
    OrderedJson members = OrderedJson::array();
#define PENUMBRA_MEMBER(name, type) \
    members.push_back({{"name", #name}, {"type", type}, {"offset", offsetof(FrameBlock, name)}});
    PENUMBRA_MEMBER(clip_from_view, "mat4")
    PENUMBRA_MEMBER(view_from_clip, "mat4")
    PENUMBRA_MEMBER(world_from_view, "mat3")
    PENUMBRA_MEMBER(prev_clip_from_rel, "mat4")
    PENUMBRA_MEMBER(camera_delta, "vec3")
    PENUMBRA_MEMBER(near_m, "float")
    PENUMBRA_MEMBER(jitter, "vec2")
    PENUMBRA_MEMBER(prev_jitter, "vec2")
    PENUMBRA_MEMBER(size, "uvec2")
    PENUMBRA_MEMBER(prev_size, "uvec2")
    PENUMBRA_MEMBER(pixel_angle, "float")
    PENUMBRA_MEMBER(dt_s, "float")
    PENUMBRA_MEMBER(frame_index, "uint")
    PENUMBRA_MEMBER(flags, "uint")
    PENUMBRA_MEMBER(snap_px, "float")
    PENUMBRA_MEMBER(grid_px, "float")
    PENUMBRA_MEMBER(prev_depth, "vec2")
#undef PENUMBRA_MEMBER
    return {{"bytes", sizeof(FrameBlock)}, {"members", members}};
}

OrderedJson needs_json(const Plan& plan) {
    OrderedJson needs = OrderedJson::array();
    for (const Requirement& r : requirements(plan))
        needs.push_back({{"kind", kind_name(r.kind)}, {"name", r.name}, {"value", r.value}, {"why", r.why}});
    return needs;
}

}  // namespace

OrderedJson to_json(const Plan& plan) {
    OrderedJson json = {{"penumbra_plan", plan_json_version},
                        {"pipeline", plan.pipeline},
                        {"size", {plan.extent.width, plan.extent.height}},
                        {"device", plan.device},
                        {"facts", facts_json(plan)},
                        {"jitter", plan.jitter},
                        {"camera", plan.camera},
                        {"settles", plan.settles ? OrderedJson(*plan.settles) : OrderedJson()},
                        {"requirements", needs_json(plan)},
                        {"frame_block", frame_block_json()},
                        {"slots", slots_json(plan)}};
    json["modules"] = OrderedJson::array();
    for (size_t i = 0; i < plan.modules.size(); ++i) json["modules"].push_back(module_file(i));
    json["tables"] = OrderedJson::array();
    for (size_t i = 0; i < plan.tables.size(); ++i)
        json["tables"].push_back({{"name", plan.tables[i].name},
                                  {"format", info(plan.tables[i].format).name},
                                  {"size", plan.tables[i].extent},
                                  {"storage", plan.tables[i].storage},
                                  {"file", table_file(i)}});
    json["heaps"] = OrderedJson::array();
    for (const Heap& heap : plan.heaps)
        json["heaps"].push_back({{"kind", heap.type},
                                 {"bytes", heap.bytes},
                                 {"alignment", heap.alignment},
                                 {"memory_type_bits", heap.memory_type_bits},
                                 {"shared", heap.shared}});
    json["resources"] = resources_json(plan);
    json["reset"] = OrderedJson::array();
    for (const ResetAction& action : plan.reset)
        json["reset"].push_back({{"resource", action.resource}, {"clear", action.clear}});
    json["members"] = plan.members;
    const OrderedJson passes = passes_json(plan);
    json["passes"] = OrderedJson::array();
    for (size_t p = 0; p < plan.passes.size(); ++p)
        json["passes"].push_back(pass_json(plan.passes[p], passes[p]));
    json["end"] = by_parity(plan.end);
    json["outputs"] = OrderedJson::array();
    for (const PlanOutput& output : plan.outputs)
        json["outputs"].push_back({{"name", output.name},
                                   {"resource", output.resource},
                                   {"stages", flags_json(output.use.stages, stage_words)},
                                   {"access", flags_json(output.use.access, access_words)}});
    json["counters"] = plan.counters;
    json["culled"] = culled_json(plan);
    json["memory"] = memory_json(plan);
    return json;
}

std::string module_file(size_t index) {
    return fmt::format("module_{}.spv", index);
}

std::string table_file(size_t index) {
    return fmt::format("table_{}.bin", index);
}

bool write_plan(const Plan& plan, const std::filesystem::path& folder, Diagnostics& diagnostics) {
    std::error_code ignored;
    std::filesystem::create_directories(folder, ignored);
    // Last, and not there before: whoever finds it finds all of the plan. (A folder of that name is not ours
    // to remove.)
    const std::filesystem::path description = folder / "plan.json";
    if (std::filesystem::is_regular_file(description, ignored)) std::filesystem::remove(description, ignored);
    std::vector<std::filesystem::path> written;
    const auto write = [&](const std::filesystem::path& file, const void* data, size_t bytes) {
        write_file(file, {static_cast<const std::byte*>(data), bytes});
        written.push_back(file);
    };
    try {
        for (size_t i = 0; i < plan.modules.size(); ++i)
            write(folder / module_file(i), plan.modules[i].data(), 4 * plan.modules[i].size());
        for (size_t i = 0; i < plan.tables.size(); ++i)
            write(folder / table_file(i), plan.tables[i].texels->data(), plan.tables[i].texels->size());
        const std::string text = to_json(plan).dump(2) + "\n";
        write(description, text.data(), text.size());
    } catch (const FileError& failure) {
        diagnostics.add({}, "", failure.what());
        for (const std::filesystem::path& file : written) std::filesystem::remove(file, ignored);
        return false;
    }
    // Of a larger plan that was here.
    for (size_t i = plan.modules.size(); std::filesystem::remove(folder / module_file(i), ignored); ++i) {
    }
    for (size_t i = plan.tables.size(); std::filesystem::remove(folder / table_file(i), ignored); ++i) {
    }
    return true;
}

}  // namespace penumbra
