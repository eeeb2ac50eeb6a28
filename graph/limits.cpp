// SPDX-License-Identifier: MIT
// Each limit with the pass or the resource that needs the most of it.
#include "graph/limits.h"

#include <algorithm>

#include "graph/workgroup_memory.h"
#include "penumbra/frame_block.h"

namespace penumbra {
namespace {

class Needs {
  public:
    void of(const std::string& why, bool pass) {
        why_ = why;
        pass_ = pass;
    }
    void at_least(std::string_view name, uint64_t value) {
        if (value == 0) return;
        const auto same = std::ranges::find(list, name, &NeededLimit::name);
        NeededLimit& need = same != list.end() ? *same : list.emplace_back(NeededLimit{std::string(name)});
        if (value <= need.value) return;
        need.value = value;
        need.why = why_;
        need.pass = pass_;
    }
    void image(Extent extent, uint32_t layers) {
        at_least("maxImageDimension2D", std::max(extent.width, extent.height));
        at_least("maxImageArrayLayers", layers);
    }
    std::vector<NeededLimit> list;

  private:
    std::string why_;
    bool pass_ = false;
};

void need_of_pass(const Plan& plan, const PlanPass& pass, Needs& needs) {
    std::map<VkDescriptorType, uint32_t> count;
    for (const PlanBinding& b : pass.bindings) ++count[b.type];
    needs.at_least("maxPerStageDescriptorSampledImages", count[VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER] +
                                                             count[VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER]);
    needs.at_least("maxPerStageDescriptorSamplers", count[VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER]);
    needs.at_least("maxPerStageDescriptorStorageImages",
                   count[VK_DESCRIPTOR_TYPE_STORAGE_IMAGE] + count[VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER]);
    needs.at_least("maxPerStageDescriptorStorageBuffers", count[VK_DESCRIPTOR_TYPE_STORAGE_BUFFER]);
    needs.at_least("maxPerStageDescriptorUniformBuffers", count[VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER]);
    needs.at_least("maxPerStageResources", pass.bindings.size());
    needs.at_least("maxPushConstantsSize", pass.push.size());
    needs.at_least("maxComputeWorkGroupInvocations",
                   uint64_t{pass.constants[0]} * pass.constants[1] * pass.constants[2]);
    constexpr const char* sizes[] = {"maxComputeWorkGroupSize[0]", "maxComputeWorkGroupSize[1]",
                                     "maxComputeWorkGroupSize[2]"};
    constexpr const char* counts[] = {"maxComputeWorkGroupCount[0]", "maxComputeWorkGroupCount[1]",
                                      "maxComputeWorkGroupCount[2]"};
    for (size_t axis = 0; axis < 3; ++axis) {
        needs.at_least(sizes[axis], pass.constants[axis]);
        needs.at_least(counts[axis], pass.groups[axis]);
    }
    if (pass.module)
        needs.at_least("maxComputeSharedMemorySize",
                       workgroup_bytes(plan.modules[*pass.module], pass.constants));
}

}  // namespace

std::vector<NeededLimit> needed_limits(const Plan& plan) {
    Needs needs;
    for (const PlanPass& pass : plan.passes) {
        if (pass.kind != PassKind::compute) continue;
        needs.of(pass.node, true);
        need_of_pass(plan, pass, needs);
    }
    for (const PlanResource& r : plan.resources) {
        needs.of(r.names.front(), false);
        if (r.kind == PortKind::image) needs.image(r.extent, r.layers);
        if (r.kind != PortKind::image || r.row_bytes)
            needs.at_least("maxStorageBufferRange", r.buffer_bytes());
        if (r.buffer_usage & VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT)
            needs.at_least("maxTexelBufferElements", r.count);
    }
    for (const HostSlot& slot : plan.slots) {
        needs.of(slot.name, false);
        if (slot.kind == PortKind::image) needs.image(slot.extent, slot.layers);
        if (slot.kind == PortKind::block) needs.at_least("maxUniformBufferRange", slot.bytes);
    }
    for (const PlanTable& table : plan.tables) {
        needs.of(table.name, false);
        needs.image({table.extent[0], table.extent[1]}, 1);
    }
    needs.of("the frame block", false);
    needs.at_least("maxUniformBufferRange", sizeof(FrameBlock));
    needs.of("the heap", false);
    for (const Heap& heap : plan.heaps) needs.at_least("maxMemoryAllocationSize", heap.bytes);
    return std::move(needs.list);
}

std::map<std::string, uint64_t> limits_of(VkPhysicalDevice device, const VulkanFunctions& vk) {
    VkPhysicalDeviceMaintenance3Properties allocation{
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES};
    VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &allocation};
    vk.vkGetPhysicalDeviceProperties2(device, &properties);
    const VkPhysicalDeviceLimits& l = properties.properties.limits;
    return {{"maxPerStageDescriptorSampledImages", l.maxPerStageDescriptorSampledImages},
            {"maxPerStageDescriptorSamplers", l.maxPerStageDescriptorSamplers},
            {"maxPerStageDescriptorStorageImages", l.maxPerStageDescriptorStorageImages},
            {"maxPerStageDescriptorStorageBuffers", l.maxPerStageDescriptorStorageBuffers},
            {"maxPerStageDescriptorUniformBuffers", l.maxPerStageDescriptorUniformBuffers},
            {"maxPerStageResources", l.maxPerStageResources},
            {"maxPushConstantsSize", l.maxPushConstantsSize},
            {"maxComputeWorkGroupInvocations", l.maxComputeWorkGroupInvocations},
            {"maxComputeWorkGroupSize[0]", l.maxComputeWorkGroupSize[0]},
            {"maxComputeWorkGroupSize[1]", l.maxComputeWorkGroupSize[1]},
            {"maxComputeWorkGroupSize[2]", l.maxComputeWorkGroupSize[2]},
            {"maxComputeWorkGroupCount[0]", l.maxComputeWorkGroupCount[0]},
            {"maxComputeWorkGroupCount[1]", l.maxComputeWorkGroupCount[1]},
            {"maxComputeWorkGroupCount[2]", l.maxComputeWorkGroupCount[2]},
            {"maxImageDimension2D", l.maxImageDimension2D},
            {"maxImageArrayLayers", l.maxImageArrayLayers},
            {"maxTexelBufferElements", l.maxTexelBufferElements},
            {"maxStorageBufferRange", l.maxStorageBufferRange},
            {"maxUniformBufferRange", l.maxUniformBufferRange},
            {"maxComputeSharedMemorySize", l.maxComputeSharedMemorySize},
            {"maxMemoryAllocationSize", allocation.maxMemoryAllocationSize}};
}

}  // namespace penumbra
