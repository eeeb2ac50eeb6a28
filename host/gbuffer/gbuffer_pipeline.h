// SPDX-License-Identifier: MIT
// The graphics pipeline of the G-buffer, and what it shares with the code that records it.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>

#include "host/device/device.h"

namespace penumbra {

// What the rasteriser tests; hosts' input `depth` is the first of the colours.
inline constexpr VkFormat gbuffer_test_format = VK_FORMAT_D32_SFLOAT;
// Depth (of each pixel's very centre, which no grid moved: frame_depth_at_centres), normal, motion, albedo;
// where materials are wanted also those and what shines.
inline constexpr std::array<VkFormat, 6> gbuffer_color_formats{
    VK_FORMAT_R32_SFLOAT,     VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_R16G16B16A16_SFLOAT,
    VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R8G8_UNORM,          VK_FORMAT_R16G16B16A16_SFLOAT};
inline constexpr size_t gbuffer_colors_without_materials = 4;

// `Draw` of gbuffer.glsl, std140; as far apart as any device wants offsets of uniform buffers to be.
struct DrawRecord {
    glm::mat4 clip_from_local, prev_clip_from_local;
    glm::vec4 world_from_local[3];  // a mat3: columns padded to 16 bytes
    glm::vec4 camera_local, camera_local_low;
    glm::vec4 base_color;
    glm::vec4 metallic_roughness, emissive;
};
static_assert(sizeof(DrawRecord) == 256);

// `Constants` of gbuffer.glsl.
struct DrawConstants {
    glm::vec2 jitter_ndc;
    glm::vec2 ndc_per_pixel;
    glm::vec4 ray_x, ray_y, ray_0, ahead;
    uint32_t least_alpha;
};
inline constexpr VkShaderStageFlags draw_constant_stages =
    VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;

// What the materials of some draws need of the fragment shader.
struct DrawnAs {
    bool alpha_tested = false;  // texels below DrawConstants::least_alpha are discarded
    bool textured = false;      // else no texture is read
    auto operator<=>(const DrawnAs&) const = default;
};

// Reverse Z. `materials`: all six colours.
Owned<VkPipeline> make_gbuffer_pipeline(const Device& device, VkPipelineLayout layout, VkExtent2D area,
                                        DrawnAs as, bool materials);

}  // namespace penumbra
