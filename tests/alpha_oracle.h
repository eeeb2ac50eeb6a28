// SPDX-License-Identifier: MIT
// The truth about alpha-tested triangles in double precision, from the model itself (texture, factor,
// cutoff), with a third answer where a ray meets a texel's border closer than single precision can tell.
// Shares no code with the layout that shaders read.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "host/scene/scene.h"
#include "tests/bvh_oracle.h"

namespace penumbra::test {

class AlphaOracle {
  public:
    explicit AlphaOracle(const Scene& scene) : model_(scene.model()) {
        for (const Instance& instance : scene.instances())
            for (const Part& part : model_.meshes[static_cast<size_t>(instance.mesh)].parts)
                for (size_t i = 0; i < part.indices.size(); i += 3) {
                    Corners& c = corners_.emplace_back();
                    if (part.material < 0) continue;
                    c.material = &model_.materials[static_cast<size_t>(part.material)];
                    for (size_t k = 0; k < 3 && !part.uv.empty(); ++k) c.uv[k] = part.uv[part.indices[i + k]];
                }
    }

    bool is_tested(uint32_t triangle) const {
        return corners_[triangle].material && corners_[triangle].material->alpha_cutoff;
    }

    // At the point with these weights of the corners 1 and 2.
    bool blocks(uint32_t triangle, double u, double v) const {
        if (!is_tested(triangle)) return true;
        const glm::dvec2 uv = at(triangle, u, v);
        return texel_is_there(*corners_[triangle].material, uv);
    }

    // Of a ray that meets the triangle's plane, within `tolerance` (relative, as against()).
    Truth against_texels(uint32_t triangle, const Triangle& t, const Ray& ray, double tolerance) const {
        const glm::dvec3 o(ray.origin[0], ray.origin[1], ray.origin[2]),
            d = glm::normalize(glm::dvec3(ray.direction[0], ray.direction[1], ray.direction[2]));
        glm::dvec3 p[3];
        double scale = 0;
        for (int k = 0; k < 3; ++k) {
            p[k] = glm::dvec3(t.v[k][0], t.v[k][1], t.v[k][2]);
            for (int a = 0; a < 3; ++a) scale = std::max(scale, std::abs(p[k][a] - o[a]));
        }
        const glm::dvec3 n = glm::cross(p[1] - p[0], p[2] - p[0]);
        const double facing = glm::dot(n, d);
        if (std::abs(facing) < 1e-6 * glm::length(n)) return Truth::either;
        const glm::dvec3 x = glm::normalize(
                             glm::cross(d, std::abs(d.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0))),
                         y = glm::cross(d, x);
        glm::dvec2 low(INFINITY), high(-INFINITY);
        for (int k = 0; k < 4; ++k) {
            const glm::dvec3 from =
                o + tolerance * scale * (k & 1 ? x : -x) + tolerance * scale * (k & 2 ? y : -y);
            const glm::dvec3 hit = from + d * (glm::dot(n, p[0] - from) / facing) - p[0];
            const double u = glm::dot(glm::cross(hit, p[2] - p[0]), n) / glm::dot(n, n),
                         v = glm::dot(glm::cross(p[1] - p[0], hit), n) / glm::dot(n, n);
            low = glm::min(low, at(triangle, u, v));
            high = glm::max(high, at(triangle, u, v));
        }
        const Material& material = *corners_[triangle].material;
        if (material.texture < 0) return texel_is_there(material, low) ? Truth::blocked : Truth::clear;
        const Texture& texture = model_.textures[static_cast<size_t>(material.texture)];
        const glm::dvec2 size(texture.width, texture.height), first = glm::floor(low * size),
                                                              last = glm::floor(high * size);
        bool any = false, all = true;
        for (double row = first.y; row <= last.y; ++row)
            for (double column = first.x; column <= last.x; ++column) {
                const bool there = texel_is_there(material, (glm::dvec2(column, row) + 0.5) / size);
                any = any || there;
                all = all && there;
            }
        return all ? Truth::blocked : any ? Truth::either : Truth::clear;
    }

    // As tests/bvh_oracle.h's truth(), with holes.
    Truth truth(std::span<const Triangle> triangles, const Ray& ray, double tolerance) const {
        Truth answer = Truth::clear;
        for (uint32_t i = 0; i < triangles.size(); ++i) {
            Truth one = against(triangles[i], ray, tolerance);
            if (one == Truth::clear) continue;
            if (is_tested(i)) {
                const Truth texels = against_texels(i, triangles[i], ray, tolerance);
                if (texels == Truth::clear) continue;
                if (texels == Truth::either) one = Truth::either;
            }
            if (one == Truth::blocked) return one;
            answer = one;
        }
        return answer;
    }

  private:
    struct Corners {
        const Material* material = nullptr;
        glm::dvec2 uv[3]{};
    };

    glm::dvec2 at(uint32_t triangle, double u, double v) const {
        const Corners& c = corners_[triangle];
        return (1 - u - v) * c.uv[0] + u * c.uv[1] + v * c.uv[2];
    }
    bool texel_is_there(const Material& material, const glm::dvec2& uv) const {
        double alpha = 1;
        if (material.texture >= 0) {
            const Texture& texture = model_.textures[static_cast<size_t>(material.texture)];
            const auto wrapped = [](double c, uint32_t size) {
                const auto i = static_cast<int64_t>(std::floor(c * size)) % int64_t{size};
                return static_cast<size_t>(i < 0 ? i + size : i);
            };
            alpha =
                texture
                    .rgba[4 * (wrapped(uv.y, texture.height) * texture.width + wrapped(uv.x, texture.width)) +
                          3] /
                255.0;
        }
        return alpha * static_cast<double>(material.base_color[3]) >= *material.alpha_cutoff - 1e-7;
    }

    const Model& model_;
    std::vector<Corners> corners_;
};

}  // namespace penumbra::test
