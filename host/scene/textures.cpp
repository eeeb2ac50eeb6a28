// SPDX-License-Identifier: MIT
// Mip levels are averaged in linear light on the CPU: once per texture, and the same on every device.
#include "host/scene/textures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "host/images/srgb.h"

namespace penumbra {

namespace {

float to_linear(uint8_t encoded) {
    return linear_of_srgb(static_cast<float>(encoded) / 255);
}

uint8_t to_unorm(float value) {
    return static_cast<uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255));
}

uint8_t to_srgb(float linear) {
    return to_unorm(srgb_of_linear(linear));
}

// How a texture's bytes stand for what is averaged.
struct Encoding {
    VkFormat format;
    std::array<float, 256> decoded;
    uint8_t (*encode)(float);
};

Encoding make_encoding(VkFormat format, float (*decode)(uint8_t), uint8_t (*encode)(float)) {
    Encoding encoding{format, {}, encode};
    for (size_t i = 0; i < encoding.decoded.size(); ++i)
        encoding.decoded[i] = decode(static_cast<uint8_t>(i));
    return encoding;
}

Encoding srgb_encoding() {
    return make_encoding(VK_FORMAT_R8G8B8A8_SRGB, to_linear, to_srgb);
}

Encoding linear_encoding() {
    return make_encoding(
        VK_FORMAT_R8G8B8A8_UNORM, [](uint8_t byte) { return static_cast<float>(byte) / 255; }, to_unorm);
}

// Appends half the size of the level that starts at `from`; of odd sizes but 1 the last row or column is left
// out.
void append_half(std::vector<uint8_t>& texels, size_t from, uint32_t width, uint32_t height,
                 const Encoding& encoding) {
    for (uint32_t y = 0; y < std::max(height / 2, 1u); ++y) {
        for (uint32_t x = 0; x < std::max(width / 2, 1u); ++x) {
            for (uint32_t channel = 0; channel < 4; ++channel) {
                float sum = 0;
                for (uint32_t k = 0; k < 4; ++k) {
                    const size_t sx = std::min(2 * x + (k & 1), width - 1),
                                 sy = std::min(2 * y + (k >> 1), height - 1);
                    sum += encoding.decoded[texels[from + (sy * width + sx) * 4 + channel]];
                }
                texels.push_back(encoding.encode(sum / 4));
            }
        }
    }
}

bool is_too_large(const Texture& texture, uint32_t most_texels) {
    return std::max(texture.width, texture.height) > most_texels;
}

GpuImage upload(Device& device, const Texture& texture, const Encoding& encoding) {
    std::vector<uint8_t> texels = texture.rgba;
    uint32_t width = texture.width, height = texture.height, levels = 1;
    size_t from = 0;
    while (width > 1 || height > 1) {
        const size_t next = texels.size();
        append_half(texels, from, width, height, encoding);
        width = std::max(width / 2, 1u);
        height = std::max(height / 2, 1u);
        from = next;
        ++levels;
    }
    GpuImage image = make_image(device, encoding.format, {texture.width, texture.height}, levels,
                                VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, "a texture");
    upload_image(device, image, std::as_bytes(std::span(texels)));
    return image;
}

}  // namespace

std::vector<std::string> texture_warnings(std::span<const Material> materials,
                                          std::span<const Texture> textures, bool surfaces,
                                          uint32_t most_texels) {
    std::set<int> used;
    for (const Material& material : materials) {
        used.insert(material.texture);
        if (surfaces) used.insert({material.metallic_roughness_texture, material.emissive_texture});
    }
    used.erase(-1);
    std::vector<std::string> warnings;
    for (const int texture : used) {
        const Texture& large = textures[static_cast<size_t>(texture)];
        if (is_too_large(large, most_texels))
            warnings.push_back(fmt::format(
                "a texture of {}x{} exceeds the device's largest image, {} per axis: it is drawn white",
                large.width, large.height, most_texels));
    }
    return warnings;
}

MaterialTextures::MaterialTextures(Device& device, std::span<const Material> materials,
                                   std::span<const Texture> textures, bool surfaces) {
    const Texture white{1, 1, {255, 255, 255, 255}};
    // Each texture once in each encoding that some material reads it in.
    const auto image = [&](int texture, bool srgb) -> const GpuImage& {
        const uint32_t limit = device.limits().maxImageDimension2D;
        const Texture* wanted = texture < 0 ? &white : &textures[static_cast<size_t>(texture)];
        if (wanted->width == 0 || is_too_large(*wanted, limit)) wanted = &white;
        GpuImage& held = images_[{wanted == &white ? -1 : texture, srgb}];
        if (held.format == VK_FORMAT_UNDEFINED)
            held = upload(device, *wanted, srgb ? srgb_encoding() : linear_encoding());
        return held;
    };

    VkSamplerCreateInfo sampler{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    sampler.magFilter = VK_FILTER_LINEAR;
    sampler.minFilter = VK_FILTER_LINEAR;
    sampler.mipmapMode = VK_SAMPLER_MIPMAP_MODE_LINEAR;
    sampler.maxLod = VK_LOD_CLAMP_NONE;
    VkSampler sampler_handle = VK_NULL_HANDLE;
    check(vkCreateSampler(device.get(), &sampler, nullptr, &sampler_handle), "vkCreateSampler",
          "material textures");
    sampler_ = {device.get(), sampler_handle};

    std::array<VkDescriptorSetLayoutBinding, 3> bindings{};
    for (uint32_t i = 0; i < bindings.size(); ++i)
        bindings[i] = {i, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT,
                       nullptr};
    sets_ = make_descriptor_sets(device, bindings, static_cast<uint32_t>(1 + materials.size()),
                                 "material textures");
    for (size_t i = 0; i < sets_.sets.size(); ++i) {
        const Material material = i == 0 ? Material{} : materials[i - 1];
        const int of_surface[] = {surfaces ? material.metallic_roughness_texture : -1,
                                  surfaces ? material.emissive_texture : -1};
        const VkImageView views[] = {image(material.texture, true).view.get(),
                                     image(of_surface[0], false).view.get(),
                                     image(of_surface[1], true).view.get()};
        for (uint32_t binding = 0; binding < 3; ++binding)
            write_image(device, sets_.sets[i], binding, sampler_.get(), views[binding]);
        textured_.push_back(material.texture >= 0 || of_surface[0] >= 0 || of_surface[1] >= 0);
    }
}

}  // namespace penumbra
