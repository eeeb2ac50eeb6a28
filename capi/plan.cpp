// SPDX-License-Identifier: MIT
// Plans, and what they ask for.
#include "capi/shared.h"
#include "penumbra/shadow_nodes.h"
#include "penumbra/version.h"

using namespace penumbra;
using namespace penumbra::c;

namespace {

static_assert(PENUMBRA_IMAGE == static_cast<int>(PortKind::image) &&
              PENUMBRA_TEXELS == static_cast<int>(PortKind::texels) &&
              PENUMBRA_BUFFER == static_cast<int>(PortKind::buffer) &&
              PENUMBRA_BLOCK == static_cast<int>(PortKind::block) &&
              PENUMBRA_STRUCTURE == static_cast<int>(PortKind::structure));

Plan make_plan(const penumbra_plan_request& r) {
    Mistakes mistakes;
    Diagnostics& errors = mistakes.diagnostics;
    const std::vector<std::string> settings = texts(r.settings, r.setting_count, "request.settings");
    const char* file = named(r.file, "request.file");
    ReadFile read;
    if (r.read)
        read = [&](const std::string& name) -> std::optional<std::string> {
            const char* text = r.read(r.read_user, name.c_str());
            return text ? std::optional<std::string>(text) : std::nullopt;
        };
    const char* text = r.text ? r.text : r.read ? r.read(r.read_user, file) : nullptr;
    if (r.read && !text) {
        errors.add({file}, "", "no such file");
        throw mistakes;
    }
    const auto pipeline =
        text ? parse_pipeline(text, file, settings, errors, read) : load_pipeline(file, settings, errors);
    const auto checked =
        pipeline ? check(*pipeline, r.nodes ? r.nodes->set : shadow_nodes(), errors) : std::nullopt;
    if (!checked) throw mistakes;
    Target target;
    target.extent = {r.width, r.height};
    target.device = r.device ? device_table(handles_of(r.device)) : reference_device();
    for (std::string& feature : texts(r.features, r.feature_count, "request.features"))
        target.device.features.insert(std::move(feature));
    if (r.jitters > PENUMBRA_JITTERS_NEVER) misuse("request.jitters", "is none of penumbra_jitters");
    if (r.jitters != PENUMBRA_JITTERS_AS_ASKED) target.jitters = r.jitters == PENUMBRA_JITTERS_ALWAYS;
    for_each(r.facts, r.fact_count, "request.facts", [&](const penumbra_fact& fact) {
        const char* name = named(fact.name, "request.facts.name");
        if (!target.facts.emplace(name, fact.holds).second)
            misuse(std::string("request.facts of \"") + name + "\"", "stands there twice");
    });
    for_each(r.inputs, r.input_count, "request.inputs", [&](const penumbra_input& input) {
        const char* name = named(input.name, "request.inputs.name");
        if (target.left_out.contains(name) || target.inputs.contains(name))
            misuse(std::string("request.inputs of \"") + name + "\"", "stands there twice");
        if (input.left_out) {
            target.left_out.insert(name);
            return;
        }
        const auto format = format_named(named(input.format, "request.inputs.format"));
        if (!format) {
            const std::vector<std::string> names = format_names();
            misuse(std::string("request.inputs of \"") + name + "\"", std::string("there is no format \"") +
                                                                          input.format + "\"" +
                                                                          did_you_mean(input.format, names));
        }
        target.inputs[name] = {*format, {input.width, input.height}, std::max(input.layers, 1u)};
    });
    CompileOptions options;
    options.captures = texts(r.captures, r.capture_count, "request.captures");
    options.share_transients = r.share_transients;
    options.hand_on_history = r.hand_on_history;
    for (const std::string& name : texts(r.host_images, r.host_image_count, "request.host_images"))
        options.outputs[name].host_image = true;
    for_each(r.output_uses, r.output_use_count, "request.output_uses", [&](const penumbra_output_use& use) {
        OutputUse& own = options.outputs[named(use.name, "request.output_uses.name")];
        own.host_image |= use.host_image != 0;
        if (use.image_usage) own.image_usage = use.image_usage;
        if (use.buffer_usage) own.buffer_usage = use.buffer_usage;
        if (use.stages) own.stages = use.stages;
        if (use.access) own.access = use.access;
    });
    auto plan = compile(*checked, target, options, errors);
    if (!plan) throw mistakes;
    return std::move(*plan);
}

VkFormat format_of(PortKind kind, Format format) {
    return kind == PortKind::image || kind == PortKind::texels ? info(format).vk : VK_FORMAT_UNDEFINED;
}

// What a host's image is made for.
VkImageUsageFlags usage_of(const Plan& plan, uint32_t slot) {
    const HostSlot& s = plan.slots[slot];
    if (s.kind != PortKind::image) return 0;
    for (const PlanResource& r : plan.resources)
        if (r.slot == slot) return r.image_usage;
    constexpr std::pair<VkAccessFlags2, VkImageUsageFlags> uses[] = {
        {VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, VK_IMAGE_USAGE_SAMPLED_BIT},
        {VK_ACCESS_2_SHADER_STORAGE_READ_BIT, VK_IMAGE_USAGE_STORAGE_BIT},
        {VK_ACCESS_2_MEMORY_READ_BIT,
         VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT}};  // a callback's
    VkImageUsageFlags usage = 0;
    for (const auto& [access, bit] : uses)
        if (s.use.access & access) usage |= bit;
    return usage;
}

}  // namespace

const char* penumbra_version(void) {
    return PENUMBRA_VERSION_TEXT;
}

penumbra_code penumbra_plan_create(const penumbra_plan_request* request, penumbra_plan** plan,
                                   penumbra_error* error) {
    return guarded(error, [&] {
        given(plan, "plan") = nullptr;
        auto made = std::make_unique<penumbra_plan>();
        made->plan = std::make_shared<const Plan>(make_plan(read(request, "request")));
        made->needs = requirements(*made->plan);
        for (const HostSlot& slot : made->plan->slots) {
            std::vector<const char*>& names = made->accepted.emplace_back();
            for (const Format format : slot.accepted) names.push_back(info(format).name);
        }
        for (const PlanPass& pass : made->plan->passes) {
            std::vector<const char*>& counters = made->counters.emplace_back();
            for (const std::string& name : pass.counters) counters.push_back(name.c_str());
            for (const PlanParam& p : pass.params)
                for (const std::string& name : p.param.values) made->enums[&p.param].push_back(name.c_str());
        }
        *plan = made.release();
    });
}

void penumbra_plan_destroy(penumbra_plan* plan) {
    delete plan;
}

penumbra_code penumbra_plan_read(const penumbra_plan* plan, penumbra_plan_info* info, penumbra_error* error) {
    return guarded(error, [&] {
        const Plan& p = *given(plan, "plan").plan;
        write(info, {0, p.jitter, p.settles.value_or(UINT32_MAX), p.camera}, "info");
    });
}

uint32_t penumbra_plan_slot_count(const penumbra_plan* plan) {
    return plan ? static_cast<uint32_t>(plan->plan->slots.size()) : 0;
}

penumbra_code penumbra_plan_slot(const penumbra_plan* plan, uint32_t index, penumbra_slot* slot,
                                 penumbra_error* error) {
    return guarded(error, [&] {
        const HostSlot& s = one_of(given(plan, "plan").plan->slots, index, "index", "the plan", "slots");
        const std::vector<const char*>& accepted = plan->accepted[index];
        write(slot,
              {0, static_cast<penumbra_slot_kind>(s.kind), s.name.c_str(), format_of(s.kind, s.format),
               s.extent.width, s.extent.height, s.layers, s.bytes, s.output, s.required, s.use.stages,
               s.use.access, accepted.data(), static_cast<uint32_t>(accepted.size()), s.layered, 1,
               usage_of(*plan->plan, index)},
              "slot");
    });
}

uint32_t penumbra_plan_output_count(const penumbra_plan* plan) {
    return plan ? static_cast<uint32_t>(plan->plan->outputs.size()) : 0;
}

penumbra_code penumbra_plan_output(const penumbra_plan* plan, uint32_t index, penumbra_slot* output,
                                   penumbra_error* error) {
    return guarded(error, [&] {
        const Plan& p = *given(plan, "plan").plan;
        const PlanOutput& o = one_of(p.outputs, index, "index", "the plan", "outputs");
        const PlanResource& r = p.resources[o.resource];
        const auto bytes = static_cast<uint32_t>(r.kind == PortKind::image ? 0 : r.buffer_bytes());
        write(output,
              {0, static_cast<penumbra_slot_kind>(r.kind), o.name.c_str(), format_of(r.kind, r.format),
               r.extent.width, r.extent.height, r.layers, bytes, VK_TRUE, VK_TRUE, o.use.stages, o.use.access,
               nullptr, 0, r.layered, r.levels, r.image_usage},
              "output");
    });
}

penumbra_code penumbra_plan_extent(const penumbra_plan* plan, const char* name, const uint32_t frame[2],
                                   uint32_t extent[2], penumbra_error* error) {
    return guarded(error, [&] {
        const Plan& p = *given(plan, "plan").plan;
        const Extent largest = p.extent, size{given(frame, "frame"), frame[1]};
        given(extent, "extent");
        if (size.width < 1 || size.height < 1 || size.width > largest.width || size.height > largest.height)
            misuse("frame",
                   "is 1x1 to " + std::to_string(largest.width) + "x" + std::to_string(largest.height));
        const auto put = [&](PortKind kind, Extent own, const std::optional<Follows>& follows) {
            if (kind != PortKind::image) misuse("name", std::string("\"") + name + "\" is no image");
            const Extent used = follows ? follows->at(size) : own;
            extent[0] = used.width;
            extent[1] = used.height;
        };
        if (const auto slot = p.slot(named(name, "name"))) {
            const HostSlot& s = p.slots[*slot];
            put(s.kind, s.extent, s.follows);
        } else if (const PlanOutput* output = p.output(name)) {
            const PlanResource& r = p.resources[output->resource];
            put(r.kind, r.extent, r.follows);
        } else {
            std::vector<std::string> names;
            for (const HostSlot& s : p.slots) names.push_back(s.name);
            for (const PlanOutput& o : p.outputs) names.push_back(o.name);
            misuse("name", std::string("the plan has no slot or output \"") + name + "\"" +
                               did_you_mean(name, names));
        }
    });
}

uint32_t penumbra_plan_pass_count(const penumbra_plan* plan) {
    return plan ? static_cast<uint32_t>(plan->plan->passes.size()) : 0;
}

penumbra_code penumbra_plan_pass(const penumbra_plan* plan, uint32_t index, penumbra_pass* pass,
                                 penumbra_error* error) {
    return guarded(error, [&] {
        const PlanPass& p = one_of(given(plan, "plan").plan->passes, index, "index", "the plan", "passes");
        const std::vector<const char*>& counters = plan->counters[index];
        write(pass,
              {0, static_cast<uint32_t>(p.params.size()), p.node.c_str(), p.type.c_str(), counters.data(),
               static_cast<uint32_t>(counters.size())},
              "pass");
    });
}

uint32_t penumbra_plan_member_count(const penumbra_plan* plan) {
    return plan ? static_cast<uint32_t>(plan->plan->members.size()) : 0;
}

penumbra_code penumbra_plan_member(const penumbra_plan* plan, uint32_t index, const char** member,
                                   penumbra_error* error) {
    return guarded(error, [&] {
        given(member, "member") =
            one_of(given(plan, "plan").plan->members, index, "index", "the plan", "members").c_str();
    });
}

uint32_t penumbra_plan_requirement_count(const penumbra_plan* plan) {
    return plan ? static_cast<uint32_t>(plan->needs.size()) : 0;
}

penumbra_code penumbra_plan_requirement(const penumbra_plan* plan, uint32_t index,
                                        penumbra_requirement* requirement, penumbra_error* error) {
    return guarded(error, [&] {
        const Requirement& r = one_of(given(plan, "plan").needs, index, "index", "the plan", "requirements");
        write(requirement, {0, kind_name(r.kind), r.name.c_str(), r.why.c_str(), r.value}, "requirement");
    });
}

penumbra_code penumbra_enable_feature(const char* name, VkPhysicalDeviceFeatures2* chain,
                                      penumbra_error* error) {
    return guarded(error, [&] {
        if (!enable({Requirement::Kind::feature, named(name, "name"), 0, {}}, given(chain, "chain")))
            misuse("chain", std::string("has no struct with the feature ") + name);
    });
}

penumbra_code penumbra_plan_unmet(const penumbra_plan* plan, const penumbra_device* device, uint32_t* count,
                                  penumbra_requirement* list, penumbra_error* error) {
    return guarded(error, [&] {
        const penumbra_plan& p = given(plan, "plan");
        const std::vector<Requirement> missing = unmet(*p.plan, handles_of(device));
        uint32_t& room = given(count, "count");
        const auto all = static_cast<uint32_t>(missing.size());
        if (list && room < all) misuse("count", std::to_string(all) + " requirements are not met");
        const uint32_t written = list ? all : 0;
        const uint32_t size = written ? size_of(list, "list") : 0;
        room = all;
        for (uint32_t i = 0; i < written; ++i) {
            const auto own = std::ranges::find_if(p.needs, [&](const Requirement& r) {  // whose text stays
                return r.kind == missing[i].kind && r.name == missing[i].name;
            });
            write<penumbra_requirement>(at(list, size, i), {size, kind_name(own->kind), own->name.c_str(),
                                                            own->why.c_str(), own->value});
        }
    });
}

penumbra_code penumbra_plan_memory(const penumbra_plan* plan, penumbra_memory* memory,
                                   penumbra_error* error) {
    return guarded(error, [&] {
        const MemoryReport& m = given(plan, "plan").plan->memory;
        write(memory, {0, m.heap_bytes, m.shared_bytes, m.persistent_bytes}, "memory");
    });
}
