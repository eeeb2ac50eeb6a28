// SPDX-License-Identifier: MIT
// A graphics pipeline for dynamic rendering with the fixed state that all of the host's share: triangle
// lists, no culling (shadow rays meet both sides, so the eye and the maps do too), one sample, the whole of
// one area.
#pragma once

#include <span>

#include "host/device/device.h"

namespace penumbra {

struct RasterPipeline {
    std::span<const uint32_t> vertex, fragment;  // SPIR-V; no fragment stage: none is needed
    const VkSpecializationInfo* fragment_constants = nullptr;
    VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkExtent2D area{};
    std::span<const VkFormat> colors;
    bool minimum = false;                  // colours blend by it, else they replace
    VkFormat depth = VK_FORMAT_UNDEFINED;  // undefined: no depth test
    VkCompareOp passes = VK_COMPARE_OP_LESS;
    bool depth_clamp = false;
};

// `what`: for errors.
Owned<VkPipeline> make_raster_pipeline(const Device& device, const RasterPipeline& description,
                                       const char* what);

}  // namespace penumbra
