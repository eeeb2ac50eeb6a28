// SPDX-License-Identifier: MIT
#include "host/models/translucency.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/images/srgb.h"

namespace penumbra {
namespace {

constexpr uint32_t largest = 1023;

// A texture as seen from a map of another size.
class Sampled {
  public:
    Sampled(const Model& model, int texture)
        : texture_(texture < 0 ? nullptr : &model.textures[static_cast<size_t>(texture)]) {
        if (texture_ && texture_->width == 0) texture_ = nullptr;
    }
    uint32_t width() const { return texture_ ? texture_->width : 1; }
    uint32_t height() const { return texture_ ? texture_->height : 1; }
    // The texel under the middle of texel x, y of a map; 255 without a texture.
    uint8_t at(uint32_t x, uint32_t y, const TransmittanceMap& map, size_t channel) const {
        if (!texture_) return 255;
        const auto place = [](uint32_t i, uint32_t from, uint32_t to) {
            return static_cast<size_t>((2 * uint64_t{i} + 1) * to / (2 * uint64_t{from}));
        };
        return texture_->rgba[4 * (place(y, map.height, texture_->height) * texture_->width +
                                   place(x, map.width, texture_->width)) +
                              channel];
    }

  private:
    const Texture* texture_;
};

bool may_transmit(const Material& material) {
    return material.alpha_blend || material.transmission * (1 - material.metallic) > 0 ||
           (material.transmission > 0 && material.metallic_roughness_texture >= 0);
}

std::array<uint32_t, 2> map_size(const Model& model, const Material& material) {
    std::array<uint32_t, 2> size{1, 1};
    for (const int texture :
         {material.texture, material.transmission_texture, material.metallic_roughness_texture}) {
        const Sampled sampled(model, texture);
        size = {std::max(size[0], sampled.width()), std::max(size[1], sampled.height())};
    }
    return size;
}

}  // namespace

uint64_t transmittance_bytes(const Model& model, const Material& material) {
    const auto [width, height] = map_size(model, material);
    return may_transmit(material) ? uint64_t{width} * height * sizeof(uint32_t) : 0;
}

TransmittanceMap transmittance_map(const Model& model, const Material& material) {
    const Sampled base(model, material.texture), transmission(model, material.transmission_texture),
        metal(model, material.metallic_roughness_texture);
    const auto [width, height] = map_size(model, material);
    TransmittanceMap map{width, height, {}};
    std::array<double, 256> linear{};
    for (size_t i = 0; i < 256; ++i) linear[i] = linear_of_srgb(static_cast<double>(i) / 255);
    const uint32_t least = least_opaque_alpha(material);
    map.texels.reserve(size_t{map.width} * map.height);
    for (uint32_t y = 0; y < map.height; ++y)
        for (uint32_t x = 0; x < map.width; ++x) {
            const uint8_t alpha = base.at(x, y, map, 3);
            const double a = alpha >= least          ? 1.0
                             : material.alpha_cutoff ? 0.0
                                                     : alpha / 255.0 * double(material.base_color[3]);
            const double t = double(material.transmission) * transmission.at(x, y, map, 0) / 255.0 *
                             (1 - double(material.metallic) * metal.at(x, y, map, 2) / 255.0);
            uint32_t texel = 0;
            for (size_t channel = 0; channel < 3; ++channel) {
                const double c = double(material.base_color[channel]) * linear[base.at(x, y, map, channel)];
                texel |= static_cast<uint32_t>(std::lround(largest * (1 - a + a * t * c))) << (10 * channel);
            }
            map.texels.push_back(texel);
        }
    return map;
}

glm::dvec3 unpack_transmittance(uint32_t texel) {
    return glm::dvec3(texel & largest, texel >> 10 & largest, texel >> 20 & largest) / double(largest);
}

bool is_translucent(const Model& model, int material) {
    if (material < 0 || !may_transmit(model.materials[static_cast<size_t>(material)])) return false;
    const TransmittanceMap map = transmittance_map(model, model.materials[static_cast<size_t>(material)]);
    return std::ranges::any_of(map.texels, [](uint32_t texel) { return texel != 0; });
}

bool has_opaque_texels(const Model& model, const Material& material) {
    if (!material.alpha_blend || material.transmission > 0 || material.texture < 0) return false;
    const std::vector<uint8_t>& rgba = model.textures[static_cast<size_t>(material.texture)].rgba;
    const uint32_t least = least_opaque_alpha(material);
    if (least > 255) return false;
    for (size_t i = 3; i < rgba.size(); i += 4)
        if (rgba[i] >= least) return true;
    return false;
}

}  // namespace penumbra
