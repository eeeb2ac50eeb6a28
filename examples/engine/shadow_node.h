// SPDX-License-Identifier: MIT
// Penumbra as a node of the engine's graph: its slots are the node's ports, and its memory is the engine's.
#pragma once

#include <penumbra/graph.h>
#include <penumbra/shadow_nodes.h>

#include <memory>

#include "frame_graph.h"

namespace engine {

class ShadowNode {
  public:
    ShadowNode(const std::string& file, pen::Extent extent, uint32_t frames_in_flight) {
        const pen::DeviceHandles handles{
            instance, physical, device, family, vkGetInstanceProcAddr, memory_of_the_engine(), true};
        pen::Diagnostics errors;
        const auto pipeline = pen::load_pipeline(file, {}, errors);
        const auto checked = pipeline ? pen::check(*pipeline, pen::shadow_nodes(), errors) : std::nullopt;
        pen::Target target{.extent = extent,
                           .facts = {{"alpha", false}, {"translucent", false}},
                           .device = pen::device_table(handles)};
        pen::CompileOptions options;
        options.outputs["visibility"].host_image = true;  // the engine's graph owns what it passes on
        if (checked)
            for (const pen::HostInput& input : checked->inputs) {
                if (input.name == "normal") target.inputs["normal"] = {pen::Format::rgba32f, extent};
                if (input.name == "moved_boxes")
                    target.left_out.insert(input.name);  // the camera hardly ever stands
            }
        auto compiled = checked ? pen::compile(*checked, target, options, errors) : std::nullopt;
        if (!compiled) std::fputs(errors.text().c_str(), stderr), std::exit(2);
        plan = std::make_shared<const pen::Plan>(std::move(*compiled));
        view_ = std::make_unique<pen::View>(std::make_shared<const pen::Program>(handles, plan),
                                            pen::ViewOptions{.frames_in_flight = frames_in_flight});
        externals_ = std::make_unique<pen::Externals>(*plan);
    }

    // What the engine's graph is told: the plan knows how each slot is used, and in which layout.
    std::map<std::string, Access> uses() const {
        std::map<std::string, Access> uses;
        for (const pen::HostSlot& slot : plan->slots)
            if (slot.kind == pen::PortKind::image)
                uses[slot.name] = {
                    slot.use.stages, slot.use.access,
                    slot.output ? VK_IMAGE_LAYOUT_GENERAL : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                    slot.output};
        return uses;
    }

    void record(VkCommandBuffer cmd, const pen::FrameDescription& frame, const FrameGraph& graph,
                const std::map<std::string, Buffer>& buffers) {
        for (const pen::HostSlot& slot : plan->slots) {
            pen::SlotBinding& binding = (*externals_)[slot.name];
            if (slot.kind != pen::PortKind::image) {
                binding = {.texels = buffers.at(slot.name).texels, .buffer = buffers.at(slot.name).handle};
                continue;
            }
            const Image& image = graph.images.at(slot.name);
            binding = {.image = image.view};
            // The graph has brought it to `uses()`, and takes it from there.
            if (slot.output)
                binding.handover = pen::Handover{.image = image.handle,
                                                 .stages_before = slot.use.stages,
                                                 .layout_after = VK_IMAGE_LAYOUT_GENERAL};
        }
        if (const auto error = pen::attempt([&] { view_->record(cmd, frame, *externals_); }))
            std::fprintf(stderr, "%s\n", pen::to_string(*error).c_str()), std::exit(1);
    }

    std::shared_ptr<const pen::Plan> plan;

  private:
    std::unique_ptr<pen::View> view_;
    std::unique_ptr<pen::Externals> externals_;
};

}  // namespace engine
