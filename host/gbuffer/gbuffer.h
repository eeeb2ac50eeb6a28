// SPDX-License-Identifier: MIT
// Rasterises the host inputs depth, normal, motion and albedo (conventions in the formats' table of host
// inputs). Transforms are made on the CPU in double precision, relative to the camera, and rounded once per
// draw.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <map>
#include <span>
#include <vector>

#include "host/device/descriptor_sets.h"
#include "host/device/gpu.h"
#include "host/gbuffer/gbuffer_pipeline.h"
#include "host/scene/geometry.h"
#include "host/scene/scene.h"
#include "host/scene/textures.h"
#include "penumbra/frame_block.h"

namespace penumbra {

struct GBufferImages {
    GpuImage depth;   // r32f: near / view depth, 0 = sky
    GpuImage normal;  // rgba32f: a receiver's horizon is as exact as its normal
    GpuImage motion;  // rgba16f
    GpuImage albedo;  // rgba8
    // Null unless materials are wanted.
    GpuImage material;  // rg8: metallic, perceptual roughness
    GpuImage emissive;  // rgba16f: linear radiance
};

// Of device memory, for what is always rendered: depth, normal, motion, albedo, and the rasteriser's own
// depth.
uint64_t gbuffer_bytes_per_pixel();

class GBuffer {
  public:
    // `scene` must outlive the G-buffer. `frames_in_flight`: how many recorded frames may be pending at once.
    // `materials`: whether `material` and `emissive` are rendered too.
    GBuffer(Device& device, const Scene& scene, VkExtent2D extent, uint32_t frames_in_flight,
            bool materials = false);

    // Records the frame into slot frame.index % frames_in_flight: the scene at `moment`, and where it was at
    // `previous`, both in frames of its shot, whose origin `origin` is. Afterwards the images are in
    // SHADER_READ_ONLY_OPTIMAL, visible to shaders and copies that follow in the queue.
    void record(VkCommandBuffer commands, const FrameDescription& frame, double moment, double previous,
                const glm::dvec3& origin);

    const GBufferImages& images() const { return images_; }
    static constexpr VkImageLayout final_layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;

  private:
    void create_images(VkExtent2D extent);
    std::vector<const GpuImage*> color_images() const;
    void create_draw_records(uint32_t frames_in_flight);
    void create_pipelines();
    void write_draw_records(const FrameDescription& frame, double moment, double previous,
                            const glm::dvec3& origin, size_t slot);
    void draw(VkCommandBuffer commands, const FrameDescription& frame, size_t slot) const;

    // One part of one instance.
    struct DrawItem {
        Instance instance;
        const Part* part = nullptr;
        PartRange range;
        uint32_t least_alpha = 0;  // 0: not alpha-tested
        VkPipeline pipeline = VK_NULL_HANDLE;
        // Of what deforms, per frame in flight: its vertices in this frame and in the one before.
        std::vector<GpuBuffer> vertices, prev_vertices;
    };
    void write_deformed(double moment, double previous, size_t slot);

    Device& device_;
    const Scene& scene_;
    bool materials_;
    GBufferImages images_;
    GpuImage tested_;  // d32: what the rasteriser tests
    RasterGeometry geometry_;
    GpuBuffer vertices_, indices_;
    MaterialTextures textures_;
    std::vector<DrawItem> items_;
    std::vector<GpuBuffer> records_;  // per frame in flight
    DescriptorSets draws_;            // of these
    Owned<VkPipelineLayout> pipeline_layout_;
    std::map<DrawnAs, Owned<VkPipeline>> pipelines_;  // that the scene needs
};

}  // namespace penumbra
