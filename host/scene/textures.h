// SPDX-License-Identifier: MIT
// The materials' textures on the device, each with its mip chain, and one descriptor set per material: base
// colour, metallic-roughness, emissive. A white texel stands for those that a material does not have.
#pragma once

#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/device/descriptor_sets.h"
#include "host/models/model.h"

namespace penumbra {

// Of textures that MaterialTextures draws white, since the device's images have at most `most_texels` along
// an axis.
std::vector<std::string> texture_warnings(std::span<const Material> materials,
                                          std::span<const Texture> textures, bool surfaces,
                                          uint32_t most_texels);

class MaterialTextures {
  public:
    // `surfaces`: the second and third too; they are white without.
    MaterialTextures(Device& device, std::span<const Material> materials, std::span<const Texture> textures,
                     bool surfaces);

    VkDescriptorSetLayout layout() const { return sets_.layout.get(); }
    // -1, no material: white.
    VkDescriptorSet set(int material) const { return sets_.sets[static_cast<size_t>(1 + material)]; }
    // Whether any of a material's textures is not just white.
    bool textured(int material) const { return textured_[static_cast<size_t>(1 + material)]; }

  private:
    std::map<std::pair<int, bool>, GpuImage>
        images_;  // by texture (-1: white) and whether it is sRGB-encoded
    Owned<VkSampler> sampler_;
    DescriptorSets sets_;
    std::vector<bool> textured_;  // of sets_.sets
};

}  // namespace penumbra
