// SPDX-License-Identifier: MIT
// The words of plan.json, as docs/embedding.md spells them out.
#pragma once

#include <vulkan/vulkan.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace penumbra::test {

using Json = nlohmann::json;

// The words of the JSON, as docs/embedding.md spells them out.
inline const std::map<std::string, VkFormat> formats = {{"r8", VK_FORMAT_R8_UNORM},
                                                        {"rg8", VK_FORMAT_R8G8_UNORM},
                                                        {"rgba8", VK_FORMAT_R8G8B8A8_UNORM},
                                                        {"r16f", VK_FORMAT_R16_SFLOAT},
                                                        {"rg16f", VK_FORMAT_R16G16_SFLOAT},
                                                        {"rg16s", VK_FORMAT_R16G16_SNORM},
                                                        {"rgba16f", VK_FORMAT_R16G16B16A16_SFLOAT},
                                                        {"r32f", VK_FORMAT_R32_SFLOAT},
                                                        {"rg32f", VK_FORMAT_R32G32_SFLOAT},
                                                        {"rgba32f", VK_FORMAT_R32G32B32A32_SFLOAT},
                                                        {"r32ui", VK_FORMAT_R32_UINT},
                                                        {"rg32ui", VK_FORMAT_R32G32_UINT},
                                                        {"rgba32ui", VK_FORMAT_R32G32B32A32_UINT},
                                                        {"rgb10a2", VK_FORMAT_A2B10G10R10_UNORM_PACK32},
                                                        {"r11g11b10f", VK_FORMAT_B10G11R11_UFLOAT_PACK32},
                                                        {"d32", VK_FORMAT_D32_SFLOAT},
                                                        {"d16", VK_FORMAT_D16_UNORM}};
inline const std::map<std::string, VkPipelineStageFlags2> stages = {
    {"compute", VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT}, {"indirect", VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT},
    {"transfer", VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT},  {"copy", VK_PIPELINE_STAGE_2_COPY_BIT},
    {"top", VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT},        {"all", VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT}};
inline const std::map<std::string, VkAccessFlags2> accesses = {
    {"write", VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT},      {"read", VK_ACCESS_2_SHADER_STORAGE_READ_BIT},
    {"sample", VK_ACCESS_2_SHADER_SAMPLED_READ_BIT},      {"uniform", VK_ACCESS_2_UNIFORM_READ_BIT},
    {"arguments", VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT}, {"copy_read", VK_ACCESS_2_TRANSFER_READ_BIT},
    {"copy_write", VK_ACCESS_2_TRANSFER_WRITE_BIT},       {"any_read", VK_ACCESS_2_MEMORY_READ_BIT},
    {"any_write", VK_ACCESS_2_MEMORY_WRITE_BIT}};
inline const std::map<std::string, VkImageUsageFlags> image_usages = {
    {"storage", VK_IMAGE_USAGE_STORAGE_BIT},
    {"sampled", VK_IMAGE_USAGE_SAMPLED_BIT},
    {"copy_source", VK_IMAGE_USAGE_TRANSFER_SRC_BIT},
    {"copy_target", VK_IMAGE_USAGE_TRANSFER_DST_BIT}};
inline const std::map<std::string, VkBufferUsageFlags> buffer_usages = {
    {"storage", VK_BUFFER_USAGE_STORAGE_BUFFER_BIT},
    {"texels", VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT},
    {"arguments", VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT},
    {"copy_source", VK_BUFFER_USAGE_TRANSFER_SRC_BIT},
    {"copy_target", VK_BUFFER_USAGE_TRANSFER_DST_BIT}};
inline const std::map<std::string, VkDescriptorType> descriptor_types = {
    {"sampled_image", VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
    {"storage_image", VK_DESCRIPTOR_TYPE_STORAGE_IMAGE},
    {"texel_buffer", VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER},
    {"storage_texel_buffer", VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER},
    {"uniform_buffer", VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER},
    {"storage_buffer", VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}};

template <class Flags>
Flags flags(const Json& list, const std::map<std::string, Flags>& words) {
    Flags sum = 0;
    for (const Json& word : list) sum |= words.at(word.get<std::string>());
    return sum;
}

inline std::vector<std::byte> read_bytes(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw std::runtime_error("cannot read " + file.string());
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

}  // namespace penumbra::test
