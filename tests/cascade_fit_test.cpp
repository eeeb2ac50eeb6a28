// SPDX-License-Identifier: MIT
// Where shadow maps lie, for suns and scenes that make a hand-written look-at divide by zero: every answer is
// finite, and every slice of the view lies in its map.
#include "host/cascades/cascade_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <limits>
#include <vector>

namespace penumbra {
namespace {

Camera camera_at_point(const glm::dvec3& position, double yaw, double near = 0.05, double fov_deg = 60) {
    Camera camera;
    const glm::dvec3 back(std::sin(yaw), 0.2, std::cos(yaw));
    const glm::dvec3 b = glm::normalize(back), right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), b));
    const glm::dmat3 axes(right, glm::cross(b, right), b);
    std::copy_n(glm::value_ptr(axes), 9, camera.world_from_view.begin());
    camera.position = {position.x, position.y, position.z};
    camera.clip_from_view = perspective(glm::radians(fov_deg), 16.0 / 9, near);
    camera.near_m = near;
    return camera;
}

CascadeRequest city() {
    CascadeRequest request;
    request.camera = camera_at_point({3, 1.7, 8}, 0.3);
    request.to_sun = glm::normalize(glm::dvec3(0.3, 0.8, 0.5));
    request.angular_radius = glm::radians(0.27);
    request.low = {-200, 0, -200};
    request.high = {200, 30, 200};
    return request;
}

bool finite(const CascadeFit& fit) {
    bool good = std::isfinite(fit.near_m) && std::isfinite(fit.depth_m) && fit.depth_m > 0;
    for (uint32_t i = 0; i < fit.count; ++i)
        good = good && fit.areas[i].texel_m > 0 && std::isfinite(fit.areas[i].texel_m) &&
               std::isfinite(fit.areas[i].corner.x) && std::isfinite(fit.areas[i].corner.y);
    const blocks::Cascades block = cascade_block(fit, {1, 2, 3});
    for (uint32_t i = 0; i < fit.count; ++i)
        for (const auto& column : block.c[i].map.columns)
            for (const float value : column) good = good && std::isfinite(value);
    return good;
}

// The suns of hard case 26: both ways along every axis, and a step of one ulp in each coordinate around them.
std::vector<glm::dvec3> suns() {
    std::vector<glm::dvec3> list;
    const double tiny = std::numeric_limits<double>::denorm_min();
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) {
            glm::dvec3 sun(0);
            sun[axis] = sign;
            list.push_back(sun);
            sun[axis] = std::nextafter(sign, 0.0);
            list.push_back(sun);
            for (const double step : {tiny, -tiny, 0x1p-52, -0x1p-52, -0.0}) {
                glm::dvec3 aside(step);
                aside[axis] = sign;
                list.push_back(aside);
            }
        }
    return list;
}

TEST(LightFrame, IsOrthonormalForEverySunAlongAnAxisAndAnUlpAside) {
    for (const glm::dvec3& sun : suns()) {
        const LightFrame f = light_frame(sun);
        SCOPED_TRACE(testing::Message() << sun.x << " " << sun.y << " " << sun.z);
        EXPECT_NEAR(glm::length(f.u), 1, 1e-12);
        EXPECT_NEAR(glm::length(f.v), 1, 1e-12);
        EXPECT_NEAR(glm::dot(f.u, f.v), 0, 1e-12);
        EXPECT_NEAR(glm::dot(f.u, f.away), 0, 1e-12);
        EXPECT_NEAR(glm::dot(f.v, f.away), 0, 1e-12);
        EXPECT_NEAR(glm::length(f.away + sun), 0, 1e-12);
    }
}

TEST(CascadeFit, IsFiniteForEverySun) {
    for (const glm::dvec3& sun : suns()) {
        CascadeRequest request = city();
        request.to_sun = sun;
        const CascadeFit fit = fit_cascades(request);
        EXPECT_GE(fit.count, 1u);
        EXPECT_TRUE(finite(fit)) << sun.x << " " << sun.y << " " << sun.z;
    }
}

// Hard case 27: towards the horizon extents grow, but nothing becomes infinite or vanishes.
TEST(CascadeFit, IsFiniteWithTheSunAtAndBelowTheHorizon) {
    for (const double elevation : {0.27, 1e-9, 0.0, -1e-9, -0.27, -30.0}) {
        CascadeRequest request = city();
        const double e = glm::radians(elevation);
        request.to_sun = {std::cos(e), std::sin(e), 0};
        const CascadeFit fit = fit_cascades(request);
        EXPECT_GE(fit.count, 1u);
        EXPECT_TRUE(finite(fit)) << elevation;
    }
}

// Hard case 34: flat, a single point, empty, far away, not a number.
TEST(CascadeFit, SurvivesDegenerateScenes) {
    const auto with_box = [](glm::dvec3 low, glm::dvec3 high) {
        CascadeRequest request = city();
        request.low = low;
        request.high = high;
        return fit_cascades(request);
    };
    for (const double at : {0.0, 1e6, -1e9}) {
        const glm::dvec3 p(at);
        EXPECT_TRUE(finite(with_box(p, p))) << "a point at " << at;
        EXPECT_EQ(with_box(p, p).count, 1u);
        EXPECT_TRUE(finite(with_box(p, p + glm::dvec3(10, 0, 10)))) << "flat at " << at;
        EXPECT_TRUE(finite(with_box(p, p + glm::dvec3(0, 7, 0)))) << "a line at " << at;
    }
    EXPECT_EQ(with_box(glm::dvec3(INFINITY), glm::dvec3(-INFINITY)).count, 0u) << "empty";
    EXPECT_EQ(with_box(glm::dvec3(NAN), glm::dvec3(1)).count, 0u);
    CascadeRequest no_sun = city();
    no_sun.to_sun = glm::dvec3(0);
    EXPECT_EQ(fit_cascades(no_sun).count, 0u);
    no_sun.to_sun = glm::dvec3(NAN);
    EXPECT_EQ(fit_cascades(no_sun).count, 0u);
    CascadeRequest behind = city();
    behind.low = {0, 0, 100};
    behind.high = {1, 1, 101};
    EXPECT_EQ(fit_cascades(behind).count, 1u);  // all of it behind the camera: one map of the scene
    CascadeRequest narrow = city();
    narrow.camera = camera_at_point({0, 1, 0}, 0, 0.05, 1e-4);
    EXPECT_TRUE(finite(fit_cascades(narrow)));
}

// Hard case 31: no triangle is nearer to the sun than depth 0, or farther than depth 1, in any direction.
TEST(CascadeFit, TheDepthRangeHoldsTheWholeScene) {
    CascadeRequest request = city();
    for (int i = 0; i < 64; ++i) {
        const double turn = 0.7 * i;
        request.to_sun = glm::normalize(glm::dvec3(std::cos(turn), 0.05 + 0.02 * i, std::sin(turn)));
        const CascadeFit fit = fit_cascades(request);
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 p(corner & 1 ? request.high.x : request.low.x,
                               corner & 2 ? request.high.y : request.low.y,
                               corner & 4 ? request.high.z : request.low.z);
            const double metres = fit.light.of(p).z - fit.near_m;
            EXPECT_GE(metres, 0);
            EXPECT_LE(metres, fit.depth_m);
        }
    }
}

// Every point that the camera sees lies in some cascade, and the finest ones are near.
TEST(CascadeFit, SlicesOfTheViewLieInTheirMaps) {
    const CascadeRequest request = city();
    const CascadeFit fit = fit_cascades(request);
    ASSERT_EQ(fit.count, max_cascades);
    for (uint32_t i = 1; i < fit.count; ++i) EXPECT_GT(fit.areas[i].texel_m, fit.areas[i - 1].texel_m);
    const glm::dmat3 axes = glm::make_mat3(request.camera.world_from_view.data());
    const glm::dvec3 camera = glm::make_vec3(request.camera.position.data());
    const double tangent = std::tan(glm::radians(30.0));
    for (const double distance : {0.05, 0.5, 2.0, 20.0, 200.0})
        for (const double x : {-1.0, 0.0, 1.0})
            for (const double y : {-1.0, 1.0}) {
                const glm::dvec3 p = camera + axes * glm::dvec3(x * tangent * 16 / 9 * distance,
                                                                y * tangent * distance, -distance);
                bool held = false;
                for (uint32_t i = 0; i < fit.count && !held; ++i) {
                    const glm::dvec3 texel = texels_from_metres(fit, i, glm::dvec3(0)) * glm::dvec4(p, 1);
                    held = texel.x >= 0 && texel.y >= 0 && texel.x <= fit.size && texel.y <= fit.size;
                }
                EXPECT_TRUE(held) << distance << " " << x << " " << y;
            }
}

// The block that shaders read agrees with the matrix that the maps are drawn with, wherever the camera is.
TEST(CascadeBlock, AgreesWithTheRaster) {
    for (const double far : {0.0, 1e4}) {
        CascadeRequest request = city();
        const glm::dvec3 shift(far, 0, -far);
        request.low += shift;
        request.high += shift;
        const glm::dvec3 camera = glm::dvec3(3, 1.7, 8) + shift;
        request.camera = camera_at_point(camera, 0.3);
        const CascadeFit fit = fit_cascades(request);
        const blocks::Cascades block = cascade_block(fit, camera);
        ASSERT_EQ(block.count, fit.count);
        const glm::dvec3 relative(-1.5, -1.0, -4.0);
        for (uint32_t i = 0; i < fit.count; ++i) {
            const glm::dvec3 texel =
                texels_from_metres(fit, i, shift) * glm::dvec4(camera + relative - shift, 1);
            const auto& m = block.c[i].map.columns;
            const auto row = [&](int r) {
                return double(m[r][0]) * relative.x + double(m[r][1]) * relative.y +
                       double(m[r][2]) * relative.z + double(m[r][3]);
            };
            EXPECT_NEAR(row(0) * fit.size, texel.x, 1e-3);
            EXPECT_NEAR(row(1) * fit.size, texel.y, 1e-3);
            EXPECT_NEAR(row(2) * double(block.c[i].depth_m), texel.z, 1e-3);
        }
    }
}

// A small scene seen as a whole needs one map: no slice of the view has finer texels.
TEST(CascadeFit, OneMapWhereOneSuffices) {
    CascadeRequest request = city();
    request.low = {-0.1, 0, -0.1};
    request.high = {0.1, 0.2, 0.1};
    request.camera = camera_at_point({0, 0.3, 0.6}, 0);
    EXPECT_EQ(fit_cascades(request).count, 1u);
    request.orthographic = true;
    EXPECT_EQ(fit_cascades(request).count, 1u);
}

}  // namespace
}  // namespace penumbra
