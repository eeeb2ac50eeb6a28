// SPDX-License-Identifier: MIT
// What is done to every mesh on its way in, wherever it comes from: bad triangles are dropped and counted,
// positions are moved to an origin nearby.
#include "host/models/model.h"

#include <cmath>
#include <stdexcept>

namespace penumbra {

namespace {

// Beyond this the squares in boxes and areas overflow fp32 (1e18^2 = 1e36).
constexpr float largest_coordinate = 1e18f;

bool is_usable(const glm::vec3& p) {
    return std::abs(p.x) < largest_coordinate && std::abs(p.y) < largest_coordinate &&
           std::abs(p.z) < largest_coordinate;  // false for NaN
}

bool is_degenerate(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    const glm::dvec3 normal = glm::cross(glm::dvec3(b) - glm::dvec3(a), glm::dvec3(c) - glm::dvec3(a));
    return !(glm::dot(normal, normal) > 0);
}

}  // namespace

size_t Model::triangle_count() const {
    size_t count = 0;
    for (const Mesh& mesh : meshes)
        for (const Part& part : mesh.parts) count += part.indices.size() / 3;
    return count;
}

uint32_t least_opaque_alpha(const Material& material) {
    if (!material.alpha_cutoff && !material.alpha_blend) return 0;
    const double cutoff = material.alpha_cutoff.value_or(opaque_blend_alpha);
    // The factor is kept in single precision: that much below the cutoff still counts as at it.
    const double factor = static_cast<double>(material.base_color[3]), slack = 0x1p-23;
    for (uint32_t alpha = 0; alpha < 256; ++alpha)
        if (alpha / 255.0 * factor >= cutoff * (1 - slack)) return alpha;
    return 256;
}

bool is_alpha_tested(const Model& model, int material) {
    if (material < 0) return false;
    const Material& m = model.materials[static_cast<size_t>(material)];
    const uint32_t least = m.alpha_cutoff ? least_opaque_alpha(m) : 0;
    if (least == 0) return false;
    if (m.texture < 0) return least > 255;
    const std::vector<uint8_t>& rgba = model.textures[static_cast<size_t>(m.texture)].rgba;
    for (size_t i = 3; i < rgba.size(); i += 4)
        if (rgba[i] < least) return true;
    return false;
}

void add_part(Model& model, Mesh& mesh, std::vector<glm::vec3> positions, std::vector<glm::vec2> uv,
              std::vector<uint32_t> indices, int material) {
    Part part;
    part.positions = std::move(positions);
    part.uv = std::move(uv);
    part.indices = std::move(indices);
    part.material = material;
    add_part(model, mesh, std::move(part));
}

void add_part(Model& model, Mesh& mesh, Part part) {
    std::vector<glm::vec3>& positions = part.positions;
    std::vector<uint32_t>& indices = part.indices;
    if (indices.size() % 3 != 0) throw std::invalid_argument("add_part: indices are not triangles");
    size_t kept = 0;
    glm::dvec3 low(INFINITY), high(-INFINITY);
    for (size_t i = 0; i < indices.size(); i += 3) {
        const glm::vec3* corner[3];
        for (size_t k = 0; k < 3; ++k) corner[k] = &positions.at(indices[i + k]);
        if (!is_usable(*corner[0]) || !is_usable(*corner[1]) || !is_usable(*corner[2])) {
            ++model.dropped_nonfinite;
            continue;
        }
        if (!part.deforms() && is_degenerate(*corner[0], *corner[1], *corner[2])) {
            ++model.dropped_degenerate;
            continue;
        }
        for (size_t k = 0; k < 3; ++k) {
            low = glm::min(low, glm::dvec3(*corner[k]));
            high = glm::max(high, glm::dvec3(*corner[k]));
            indices[kept + k] = indices[i + k];
        }
        kept += 3;
    }
    indices.resize(kept);
    if (indices.empty()) return;

    for (int axis = 0; axis < 3 && !part.deforms(); ++axis) {
        const double centre = 0.5 * (low[axis] + high[axis]);
        const double half = 0.5 * (high[axis] - low[axis]);
        part.origin[axis] = 4 * half < std::abs(centre) ? double(float(centre)) : 0;
    }
    for (glm::vec3& p : positions) p -= glm::vec3(part.origin);
    mesh.parts.push_back(std::move(part));
}

}  // namespace penumbra
