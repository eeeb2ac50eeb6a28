// SPDX-License-Identifier: MIT
// A model's triangles as the raster wants them: indexed, with one flat normal per triangle. The normal sits
// in the first (provoking) vertex, so every triangle is rotated, or given a copy, until its first vertex is
// its own: about as many vertices as triangles, a third of what unindexed triangles would take.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/models/model.h"

namespace penumbra {

struct RasterVertex {
    glm::vec3 position;        // relative to the part's origin
    glm::vec3 winding_normal;  // unit; of the one triangle that has this vertex first
    glm::vec2 uv;
    std::array<uint8_t, 4> color;  // linear, times the material's
};

// Where a part lies in the common buffers.
struct PartRange {
    uint32_t first_index = 0, index_count = 0;
    int32_t vertex_offset = 0;
    uint32_t vertex_count = 0;
};

struct RasterGeometry {
    std::vector<RasterVertex> vertices;
    std::vector<uint32_t> indices;
    std::vector<uint32_t> sources;               // per vertex, which of its part's positions it is
    std::vector<std::vector<PartRange>> meshes;  // as Model::meshes and its parts
};

RasterGeometry make_raster_geometry(const Model& model);

// The vertices of a part whose positions have become these, with the normals of its triangles.
std::vector<RasterVertex> moved_vertices(const RasterGeometry& geometry, const PartRange& range,
                                         const std::vector<glm::vec3>& positions);

// What turns normals where `m` moves positions, but for their lengths: those are about the largest area that
// a unit square becomes.
inline glm::dmat3 cofactors(const glm::dmat3& m) {
    return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

}  // namespace penumbra
