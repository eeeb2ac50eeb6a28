// SPDX-License-Identifier: MIT
// What the pixels of a G-buffer see, by casting rays in double precision.
#pragma once

#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <vector>

#include "host/standalone.h"

namespace penumbra::test {

constexpr uint32_t width = 320, height = 180;

// A triangle of the scene with its corners now and one frame ago, in double precision.
struct Reference {
    glm::dvec3 corner[3], before[3];
};

inline std::vector<Reference> reference_triangles(const Scene& scene, double frame, double previous) {
    const auto now = scene.transforms(frame), then = scene.transforms(previous);
    std::vector<Reference> out;
    for (const Instance& instance : scene.instances()) {
        const auto node = static_cast<size_t>(instance.node);
        for (const Part& part : scene.model().meshes[static_cast<size_t>(instance.mesh)].parts) {
            for (size_t i = 0; i < part.indices.size(); ++i) {
                if (i % 3 == 0) out.emplace_back();
                const glm::dvec4 p(part.origin + glm::dvec3(part.positions[part.indices[i]]), 1);
                out.back().corner[i % 3] = glm::dvec3(now[node] * p);
                out.back().before[i % 3] = glm::dvec3(then[node] * p);
            }
        }
    }
    return out;
}

struct Hit {
    int triangle = -1;
    double t = INFINITY;  // view depth, since rays have view-axis length 1
    glm::dvec3 weights;
};

inline Hit cast(const std::vector<Reference>& triangles, const glm::dvec3& eye, const glm::dvec3& ray) {
    Hit best;
    for (size_t i = 0; i < triangles.size(); ++i) {
        const auto& c = triangles[i].corner;
        const glm::dmat3 system(c[0] - eye, c[1] - eye, c[2] - eye);
        const glm::dvec3 w = glm::inverse(system) * ray;  // ray = sum of w * corner; t = 1 / sum of w
        const double sum = w.x + w.y + w.z;
        if (!(w.x >= 0 && w.y >= 0 && w.z >= 0 && sum > 0) || 1 / sum >= best.t) continue;
        best = {static_cast<int>(i), 1 / sum, w / sum};
    }
    return best;
}

inline glm::dvec3 ray_through(const Camera& camera, const glm::dvec2& uv) {
    const glm::dmat4 clip = glm::make_mat4(camera.clip_from_view.data());
    const glm::dvec2 ndc = 2.0 * uv - 1.0;
    return glm::make_mat3(camera.world_from_view.data()) *
           glm::dvec3(ndc.x / clip[0][0], ndc.y / clip[1][1], -1);
}

inline glm::dvec3 uv_and_depth(const Camera& camera, const glm::dvec3& point) {
    const glm::dvec3 view = glm::transpose(glm::make_mat3(camera.world_from_view.data())) *
                            (point - glm::dvec3(glm::make_vec3(camera.position.data())));
    const glm::dmat4 clip = glm::make_mat4(camera.clip_from_view.data());
    return {0.5 + 0.5 * clip[0][0] * view.x / -view.z, 0.5 + 0.5 * clip[1][1] * view.y / -view.z, -view.z};
}

// What each pixel's centre sees, with the jitter taken out.
inline std::vector<Hit> reference_hits(const std::vector<Reference>& triangles,
                                       const FrameDescription& frame) {
    std::vector<Hit> hits(size_t(width) * height);
    const glm::dvec3 eye = glm::make_vec3(frame.camera.position.data());
    for (uint32_t y = 0; y < height; ++y) {
        for (uint32_t x = 0; x < width; ++x) {
            const glm::dvec2 uv((x + 0.5) / width - frame.jitter[0], (y + 0.5) / height - frame.jitter[1]);
            hits[y * width + x] = cast(triangles, eye, ray_through(frame.camera, uv));
        }
    }
    return hits;
}

// Pixels whose neighbours see the same triangle: coverage at edges is the rasteriser's own business.
inline bool is_interior(const std::vector<Hit>& hits, uint32_t x, uint32_t y) {
    if (x == 0 || y == 0 || x + 1 == width || y + 1 == height) return false;
    for (uint32_t v = y - 1; v <= y + 1; ++v)
        for (uint32_t u = x - 1; u <= x + 1; ++u)
            if (hits[v * width + u].triangle != hits[y * width + x].triangle) return false;
    return true;
}

}  // namespace penumbra::test
