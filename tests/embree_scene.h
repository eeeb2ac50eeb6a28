// SPDX-License-Identifier: MIT
// Triangles in Embree's robust mode, for tests that compare shadow rays with it.
#pragma once

#include <embree3/rtcore.h>

#include <array>
#include <cstring>
#include <functional>
#include <optional>
#include <span>

#include "host/bvh/bvh.h"

namespace penumbra::test {

class EmbreeScene {
  public:
    // Whether a triangle blocks at the point with the weights u, v of its corners 1 and 2.
    using Blocks = std::function<bool(uint32_t triangle, double u, double v)>;

    explicit EmbreeScene(std::span<const Triangle> triangles, Blocks blocks = {})
        : device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_)), blocks_(std::move(blocks)) {
        rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12,
                                            triangles.size() * 3),
                    triangles.data(), triangles.size() * sizeof(Triangle));
        auto* indices = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, triangles.size()));
        for (uint32_t i = 0; i < triangles.size() * 3; ++i) indices[i] = i;
        if (blocks_) {
            rtcSetGeometryUserData(geometry, &blocks_);
            rtcSetGeometryOccludedFilterFunction(geometry, filter);
            rtcSetGeometryIntersectFilterFunction(geometry, filter);
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_);
    }
    ~EmbreeScene() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    EmbreeScene(const EmbreeScene&) = delete;
    EmbreeScene& operator=(const EmbreeScene&) = delete;

    bool occluded(const Ray& r) const {
        RTCRay ray{
            r.origin[0], r.origin[1], r.origin[2], r.t_min, r.direction[0], r.direction[1], r.direction[2], 0,
            r.t_max,     ~0u,         0,           0};
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcOccluded1(scene_, &context, &ray);
        return ray.tfar < 0;
    }

    struct Hit {
        float t;
        std::array<float, 3> normal;  // of the winding, any length
    };
    std::optional<Hit> nearest(const Ray& r) const {
        RTCRayHit query{{r.origin[0], r.origin[1], r.origin[2], r.t_min, r.direction[0], r.direction[1],
                         r.direction[2], 0, r.t_max, ~0u, 0, 0},
                        {}};
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene_, &context, &query);
        if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
        return Hit{query.ray.tfar, {query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z}};
    }

  private:
    static void filter(const RTCFilterFunctionNArguments* hit) {
        const auto& blocks = *static_cast<const Blocks*>(hit->geometryUserPtr);
        for (uint32_t i = 0; i < hit->N; ++i)
            if (hit->valid[i] != 0 && !blocks(RTCHitN_primID(hit->hit, hit->N, i),
                                              static_cast<double>(RTCHitN_u(hit->hit, hit->N, i)),
                                              static_cast<double>(RTCHitN_v(hit->hit, hit->N, i))))
                hit->valid[i] = 0;
    }

    RTCDevice device_;
    RTCScene scene_;
    Blocks blocks_;
};

}  // namespace penumbra::test
