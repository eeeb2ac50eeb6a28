// SPDX-License-Identifier: MIT
// The hierarchy against Embree's robust mode. Where the two differ, double precision decides, and only rays
// within rounding of an edge (or of the interval's ends) may go either way. Embree is no oracle at edges
// itself.
#include <embree3/rtcore.h>
#include <gtest/gtest.h>

#include <cstring>

#include "host/bvh/bvh.h"
#include "tests/bvh_oracle.h"
#include "tests/bvh_scenes.h"
#include "tests/bvh_shipped_scenes.h"

namespace penumbra {
namespace {

using namespace test;

TEST(BvhEmbree, DiffersOnlyWithinRoundingOfAnEdge) {
    RTCDevice device = rtcNewDevice(nullptr);
    uint64_t total = 0;
    for (const TriangleScene& s : all_scenes()) {
        RTCScene scene = rtcNewScene(device);
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12,
                                            s.triangles.size() * 3),
                    s.triangles.data(), s.triangles.size() * sizeof(Triangle));
        auto* indices = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, s.triangles.size()));
        for (uint32_t i = 0; i < s.triangles.size() * 3; ++i) indices[i] = i;
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene);

        const Bvh bvh = build_bvh(s.triangles);
        uint32_t hits = 0, differ = 0, embree_wrong = 0;
        const std::vector<Ray> rays = shadow_rays(s.triangles, 250'000, 20);
        for (const Ray& r : rays) {
            RTCRay ray{r.origin[0],
                       r.origin[1],
                       r.origin[2],
                       r.t_min,
                       r.direction[0],
                       r.direction[1],
                       r.direction[2],
                       0,
                       r.t_max,
                       ~0u,
                       0,
                       0};
            RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            rtcOccluded1(scene, &context, &ray);
            const bool ours = occluded(bvh, r), theirs = ray.tfar < 0;
            hits += ours;
            if (ours == theirs) continue;
            ++differ;
            const Truth t = truth(s.triangles, r);
            embree_wrong += t == (ours ? Truth::blocked : Truth::clear);
            EXPECT_NE(t, ours ? Truth::clear : Truth::blocked)
                << s.name << ": " << r.origin[0] << ' ' << r.origin[1] << ' ' << r.origin[2] << " towards "
                << r.direction[0] << ' ' << r.direction[1] << ' ' << r.direction[2] << " to " << r.t_max;
        }
        total += rays.size();
        RecordProperty(s.name,
                       std::to_string(differ) + " of " + std::to_string(rays.size()) + " rays differ");
        std::printf("%s: %u of %zu rays blocked, %u differ from Embree, %u of these are Embree's\n",
                    s.name.c_str(), hits, rays.size(), differ, embree_wrong);
        EXPECT_GT(hits, rays.size() / 100);
        EXPECT_LT(hits, rays.size() - rays.size() / 100);
        // Most of them in slivers and kilometre-wide triangles whose plane passes the origin within its
        // rounding: ours leaves those out (hit_rounding() of bvh.cpp), and the oracle above has agreed to
        // each.
        EXPECT_LT(differ, rays.size() / 5000);
        rtcReleaseScene(scene);
    }
    EXPECT_GE(total, 1'000'000u);
    rtcReleaseDevice(device);
}

}  // namespace
}  // namespace penumbra
