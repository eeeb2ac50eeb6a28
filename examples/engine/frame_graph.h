// SPDX-License-Identifier: MIT
// The engine's frame graph: passes say how they use which image; the barriers follow.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "memory.h"

namespace engine {

constexpr Access copy_target{VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                             VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, true};
constexpr Access copy_source{VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT,
                             VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, false};

class FrameGraph {
  public:
    std::map<std::string, Image> images;
    void add(std::map<std::string, Access> uses, std::function<void(VkCommandBuffer)> record) {
        passes_.push_back({std::move(uses), std::move(record)});
    }
    void execute(VkCommandBuffer cmd) {
        for (const Pass& pass : passes_) {
            std::vector<VkImageMemoryBarrier2> barriers;
            for (const auto& [name, use] : pass.uses) {
                Image& image = images.at(name);
                if (!use.write && !image.last.write && use.layout == image.last.layout) {
                    image.last.stages |= use.stages;
                    continue;
                }
                VkImageMemoryBarrier2 b{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
                b.srcStageMask = image.last.stages;
                b.srcAccessMask = image.last.write ? image.last.access : VkAccessFlags2{};
                b.dstStageMask = use.stages;
                b.dstAccessMask = use.access;
                b.oldLayout = use.write ? VK_IMAGE_LAYOUT_UNDEFINED : image.last.layout;
                b.newLayout = use.layout;
                b.srcQueueFamilyIndex = b.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
                b.image = image.handle;
                b.subresourceRange = {image.aspect, 0, 1, 0, image.layers};
                barriers.push_back(b);
                image.last = use;
            }
            VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
            info.imageMemoryBarrierCount = static_cast<uint32_t>(barriers.size());
            info.pImageMemoryBarriers = barriers.data();
            if (!barriers.empty()) vkCmdPipelineBarrier2(cmd, &info);
            pass.record(cmd);
        }
        passes_.clear();
    }

  private:
    struct Pass {
        std::map<std::string, Access> uses;
        std::function<void(VkCommandBuffer)> record;
    };
    std::vector<Pass> passes_;
};

}  // namespace engine
