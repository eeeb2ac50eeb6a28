// SPDX-License-Identifier: MIT
// Base colour textures on the device, each with its mip chain, and one descriptor set per texture. Slot 0 is
// a white texel for materials without one.
#pragma once

#include <span>
#include <vector>

#include "host/device/descriptor_sets.h"
#include "host/models/model.h"

namespace penumbra {

class TextureSets {
  public:
    TextureSets(Device& device, std::span<const Texture> textures);

    VkDescriptorSetLayout layout() const { return sets_.layout.get(); }
    // The set of a material's texture; -1 and unreadable textures: white.
    VkDescriptorSet set(int texture) const {
        return sets_.sets[texture < 0 ? 0 : 1 + static_cast<size_t>(texture)];
    }

  private:
    std::vector<GpuImage> images_;
    Owned<VkSampler> sampler_;
    DescriptorSets sets_;
};

}  // namespace penumbra
