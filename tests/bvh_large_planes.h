// SPDX-License-Identifier: MIT
// Shadow rays from points on one large quad, as the trace node makes them: the point is reconstructed from a
// depth in single precision, moved into the scene's frame and lifted by the node's own error bound
// (trace.comp). The quad is all there is, and the sun is above it, so every ray that hits anything has hit
// its own receiver.
#pragma once

#include <glm/glm.hpp>

#include "tests/bvh_scenes.h"

namespace penumbra::test {

struct LargePlane {
    std::vector<Triangle> quad;
    std::vector<Ray> rays;
};

inline constexpr glm::dvec3 plane_normals[] = {
    {0, 1, 0}, {0.02, 1, -0.014}, {0.3, 1, 0.2}, {1, 1, 1}, {0.5, 0.7, -0.8}};

// Where the rays' points lie: on the triangles as they are, or on the plane that was meant, beside which the
// corners' rounding has put the triangles; a raster that works in another frame sees something of the kind.
enum class PointsOn { triangle, plane };

// `half`: of the quad's side, metres; the sun stands `elevation_deg` above the plane, at any azimuth.
inline LargePlane large_plane(double half, double elevation_deg, const glm::dvec3& normal, uint32_t count,
                              uint32_t seed, PointsOn points = PointsOn::triangle) {
    Random random(seed);
    const glm::dvec3 n = glm::normalize(normal);
    const glm::dvec3 u = glm::normalize(glm::cross(n, glm::dvec3(0, 0, 1))), w = glm::cross(n, u);
    const auto at = [&](double a, double b) { return a * u + b * w; };
    const auto vec = [](const glm::dvec3& p) { return Vec{float(p.x), float(p.y), float(p.z)}; };
    LargePlane out;
    // Corners on both sides of the frame's origin round to opposite numbers, so that the diagonal passes
    // through it as exactly as it should; one that passes it by does not.
    const double aside = points == PointsOn::plane ? 0.2 * half : 0;
    const auto corner = [&](double a, double b) { return vec(at(a + aside, b - aside)); };
    add_quad(out.quad, corner(-half, -half), corner(-half, half), corner(half, half), corner(half, -half));

    const auto around = [&] { return double(random.in(0, 2 * std::numbers::pi_v<float>)); };
    while (out.rays.size() < count) {
        // Cameras stand 1.7 m above the plane, most of them near the frame's origin, where coordinates, and
        // the node's bound with them, are smallest while the vertices are as far as ever.
        const double near_origin = out.rays.size() % 4 ? 0.001 : 1;
        const double a = random.in(-0.5f, 0.5f) * half * near_origin,
                     b = random.in(-0.5f, 0.5f) * half * near_origin;
        const double distance = std::exp2(random.in(0, out.rays.size() % 2 ? 9 : 3)), heading = around();
        glm::dvec3 p = at(a + distance * std::cos(heading), b + distance * std::sin(heading));
        const bool second = glm::dot(glm::cross(at(1, 1), p), n) < 0;
        const auto& v = out.quad[second].v;
        const glm::dvec3 v0(v[0][0], v[0][1], v[0][2]), v1(v[1][0], v[1][1], v[1][2]),
            v2(v[2][0], v[2][1], v[2][2]);
        const glm::dvec3 own = glm::normalize(glm::cross(v1 - v0, v2 - v0));
        if (points == PointsOn::triangle) p -= own * glm::dot(own, p - v0);

        const glm::dvec3 camera = at(a, b) + 1.7 * n;
        const float depth = float(0.05 / distance), view_depth = 0.05f / depth;
        const glm::vec3 relative = glm::vec3((p - camera) / distance) * view_depth;
        const glm::vec3 in_scene = relative + glm::vec3(camera);
        const glm::vec3 largest = glm::max(glm::abs(relative), glm::abs(in_scene));
        const float facing = float(std::abs(glm::dot(n, glm::normalize(p - camera))));
        const float offset = 3 * 0x1p-23f * (largest.x + largest.y + largest.z + view_depth) +
                             8 * 0x1p-24f * view_depth * facing;
        const glm::vec3 o = in_scene + glm::vec3(n) * offset;

        const double elevation = elevation_deg * std::numbers::pi / 180, azimuth = around();
        const glm::dvec3 d =
            std::cos(elevation) * (std::cos(azimuth) * u + std::sin(azimuth) * w) + std::sin(elevation) * n;
        out.rays.push_back({{o.x, o.y, o.z},
                            {float(d.x), float(d.y), float(d.z)},
                            0,
                            std::numeric_limits<float>::infinity()});
    }
    return out;
}

}  // namespace penumbra::test
