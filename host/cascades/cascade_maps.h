// SPDX-License-Identifier: MIT
// The sun's shadow maps on the device, of the very triangles that rays meet. Per texel and cascade:
// - maps (d32): depth of the nearest surface at the texel's centre, an ordinary shadow map;
// - bounds (rgba32f), made only where they are wanted: least depth of any surface that touches the texel, and
//   a plane below all of them (its depth at the texel's centre, its slope); metres. 1e30: no surface.
// A cascade is drawn only where it or the triangles have moved since.
#pragma once

#include <optional>

#include "host/cascades/cascade_bounds.h"
#include "host/cascades/cascade_fit.h"
#include "host/device/gpu.h"
#include "host/scene/scene.h"

namespace penumbra {

// All that one layer's contents depend on beside the triangles.
struct CascadeView {
    glm::dvec3 u{0}, v{0}, away{0};
    CascadeArea area;
    double near_m = 0, depth_m = 0;
    bool empty = true;  // beyond the fit's cascades
    friend bool operator==(const CascadeView&, const CascadeView&) = default;
};

class CascadeMaps {
  public:
    // `scene` must outlive the maps.
    CascadeMaps(Device& device, const Scene& scene, uint32_t size, uint32_t layers, bool with_bounds);

    // Takes the triangles of another frame; nothing on the device may be reading them.
    void update(double frame);
    // How many cascades had to be drawn. Afterwards the images are in SHADER_READ_ONLY_OPTIMAL, visible to
    // compute shaders and copies. fit.count is at most the layers, fit.size the size.
    uint32_t record(VkCommandBuffer commands, const CascadeFit& fit);

    const GpuImage& maps() const { return maps_; }
    const GpuImage& bounds() const { return bounds_; }
    static constexpr VkFormat maps_format = VK_FORMAT_D32_SFLOAT;
    static constexpr VkFormat bounds_format = CascadeBounds::format;

  private:
    struct Layer {
        Owned<VkImageView> map, slopes, bounds;
        std::optional<CascadeView> drawn;  // what the images show; nothing: they must be drawn
    };
    void draw(VkCommandBuffer commands, const CascadeFit& fit, uint32_t layer) const;

    Device& device_;
    const Scene& scene_;
    bool with_bounds_;
    GpuBuffer triangles_;
    uint32_t triangle_count_ = 0;
    GpuImage maps_, slopes_, bounds_;
    std::vector<Layer> layers_;
    DescriptorSets bound_;
    Owned<VkPipelineLayout> layout_;
    Owned<VkPipeline> pipeline_;
    std::optional<CascadeBounds> bounds_drawing_;
};

}  // namespace penumbra
