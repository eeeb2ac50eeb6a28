// SPDX-License-Identifier: MIT
// One compute shader over host-visible buffers: for tests of shader functions that want to stand apart from
// the graph. Every failing call throws with its name.
#pragma once

#include <cstring>
#include <fstream>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/device/descriptor_sets.h"
#include "host/device/shader_module.h"

namespace penumbra::test {

class Compute {
  public:
    // `device` must outlive this; with validation on, its messages are the test's to look at.
    explicit Compute(Device& device) : device_(device) {}

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
        const char* what = spirv_file.c_str();
        sets_ = make_descriptor_sets(device_, layout, 1, what);
        const VkDescriptorSetLayout sets[] = {sets_.layout.get()};
        layout_ = make_pipeline_layout(device_, sets, VK_SHADER_STAGE_COMPUTE_BIT, 4, what);
        pipeline_ = make_compute_pipeline(device_, words, layout_.get(), what);
    }

    // Fresh buffers with these contents for the bindings of load(), in order.
    void bind(std::span<const std::span<const std::byte>> contents) {
        buffers_.clear();
        for (uint32_t i = 0; i < contents.size(); ++i) {
            const VkDeviceSize bytes = contents[i].size();
            if (bindings_[i] == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER) {
                buffers_.push_back(
                    {make_host_buffer(device_, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, "a test's"), {}});
                write_buffer(device_, sets_.sets[0], i, buffers_[i].buffer);
            } else {
                buffers_.push_back(make_host_texels(device_, bytes, VK_FORMAT_R32G32B32A32_UINT, "a test's"));
                const VkBufferView view = buffers_[i].view.get();
                VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
                write.dstSet = sets_.sets[0];
                write.dstBinding = i;
                write.descriptorCount = 1;
                write.descriptorType = bindings_[i];
                write.pTexelBufferView = &view;
                vkUpdateDescriptorSets(device_.get(), 1, &write, 0, nullptr);
            }
            std::memcpy(buffers_[i].buffer.mapped, contents[i].data(), contents[i].size());
        }
    }

    // Runs and waits. A second run() of the same buffers starts from what the first left.
    void run(uint32_t groups, uint32_t push) {
        device_.run([&](VkCommandBuffer cmd) {
            vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
            vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), 0, 1,
                                    sets_.sets.data(), 0, nullptr);
            vkCmdPushConstants(cmd, layout_.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0, 4, &push);
            vkCmdDispatch(cmd, groups, 1, 1);
            const VkMemoryBarrier to_host{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr,
                                          VK_ACCESS_SHADER_WRITE_BIT, VK_ACCESS_HOST_READ_BIT};
            vkCmdPipelineBarrier(cmd, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1,
                                 &to_host, 0, nullptr, 0, nullptr);
        });
    }

    const void* mapped(uint32_t binding) const { return buffers_[binding].buffer.mapped; }

  private:
    Device& device_;
    std::vector<VkDescriptorType> bindings_;
    DescriptorSets sets_;
    Owned<VkPipelineLayout> layout_;
    Owned<VkPipeline> pipeline_;
    std::vector<GpuTexels> buffers_;  // without a view where they are storage buffers
};

}  // namespace penumbra::test
