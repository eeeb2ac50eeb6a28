// SPDX-License-Identifier: MIT
// The least Vulkan that runs one compute shader over host-visible buffers: for tests of shader functions that
// want to stand apart from the graph. Every failing call throws with its name.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/device/device.h"

namespace penumbra::test {

inline void check(VkResult result, const char* call) {
    if (result != VK_SUCCESS)
        throw std::runtime_error(std::string(call) + " failed: " + std::to_string(result));
}

class Compute {
  public:
    // `device` must outlive this; with validation on, its messages are the test's to look at.
    explicit Compute(Device& device)
        : physical_(device.physical()), device_(device.get()), queue_(device.queue()) {
        vkGetPhysicalDeviceProperties(physical_, &properties_);
        vkGetPhysicalDeviceMemoryProperties(physical_, &memory_);
        VkCommandPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
        pool_info.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
        pool_info.queueFamilyIndex = device.queue_family();
        check(vkCreateCommandPool(device_, &pool_info, nullptr, &pool_), "vkCreateCommandPool");
        VkCommandBufferAllocateInfo cmd_info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
        cmd_info.commandPool = pool_;
        cmd_info.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
        cmd_info.commandBufferCount = 1;
        check(vkAllocateCommandBuffers(device_, &cmd_info, &cmd_), "vkAllocateCommandBuffers");
        VkFenceCreateInfo fence_info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
        check(vkCreateFence(device_, &fence_info, nullptr, &fence_), "vkCreateFence");
    }
    Compute(const Compute&) = delete;
    Compute& operator=(const Compute&) = delete;

    ~Compute() {
        release_buffers();
        if (pipeline_) vkDestroyPipeline(device_, pipeline_, nullptr);
        if (pipeline_layout_) vkDestroyPipelineLayout(device_, pipeline_layout_, nullptr);
        if (set_layout_) vkDestroyDescriptorSetLayout(device_, set_layout_, nullptr);
        if (descriptors_) vkDestroyDescriptorPool(device_, descriptors_, nullptr);
        if (fence_) vkDestroyFence(device_, fence_, nullptr);
        if (pool_) vkDestroyCommandPool(device_, pool_, nullptr);
    }

    const VkPhysicalDeviceProperties& properties() const { return properties_; }

    // The shader's bindings 0.. in set 0 have these types: VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, or
    // VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER or _STORAGE_TEXEL_BUFFER (read as rgba32ui). Push constants:
    // one uint.
    void load(const std::string& spirv_file, std::span<const VkDescriptorType> bindings) {
        std::ifstream file(spirv_file, std::ios::binary);
        const std::string bytes((std::istreambuf_iterator<char>(file)), {});
        if (bytes.empty()) throw std::runtime_error("cannot read " + spirv_file);
        std::vector<uint32_t> words(bytes.size() / 4);
        std::memcpy(words.data(), bytes.data(), words.size() * 4);
        bindings_.assign(bindings.begin(), bindings.end());

        std::vector<VkDescriptorSetLayoutBinding> layout;
        for (uint32_t i = 0; i < bindings.size(); ++i)
            layout.push_back({i, bindings[i], 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
        VkDescriptorSetLayoutCreateInfo set_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
        set_info.bindingCount = uint32_t(layout.size());
        set_info.pBindings = layout.data();
        check(vkCreateDescriptorSetLayout(device_, &set_info, nullptr, &set_layout_),
              "vkCreateDescriptorSetLayout");
        const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, 4};
        VkPipelineLayoutCreateInfo layout_info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
        layout_info.setLayoutCount = 1;
        layout_info.pSetLayouts = &set_layout_;
        layout_info.pushConstantRangeCount = 1;
        layout_info.pPushConstantRanges = &push;
        check(vkCreatePipelineLayout(device_, &layout_info, nullptr, &pipeline_layout_),
              "vkCreatePipelineLayout");

        VkShaderModuleCreateInfo module_info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
        module_info.codeSize = words.size() * 4;
        module_info.pCode = words.data();
        VkShaderModule module = VK_NULL_HANDLE;
        check(vkCreateShaderModule(device_, &module_info, nullptr, &module), "vkCreateShaderModule");
        VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
        info.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                      nullptr,
                      0,
                      VK_SHADER_STAGE_COMPUTE_BIT,
                      module,
                      "main",
                      nullptr};
        info.layout = pipeline_layout_;
        const VkResult made =
            vkCreateComputePipelines(device_, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_);
        vkDestroyShaderModule(device_, module, nullptr);
        check(made, "vkCreateComputePipelines");

        const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 16},
                                              {VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, 16},
                                              {VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER, 16}};
        VkDescriptorPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
        pool_info.maxSets = 1;
        pool_info.poolSizeCount = uint32_t(std::size(sizes));
        pool_info.pPoolSizes = sizes;
        check(vkCreateDescriptorPool(device_, &pool_info, nullptr, &descriptors_), "vkCreateDescriptorPool");
        VkDescriptorSetAllocateInfo set{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
        set.descriptorPool = descriptors_;
        set.descriptorSetCount = 1;
        set.pSetLayouts = &set_layout_;
        check(vkAllocateDescriptorSets(device_, &set, &set_), "vkAllocateDescriptorSets");
    }

    // Fresh buffers with these contents for the bindings of load(), in order.
    void bind(std::span<const std::span<const std::byte>> contents) {
        release_buffers();
        for (uint32_t i = 0; i < contents.size(); ++i) {
            const bool texels = bindings_[i] != VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
            Buffer& buffer = buffers_.emplace_back();
            VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
            info.size = contents[i].size();
            info.usage =
                texels ? VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT
                       : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
            check(vkCreateBuffer(device_, &info, nullptr, &buffer.buffer), "vkCreateBuffer");
            VkMemoryRequirements needs;
            vkGetBufferMemoryRequirements(device_, buffer.buffer, &needs);
            VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
            allocation.allocationSize = needs.size;
            allocation.memoryTypeIndex = host_memory(needs.memoryTypeBits);
            check(vkAllocateMemory(device_, &allocation, nullptr, &buffer.memory), "vkAllocateMemory");
            check(vkBindBufferMemory(device_, buffer.buffer, buffer.memory, 0), "vkBindBufferMemory");
            check(vkMapMemory(device_, buffer.memory, 0, VK_WHOLE_SIZE, 0, &buffer.mapped), "vkMapMemory");
            std::memcpy(buffer.mapped, contents[i].data(), contents[i].size());

            VkDescriptorBufferInfo buffer_info{buffer.buffer, 0, VK_WHOLE_SIZE};
            if (texels) {
                VkBufferViewCreateInfo view{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
                view.buffer = buffer.buffer;
                view.format = VK_FORMAT_R32G32B32A32_UINT;
                view.range = VK_WHOLE_SIZE;
                check(vkCreateBufferView(device_, &view, nullptr, &buffer.view), "vkCreateBufferView");
            }
            VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
            write.dstSet = set_;
            write.dstBinding = i;
            write.descriptorCount = 1;
            write.descriptorType = bindings_[i];
            write.pBufferInfo = texels ? nullptr : &buffer_info;
            write.pTexelBufferView = texels ? &buffer.view : nullptr;
            vkUpdateDescriptorSets(device_, 1, &write, 0, nullptr);
        }
    }

    // Runs and waits. A second run() of the same buffers starts from what the first left.
    void run(uint32_t groups, uint32_t push) {
        const VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, nullptr, 0,
                                             nullptr};
        check(vkBeginCommandBuffer(cmd_, &begin), "vkBeginCommandBuffer");
        vkCmdBindPipeline(cmd_, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_);
        vkCmdBindDescriptorSets(cmd_, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_layout_, 0, 1, &set_, 0,
                                nullptr);
        vkCmdPushConstants(cmd_, pipeline_layout_, VK_SHADER_STAGE_COMPUTE_BIT, 0, 4, &push);
        vkCmdDispatch(cmd_, groups, 1, 1);
        const VkMemoryBarrier to_host{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_SHADER_WRITE_BIT,
                                      VK_ACCESS_HOST_READ_BIT};
        vkCmdPipelineBarrier(cmd_, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1,
                             &to_host, 0, nullptr, 0, nullptr);
        check(vkEndCommandBuffer(cmd_), "vkEndCommandBuffer");
        VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
        submit.commandBufferCount = 1;
        submit.pCommandBuffers = &cmd_;
        check(vkQueueSubmit(queue_, 1, &submit, fence_), "vkQueueSubmit");
        check(vkWaitForFences(device_, 1, &fence_, VK_TRUE, UINT64_MAX), "vkWaitForFences");
        check(vkResetFences(device_, 1, &fence_), "vkResetFences");
    }

    const void* mapped(uint32_t binding) const { return buffers_[binding].mapped; }

  private:
    struct Buffer {
        VkBuffer buffer = VK_NULL_HANDLE;
        VkDeviceMemory memory = VK_NULL_HANDLE;
        VkBufferView view = VK_NULL_HANDLE;
        void* mapped = nullptr;
    };

    uint32_t host_memory(uint32_t types) const {
        const VkMemoryPropertyFlags wanted =
            VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
        for (uint32_t i = 0; i < memory_.memoryTypeCount; ++i)
            if ((types >> i & 1) && (memory_.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
        throw std::runtime_error("no host-visible memory");
    }

    void release_buffers() {
        for (Buffer& b : buffers_) {
            if (b.view) vkDestroyBufferView(device_, b.view, nullptr);
            if (b.buffer) vkDestroyBuffer(device_, b.buffer, nullptr);
            if (b.memory) vkFreeMemory(device_, b.memory, nullptr);
        }
        buffers_.clear();
    }

    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkPhysicalDeviceProperties properties_{};
    VkPhysicalDeviceMemoryProperties memory_{};
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkCommandBuffer cmd_ = VK_NULL_HANDLE;
    VkFence fence_ = VK_NULL_HANDLE;
    VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
    VkPipelineLayout pipeline_layout_ = VK_NULL_HANDLE;
    VkPipeline pipeline_ = VK_NULL_HANDLE;
    VkDescriptorPool descriptors_ = VK_NULL_HANDLE;
    VkDescriptorSet set_ = VK_NULL_HANDLE;
    std::vector<VkDescriptorType> bindings_;
    std::vector<Buffer> buffers_;
};

}  // namespace penumbra::test
