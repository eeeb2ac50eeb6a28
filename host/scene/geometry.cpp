// SPDX-License-Identifier: MIT
// Greedy choice of provoking vertices: the first corner that no earlier triangle has taken, else a copy of
// the first.
#include "host/scene/geometry.h"

#include <array>

namespace penumbra {

namespace {

// Any unit vector of a triangle without area: it covers no pixel.
glm::vec3 winding_normal(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    return glm::dot(normal, normal) > 0 ? glm::vec3(glm::normalize(normal)) : glm::vec3(0, 1, 0);
}

PartRange append(const Part& part, RasterGeometry& out) {
    const size_t first_vertex = out.vertices.size();
    PartRange range{static_cast<uint32_t>(out.indices.size()), static_cast<uint32_t>(part.indices.size()),
                    static_cast<int32_t>(first_vertex)};
    for (size_t i = 0; i < part.positions.size(); ++i) {
        out.vertices.push_back(
            {part.positions[i], glm::vec3(0), part.uv.empty() ? glm::vec2(0) : part.uv[i],
             part.colors.empty() ? std::array<uint8_t, 4>{255, 255, 255, 255} : part.colors[i]});
        out.sources.push_back(static_cast<uint32_t>(i));
    }
    std::vector<bool> taken(part.positions.size(), false);
    for (size_t i = 0; i < part.indices.size(); i += 3) {
        std::array<uint32_t, 3> corners{part.indices[i], part.indices[i + 1], part.indices[i + 2]};
        const glm::vec3 normal = winding_normal(part.positions[corners[0]], part.positions[corners[1]],
                                                part.positions[corners[2]]);
        size_t own = 0;
        while (own < 3 && taken[corners[own]]) ++own;
        if (own < 3) {
            corners = {corners[own], corners[(own + 1) % 3], corners[(own + 2) % 3]};  // the winding stays
        } else {
            const RasterVertex copy = out.vertices[first_vertex + corners[0]];
            out.vertices.push_back(copy);
            out.sources.push_back(corners[0]);
            corners[0] = static_cast<uint32_t>(out.vertices.size() - 1 - first_vertex);
            taken.push_back(true);
        }
        taken[corners[0]] = true;
        out.vertices[first_vertex + corners[0]].winding_normal = normal;
        out.indices.insert(out.indices.end(), corners.begin(), corners.end());
    }
    range.vertex_count = static_cast<uint32_t>(out.vertices.size() - first_vertex);
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

std::vector<RasterVertex> moved_vertices(const RasterGeometry& geometry, const PartRange& range,
                                         const std::vector<glm::vec3>& positions) {
    const auto first = geometry.vertices.begin() + range.vertex_offset;
    std::vector<RasterVertex> out(first, first + range.vertex_count);
    for (size_t i = 0; i < out.size(); ++i)
        out[i].position = positions[geometry.sources[static_cast<size_t>(range.vertex_offset) + i]];
    for (size_t i = range.first_index; i < size_t{range.first_index} + range.index_count; i += 3) {
        RasterVertex& a = out[geometry.indices[i]];
        a.winding_normal = winding_normal(a.position, out[geometry.indices[i + 1]].position,
                                          out[geometry.indices[i + 2]].position);
    }
    return out;
}

}  // namespace penumbra
