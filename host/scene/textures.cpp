// SPDX-License-Identifier: MIT
// Mip levels are averaged in linear light on the CPU: once per texture, and the same on every device.
#include "host/scene/textures.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace penumbra {

namespace {

// IEC 61966-2-1.
float to_linear(uint8_t encoded) {
    const float c = static_cast<float>(encoded) / 255;
    return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
}

uint8_t to_srgb(float linear) {
    const float c = linear <= 0.0031308f ? linear * 12.92f : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
    return static_cast<uint8_t>(std::lround(std::clamp(c, 0.0f, 1.0f) * 255));
}

// Appends half the size of the level that starts at `from`; odd sizes repeat their last row or column.
void append_half(std::vector<uint8_t>& texels, size_t from, uint32_t width, uint32_t height,
                 const std::array<float, 256>& linear) {
    for (uint32_t y = 0; y < std::max(height / 2, 1u); ++y) {
        for (uint32_t x = 0; x < std::max(width / 2, 1u); ++x) {
            for (uint32_t channel = 0; channel < 4; ++channel) {
                float sum = 0;
                for (uint32_t k = 0; k < 4; ++k) {
                    const size_t sx = std::min(2 * x + (k & 1), width - 1),
                                 sy = std::min(2 * y + (k >> 1), height - 1);
                    sum += linear[texels[from + (sy * width + sx) * 4 + channel]];
                }
                texels.push_back(to_srgb(sum / 4));
            }
        }
    }
}

GpuImage upload(Device& device, const Texture& texture, const std::array<float, 256>& linear) {
    std::vector<uint8_t> texels = texture.rgba;
    uint32_t width = texture.width, height = texture.height, levels = 1;
    size_t from = 0;
    while (width > 1 || height > 1) {
        const size_t next = texels.size();
        append_half(texels, from, width, height, linear);
        width = std::max(width / 2, 1u);
        height = std::max(height / 2, 1u);
        from = next;
        ++levels;
    }
    GpuImage image =
        make_image(device, VK_FORMAT_R8G8B8A8_SRGB, {texture.width, texture.height}, levels,
                   VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, "base colour texture");
    upload_image(device, image, std::as_bytes(std::span(texels)));
    return image;
}

}  // namespace

TextureSets::TextureSets(Device& device, std::span<const Texture> textures) {
    std::array<float, 256> linear{};
    for (size_t i = 0; i < linear.size(); ++i) linear[i] = to_linear(static_cast<uint8_t>(i));
    const Texture white{1, 1, {255, 255, 255, 255}};
    images_.push_back(upload(device, white, linear));
    for (const Texture& texture : textures) {
        const uint32_t limit = device.limits().maxImageDimension2D;
        const bool usable = texture.width > 0 && std::max(texture.width, texture.height) <= limit;
        images_.push_back(upload(device, usable ? texture : white, linear));
    }

    VkSamplerCreateInfo sampler{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    sampler.magFilter = VK_FILTER_LINEAR;
    sampler.minFilter = VK_FILTER_LINEAR;
    sampler.mipmapMode = VK_SAMPLER_MIPMAP_MODE_LINEAR;
    sampler.maxLod = VK_LOD_CLAMP_NONE;
    VkSampler sampler_handle = VK_NULL_HANDLE;
    check(vkCreateSampler(device.get(), &sampler, nullptr, &sampler_handle), "vkCreateSampler",
          "base colour");
    sampler_ = {device.get(), sampler_handle};

    VkDescriptorSetLayoutBinding binding{};
    binding.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    binding.descriptorCount = 1;
    binding.stageFlags = VK_SHADER_STAGE_FRAGMENT_BIT;
    sets_ = make_descriptor_sets(device, {&binding, 1}, static_cast<uint32_t>(images_.size()), "base colour");
    for (size_t i = 0; i < images_.size(); ++i)
        write_image(device, sets_.sets[i], 0, sampler_.get(), images_[i].view.get());
}

}  // namespace penumbra
