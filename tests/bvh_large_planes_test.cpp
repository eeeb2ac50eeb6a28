// SPDX-License-Identifier: MIT
// Large triangles do not shade themselves, and still block what they should. The hit distance of a triangle
// rounds with the distance of its vertices, which the ray's own origin knows nothing of.
#include "tests/bvh_large_planes.h"

#include <gtest/gtest.h>

namespace penumbra {
namespace {

using namespace test;

TEST(BvhLargePlanes, NeverShadeThemselves) {
    for (const double half : {100.0, 1000.0, 10000.0})
        for (const double elevation : {1.0, 3.0, 10.0, 45.0})
            for (const glm::dvec3& normal : plane_normals) {
                const LargePlane plane = large_plane(half, elevation, normal, 200'000, 30);
                const Bvh bvh = build_bvh(plane.quad);
                size_t hits = 0;
                for (const Ray& ray : plane.rays) hits += occluded(bvh, ray);
                EXPECT_EQ(hits, 0u) << "+-" << half << " m, sun at " << elevation << " degrees, normal "
                                    << normal.x << ' ' << normal.y << ' ' << normal.z;
            }
}

// The same where the corners' rounding has put the triangles beside the plane that the rays start from: 1200
// of these rays hit their own receiver where a distance is believed beyond its own rounding alone.
TEST(BvhLargePlanes, NeverShadeThemselvesForTheirCornersRounding) {
    for (const double half : {1000.0, 10000.0})
        for (const double elevation : {1.0, 10.0})
            for (const glm::dvec3& normal : plane_normals) {
                const LargePlane plane = large_plane(half, elevation, normal, 200'000, 30, PointsOn::plane);
                const Bvh bvh = build_bvh(plane.quad);
                size_t hits = 0;
                for (const Ray& ray : plane.rays) hits += occluded(bvh, ray);
                EXPECT_EQ(hits, 0u) << "+-" << half << " m, sun at " << elevation << " degrees, normal "
                                    << normal.x << ' ' << normal.y << ' ' << normal.z;
            }
}

// The other side of the bargain: the part of a ray in which such a triangle is not believed stays a few
// millimetres of height for a kilometre, so a ray that starts below the plane by little more than a raster's
// rounding is blocked.
TEST(BvhLargePlanes, StillBlockWhatStartsBelowThem) {
    for (const double half : {100.0, 1000.0, 10000.0})
        for (const double elevation : {1.0, 3.0, 10.0, 45.0})
            for (const glm::dvec3& normal : plane_normals) {
                LargePlane plane = large_plane(half, elevation, normal, 20'000, 31);
                const Bvh bvh = build_bvh(plane.quad);
                const glm::vec3 below = glm::vec3(glm::normalize(normal)) * float(-1e-5 * half);
                size_t leaks = 0, inside = 0;
                for (Ray& ray : plane.rays) {
                    for (int axis = 0; axis < 3; ++axis) ray.origin[axis] += below[axis];
                    // Those near the border leave beside the quad.
                    const glm::dvec3 o(ray.origin[0], ray.origin[1], ray.origin[2]);
                    if (glm::length(o) > 0.5 * half) continue;
                    ++inside;
                    leaks += !occluded(bvh, ray);
                }
                EXPECT_GT(inside, plane.rays.size() / 2);
                EXPECT_EQ(leaks, 0u) << "+-" << half << " m, sun at " << elevation << " degrees, normal "
                                     << normal.x << ' ' << normal.y << ' ' << normal.z;
            }
}

// A triangle that lies ahead of the origin with all its corners is in the way, however obliquely it is seen:
// a sliver of a millimetre over 20 m, met head on, a hand's breadth from where the ray starts.
TEST(BvhLargePlanes, WhatLiesWhollyAheadAlwaysBlocks) {
    Random random(32);
    for (int i = 0; i < 20'000; ++i) {
        const float gap = 1e-3f * std::exp2(random.in(0, 6)), width = 1e-3f, slope = random.in(1e-4f, 1e-2f);
        const Triangle sliver =
            triangle({gap, -width, -slope * gap}, {gap, width, -slope * gap}, {gap + 20, 0, slope * 20});
        const Bvh bvh = build_bvh({&sliver, 1});
        EXPECT_TRUE(occluded(bvh, {{0, 0, 0}, {1, 0, 0}, 0, std::numeric_limits<float>::infinity()}))
            << gap << ' ' << slope;
    }
}

}  // namespace
}  // namespace penumbra
