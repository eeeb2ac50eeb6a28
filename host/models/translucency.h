// SPDX-License-Identifier: MIT
// What a surface lets through: T = (1 - a) + a t c per colour channel, for a the alpha where glTF's alphaMode
// is BLEND (1 from opaque_blend_alpha on; under MASK 0 or 1, else 1), t the transmission
// (KHR_materials_transmission, of the part that is no metal) and c the base colour, linear. Of alpha blending
// with a straight alpha, 1 - a is what stays of the background (glTF 2.0, section 3.9.4); of a thin wall that
// transmits, the light that goes in is tinted by the base colour (KHR_materials_transmission, "Transmission
// Tinting"). What its gloss reflects is not taken away, and nothing is scattered or bent.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "host/models/model.h"

namespace penumbra {

// A material's transmittance by texel of its textures: decided here once, so that rays on every device and
// the truth read the same.
struct TransmittanceMap {
    uint32_t width = 1, height = 1;
    std::vector<uint32_t> texels;  // red, green, blue of 10 bits each, red lowest; rows from the top
};

// Of the map of a material that may let something through, else 0. Of a wide texture and a high one it is far
// larger than both together.
uint64_t transmittance_bytes(const Model& model, const Material& material);
// The largest of the textures' sizes along each axis; the others' nearest texels.
TransmittanceMap transmittance_map(const Model& model, const Material& material);
glm::dvec3 unpack_transmittance(uint32_t texel);

// Whether any texel lets light through that an opaque or alpha-tested surface would not; -1, no material,
// does not.
bool is_translucent(const Model& model, int material);

// Of a translucent material: whether some of its texels are to be seen, those from least_opaque_alpha() on.
// What transmits is left to whoever draws what is behind.
bool has_opaque_texels(const Model& model, const Material& material);

}  // namespace penumbra
