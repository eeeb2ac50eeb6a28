// SPDX-License-Identifier: MIT
#include "app/host_slots.h"

#include <algorithm>
#include <cstring>

#include "host/scene/scene_alpha.h"

namespace penumbra {
namespace {

struct Brought {
    const GBufferImages& images;
    const HostResources& resources;

    const HostBlocks& blocks() const { return *resources.blocks; }
    const GpuTexels& alpha_uv() const {
        return resources.bvh ? resources.bvh->alpha_uv() : resources.tlas->alpha_uv();
    }
    const GpuTexels& alpha_map() const {
        return resources.bvh ? resources.bvh->alpha_map() : resources.tlas->alpha_map();
    }
};

struct KnownSlot {
    std::string_view name;
    void (*bind)(const Brought&, SlotBinding&);
};

// A pipeline names "scene", which stands for the slots of a trace backend; those that end in "_words" are for
// devices whose texel buffers are small.
constexpr KnownSlot known_slots[] = {
    {"depth", [](const Brought& of, SlotBinding& b) { b.image = of.images.depth.view.get(); }},
    {"normal", [](const Brought& of, SlotBinding& b) { b.image = of.images.normal.view.get(); }},
    {"motion", [](const Brought& of, SlotBinding& b) { b.image = of.images.motion.view.get(); }},
    {"albedo", [](const Brought& of, SlotBinding& b) { b.image = of.images.albedo.view.get(); }},
    {"material", [](const Brought& of, SlotBinding& b) { b.image = of.images.material.view.get(); }},
    {"emissive", [](const Brought& of, SlotBinding& b) { b.image = of.images.emissive.view.get(); }},
    {"sun", [](const Brought& of, SlotBinding& b) { b.buffer = of.blocks().sun.get(); }},
    {"sun_prev", [](const Brought& of, SlotBinding& b) { b.buffer = of.blocks().sun_prev.get(); }},
    {"light", [](const Brought& of, SlotBinding& b) { b.buffer = of.blocks().light.get(); }},
    {"light_prev", [](const Brought& of, SlotBinding& b) { b.buffer = of.blocks().light_prev.get(); }},
    {"lights", [](const Brought& of, SlotBinding& b) { b.texels = of.blocks().lights.view.get(); }},
    {"emitters", [](const Brought& of, SlotBinding& b) { b.texels = of.blocks().emitters.view.get(); }},
    {"moved_boxes", [](const Brought& of, SlotBinding& b) { b.buffer = of.blocks().moved_boxes.get(); }},
    {"scene", [](const Brought& of, SlotBinding& b) { b.buffer = of.blocks().scene.get(); }},
    {"scene.nodes",
     [](const Brought& of, SlotBinding& b) { b.texels = of.resources.bvh->nodes().view.get(); }},
    {"scene.nodes_words",
     [](const Brought& of, SlotBinding& b) { b.buffer = of.resources.bvh->nodes().buffer.get(); }},
    {"scene.leaves",
     [](const Brought& of, SlotBinding& b) { b.texels = of.resources.bvh->leaves().view.get(); }},
    {"scene.leaves_words",
     [](const Brought& of, SlotBinding& b) { b.buffer = of.resources.bvh->leaves().buffer.get(); }},
    {"scene.alpha_uv", [](const Brought& of, SlotBinding& b) { b.texels = of.alpha_uv().view.get(); }},
    {"scene.alpha_uv_words",
     [](const Brought& of, SlotBinding& b) { b.buffer = of.alpha_uv().buffer.get(); }},
    {"scene.alpha_map", [](const Brought& of, SlotBinding& b) { b.texels = of.alpha_map().view.get(); }},
    {"scene.alpha_map_words",
     [](const Brought& of, SlotBinding& b) { b.buffer = of.alpha_map().buffer.get(); }},
    {"scene.tlas", [](const Brought& of, SlotBinding& b) { b.structure = of.resources.tlas->get(); }},
    {"neighbours",
     [](const Brought& of, SlotBinding& b) { b.buffer = of.resources.bvh->neighbours().get(); }},
    {"surfaces", [](const Brought& of, SlotBinding& b) { b.texels = of.resources.surfaces->surfaces(); }},
    {"surface_texels", [](const Brought& of, SlotBinding& b) { b.texels = of.resources.surfaces->texels(); }},
    {"translucents", [](const Brought& of, SlotBinding& b) { b.texels = of.resources.translucents->tree(); }},
    {"translucent_texels",
     [](const Brought& of, SlotBinding& b) { b.texels = of.resources.translucents->texels(); }},
    {"environment", [](const Brought& of, SlotBinding& b) { b.image = of.resources.environment.view.get(); }},
    {"environment_lots",
     [](const Brought& of, SlotBinding& b) { b.texels = of.resources.environment_lots.view.get(); }},
    {"cascades", [](const Brought& of, SlotBinding& b) { b.buffer = of.blocks().cascades.get(); }},
    {"cascade_maps",
     [](const Brought& of, SlotBinding& b) { b.image = of.resources.cascade_maps->maps().view.get(); }},
    {"cascade_bounds",
     [](const Brought& of, SlotBinding& b) { b.image = of.resources.cascade_maps->bounds().view.get(); }},
};

const KnownSlot* known_slot(std::string_view name) {
    const auto found = std::ranges::find(known_slots, name, &KnownSlot::name);
    return found == std::end(known_slots) ? nullptr : &*found;
}

std::string previous_slot_of_light(const std::string& light) {
    return "light_prev_" + light;
}

// Optional inputs that are left out until a session has something to bring.
bool brought_if_there(std::string_view name) {
    return name == "lights" || name == "emitters" || name == "environment_lots" || name == "moved_boxes";
}

template <typename Block>
GpuBuffer block(Device& device, const char* name) {
    return make_host_buffer(device, sizeof(Block), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, name);
}

void put(const GpuBuffer& buffer, const auto& value) {
    std::memcpy(buffer.mapped, &value, sizeof value);
}

}  // namespace

HostBlocks::HostBlocks(Device& device, const std::vector<std::string>& names, size_t count, size_t emitting)
    : sun(block<blocks::Sun>(device, "the sun")),
      sun_prev(block<blocks::Sun>(device, "the previous frame's sun")),
      light(block<blocks::Light>(device, "the light")),
      light_prev(block<blocks::Light>(device, "the previous frame's light")),
      scene(block<blocks::Scene>(device, "the scene block")),
      cascades(block<blocks::Cascades>(device, "the cascades block")),
      moved_boxes(block<blocks::MovedBoxes>(device, "the boxes of what has moved")) {
    for (const std::string& name : names)
        own_lights.push_back({block<blocks::Light>(device, name.c_str()),
                              block<blocks::Light>(device, "the previous frame's light")});
    if (count)
        lights = make_host_texels(device, count * sizeof(blocks::Light), VK_FORMAT_R32G32B32A32_UINT,
                                  "the lights");
    if (emitting)
        emitters = make_host_texels(device, 2 * emitting * sizeof(Texel), VK_FORMAT_R32G32B32A32_UINT,
                                    "the bodies that shine");
}

void HostBlocks::write(const StandaloneFrame& frame) {
    put(sun, frame.sun);
    put(sun_prev, frame.sun_prev);
    put(light, frame.light);
    put(light_prev, frame.light_prev);
    for (size_t i = 0; i < own_lights.size(); ++i) {
        put(own_lights[i].now, frame.lights[i]);
        put(own_lights[i].before, frame.lights_prev[i]);
    }
    if (lights.buffer.mapped)
        std::memcpy(lights.buffer.mapped, frame.lights.data(), frame.lights.size() * sizeof(blocks::Light));
    if (emitters.buffer.mapped)
        std::memcpy(emitters.buffer.mapped, frame.emitters.data(), frame.emitters.size() * sizeof(Texel));
    put(scene, frame.scene);
}

void HostBlocks::write_moved(const blocks::MovedBoxes& boxes) {
    put(moved_boxes, boxes);
}

void HostBlocks::write_cascades(const blocks::Cascades& block) {
    put(cascades, block);
}

std::string slot_of_light(const std::string& light) {
    return "light_" + light;
}

bool standalone_has_input(std::string_view name) {
    return name.starts_with(slot_of_light("")) || known_slot(name);
}

Target standalone_target(const CheckedPipeline& pipeline, const DeviceTable& device,
                         std::array<uint32_t, 2> size, const Facts& facts, Extent cascade_extent,
                         uint32_t cascades) {
    Target target;
    target.extent = {size[0], size[1]};
    target.facts = facts;
    target.device = device;
    target.inputs = {{"depth", {Format::r32f, target.extent}},
                     {"normal", {Format::rgba32f, target.extent}},
                     {"motion", {Format::rgba16f, target.extent}},
                     {"albedo", {Format::rgba8, target.extent}},
                     {"material", {Format::rg8, target.extent}},
                     {"emissive", {Format::rgba16f, target.extent}},
                     {"environment", {Format::rgba32f, {4, 1024}}},
                     {"lights", {Format::rgba32ui, {5, 1}}},
                     {"cascade_maps", {Format::d32, cascade_extent, cascades}},
                     {"cascade_bounds", {Format::rgba32f, cascade_extent, cascades}}};
    std::erase_if(target.inputs, [&](const auto& input) { return !pipeline.input(input.first); });
    for (const HostInput& input : pipeline.inputs)
        if (input.optional && (!standalone_has_input(input.name) || brought_if_there(input.name)))
            target.left_out.insert(input.name);
    return target;
}

bool reads(const Plan& plan, std::string_view slot) {
    return std::ranges::find(plan.slots, slot, &HostSlot::name) != plan.slots.end();
}

std::vector<std::string> unknown_inputs_left_out(const CheckedPipeline& pipeline) {
    std::vector<std::string> known, lines;
    for (const KnownSlot& slot : known_slots)
        if (slot.name.find('.') == slot.name.npos) known.emplace_back(slot.name);
    for (const HostInput& input : pipeline.inputs)
        if (input.optional && !standalone_has_input(input.name))
            lines.push_back(to_string(Diagnostic{input.place, "inputs." + input.name,
                                                 "the standalone host has no such input, and leaves it out" +
                                                     did_you_mean(input.name, known)}));
    return lines;
}

void check_slots(const Plan& plan, const std::string& file, const std::vector<std::string>& own_lights,
                 const Scene& scene, Diagnostics& diagnostics) {
    const auto is_alpha = [](const HostSlot& slot) { return slot.name.starts_with("scene.alpha_"); };
    if (std::ranges::any_of(plan.slots, is_alpha) && !has_alpha(scene))
        diagnostics.add({file}, "facts.alpha",
                        "taken as true, and no triangle of the scene has a texture with holes");
    std::vector<std::string> known;
    for (const KnownSlot& slot : known_slots) known.emplace_back(slot.name);
    for (const std::string& light : own_lights) {
        known.push_back(slot_of_light(light));
        known.push_back(previous_slot_of_light(light));
    }
    for (const HostSlot& slot : plan.slots)
        if (std::ranges::find(known, slot.name) == known.end())
            diagnostics.add({file}, "inputs." + slot.name,
                            "the standalone host has no such input" + did_you_mean(slot.name, known));
}

std::vector<SlotBinding> bind_slots(const Plan& plan, const StandaloneHost& host,
                                    const HostResources& resources) {
    const Brought brought{host.images(), resources};
    const std::vector<HostBlocks::OwnLight>& own = resources.blocks->own_lights;
    const auto own_light = [&](const std::string& slot) {
        for (size_t i = 0; i < own.size(); ++i) {
            if (slot == slot_of_light(host.light_names()[i])) return own[i].now.get();
            if (slot == previous_slot_of_light(host.light_names()[i])) return own[i].before.get();
        }
        return VkBuffer{VK_NULL_HANDLE};
    };
    std::vector<SlotBinding> bindings;
    for (const HostSlot& slot : plan.slots) {
        SlotBinding& binding = bindings.emplace_back();
        binding.buffer = own_light(slot.name);  // first: a light may be called "prev"
        if (binding.buffer) continue;
        if (const KnownSlot* known = known_slot(slot.name)) known->bind(brought, binding);
    }
    return bindings;
}

}  // namespace penumbra
