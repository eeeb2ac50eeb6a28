// SPDX-License-Identifier: MIT
// Greedy choice of provoking vertices: the first corner that no earlier triangle has taken, else a copy of
// the first.
#include "host/scene/geometry.h"

#include <array>

namespace penumbra {

namespace {

PartRange append(const Part& part, RasterGeometry& out) {
    const size_t first_vertex = out.vertices.size();
    const PartRange range{static_cast<uint32_t>(out.indices.size()),
                          static_cast<uint32_t>(part.indices.size()), static_cast<int32_t>(first_vertex)};
    for (size_t i = 0; i < part.positions.size(); ++i) {
        out.vertices.push_back(
            {part.positions[i], glm::vec3(0), part.uv.empty() ? glm::vec2(0) : part.uv[i]});
    }
    std::vector<bool> taken(part.positions.size(), false);
    for (size_t i = 0; i < part.indices.size(); i += 3) {
        std::array<uint32_t, 3> corners{part.indices[i], part.indices[i + 1], part.indices[i + 2]};
        const glm::dvec3 a(part.positions[corners[0]]);
        const glm::dvec3 edge_ab = glm::dvec3(part.positions[corners[1]]) - a;
        const glm::dvec3 edge_ac = glm::dvec3(part.positions[corners[2]]) - a;
        const glm::vec3 normal(glm::normalize(glm::cross(edge_ab, edge_ac)));

        size_t own = 0;
        while (own < 3 && taken[corners[own]]) ++own;
        if (own < 3) {
            corners = {corners[own], corners[(own + 1) % 3], corners[(own + 2) % 3]};  // the winding stays
        } else {
            const RasterVertex copy = out.vertices[first_vertex + corners[0]];
            out.vertices.push_back(copy);
            corners[0] = static_cast<uint32_t>(out.vertices.size() - 1 - first_vertex);
            taken.push_back(true);
        }
        taken[corners[0]] = true;
        out.vertices[first_vertex + corners[0]].winding_normal = normal;
        out.indices.insert(out.indices.end(), corners.begin(), corners.end());
    }
    return range;
}

}  // namespace

RasterGeometry make_raster_geometry(const Model& model) {
    RasterGeometry out;
    for (const Mesh& mesh : model.meshes) {
        std::vector<PartRange>& ranges = out.meshes.emplace_back();
        for (const Part& part : mesh.parts) ranges.push_back(append(part, out));
    }
    return out;
}

}  // namespace penumbra
