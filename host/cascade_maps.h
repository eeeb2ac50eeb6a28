// SPDX-License-Identifier: MIT
// The sun's shadow maps on the device, of the very triangles that rays meet. Per texel and cascade:
// - maps (d32): depth of the nearest surface at the texel's centre, an ordinary shadow map;
// - bounds (rgba32f), made only where they are wanted: least depth of any surface that touches the texel, and
//   a plane below all of them (its depth at the texel's centre, its slope); metres. 1e30: no surface.
// Nothing is drawn where neither the cascades nor the triangles have moved.
#pragma once

#include <optional>

#include "host/cascade_fit.h"
#include "host/gpu.h"
#include "host/scene.h"

namespace penumbra {

class CascadeMaps {
  public:
    // `scene` must outlive the maps.
    CascadeMaps(Device& device, const Scene& scene, uint32_t size, uint32_t layers, bool with_bounds);

    // Takes the triangles of another frame; nothing on the device may be reading them.
    void update(double frame);
    // True where something had to be drawn. Afterwards the images are in SHADER_READ_ONLY_OPTIMAL, visible to
    // compute shaders and copies. fit.count is at most the layers, fit.size the size.
    bool record(VkCommandBuffer commands, const CascadeFit& fit);

    const GpuImage& maps() const { return maps_; }
    const GpuImage& bounds() const { return bounds_; }
    static constexpr VkFormat maps_format = VK_FORMAT_D32_SFLOAT;
    static constexpr VkFormat bounds_format = VK_FORMAT_R32G32B32A32_SFLOAT;

  private:
    struct Layer {
        Owned<VkImageView> map, slopes, bounds;
    };
    void make_descriptors();
    void write_descriptors();
    void make_pipelines();
    Owned<VkPipeline> make_pipeline(bool bounds) const;
    void draw(VkCommandBuffer commands, const CascadeFit& fit, uint32_t layer, bool bounds) const;

    Device& device_;
    const Scene& scene_;
    bool with_bounds_;
    GpuBuffer triangles_;
    uint32_t triangle_count_ = 0;
    GpuImage maps_, slopes_, bounds_;
    std::vector<Layer> layers_;
    Owned<VkSampler> sampler_;
    Owned<VkDescriptorSetLayout> set_layout_;
    Owned<VkDescriptorPool> pool_;
    VkDescriptorSet set_ = VK_NULL_HANDLE;
    Owned<VkPipelineLayout> layout_;
    Owned<VkPipeline> map_pipeline_, bounds_pipeline_;
    std::optional<CascadeFit> drawn_;  // what the images show; nothing: they must be drawn
};

}  // namespace penumbra
