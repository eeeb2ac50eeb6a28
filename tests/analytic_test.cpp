// SPDX-License-Identifier: MIT
// The half-plane scene: is the closed form right, and is what the shot says what the geometry shows?
#include "host/analytic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <random>

#include "host/scene.h"
#include "host/standalone.h"

namespace penumbra {
namespace {

Shot half_plane_shot(AnalyticScene scene, uint32_t frames = 1) {
    Shot shot;
    shot.analytic = scene;
    shot.size = {200, 60};
    shot.frames = frames;
    shot.sun = {{0, {0.3, 0.2, 1}}};
    add_analytic_motion(shot);
    return shot;
}

// Directions of the cap around (0, 0, 1), stratified; the plane x cos = -z sin .. tilts by the distance.
double counted_visibility(double distance, double radius, int side) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> in(0, 1);
    int open = 0;
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j) {
            const double t = 2 * (i + in(random)) / side * std::pow(std::sin(radius / 2), 2);  // 1 - cos
            const double angle = 2 * glm::pi<double>() * (j + in(random)) / side;
            const double x = std::sqrt(t * (2 - t)) * std::cos(angle), z = 1 - t;
            open += x * std::cos(distance) + z * std::sin(distance) > 0;
        }
    return static_cast<double>(open) / (static_cast<double>(side) * side);
}

TEST(HalfPlane, ClosedFormAgreesWithCountedDirections) {
    for (const double degrees : {0.2665, 1.0, 5.0, 10.0, 40.0})
        for (const double share : {-0.95, -0.5, -0.1, 0.0, 0.3, 0.8, 0.99}) {
            const double radius = glm::radians(degrees);
            EXPECT_NEAR(half_plane_visibility(share * radius, radius),
                        counted_visibility(share * radius, radius, 1024), 6e-5)
                << degrees << " degrees, " << share;
        }
}

TEST(HalfPlane, ClosedFormIsSymmetricAndWholeAtItsEnds) {
    const double radius = glm::radians(0.2665);
    for (double share = 0; share < 1; share += 0.01)
        EXPECT_NEAR(
            half_plane_visibility(share * radius, radius) + half_plane_visibility(-share * radius, radius), 1,
            1e-12);
    EXPECT_EQ(half_plane_visibility(radius, radius), 1);
    EXPECT_EQ(half_plane_visibility(-radius, radius), 0);
    EXPECT_EQ(half_plane_visibility(1.5, radius), 1);
}

// Pixels that are neither lit nor dark, along the image's middle row, projected onto the edge's normal.
double penumbra_px(const Shot& shot, double frame) {
    const std::vector<double> image = analytic_image(shot, frame);
    int inside = 0;
    for (uint32_t x = 0; x < shot.size[0]; ++x) {
        const double v = image[size_t{shot.size[0]} * (shot.size[1] / 2) + x];
        inside += v > 0 && v < 1;
    }
    return inside * std::abs(std::cos(glm::radians(shot.analytic->edge_deg)));
}

TEST(HalfPlane, PenumbraIsAsWideAsTheShotSays) {
    for (const double width : {8.0, 32.0, 100.0})
        for (const double edge : {0.0, 20.0, -30.0, 180.0})
            for (const double radius : {0.2665, 3.0}) {
                Shot shot = half_plane_shot({width, edge, 0, 0});
                shot.sun_angular_radius_deg = radius;
                EXPECT_NEAR(penumbra_px(shot, 0), width, 1.01) << width << " " << edge << " " << radius;
            }
}

TEST(HalfPlane, PositiveSpeedMovesTheShadowTowardsTheLight) {
    const Shot shot = half_plane_shot({16, 0, 2, -20}, 21);
    const auto lit_pixels = [&](double frame) {
        double sum = 0;
        for (const double v : analytic_image(shot, frame)) sum += v;
        return sum / shot.size[1];
    };
    EXPECT_NEAR(lit_pixels(0) - lit_pixels(10), 20, 0.05);
    EXPECT_NEAR(lit_pixels(10), 100, 0.05);     // the image's middle is the penumbra's
    EXPECT_EQ(lit_pixels(20), lit_pixels(35));  // held behind the last frame, like every key
    const std::vector<double> image = analytic_image(shot, 10);
    EXPECT_EQ(image.front(), 0);  // light on the right
    EXPECT_EQ(image[shot.size[0] - 1], 1);
}

// The triangles' edge must be where the closed form has it, at every frame.
TEST(HalfPlane, SheetStandsWhereTheClosedFormSays) {
    const Shot shot = half_plane_shot({24, 35, -3, 30}, 40);
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto scene = load_scene(shot, diagnostics, warnings);
    ASSERT_TRUE(scene) << diagnostics.text();
    EXPECT_TRUE(moves(shot));
    for (const double frame : {0.0, 17.0, 39.0}) {
        const AnalyticGeometry geometry = analytic_geometry(shot, frame);
        double edge = -INFINITY, height = 0;
        for (const Triangle& triangle : scene->triangles(frame))
            for (const auto& v : triangle.v) {
                const glm::dvec3 p = glm::dvec3(v[0], v[1], v[2]) + scene->bvh_origin();
                if (p.z < 1e-3) continue;  // the receiver
                edge = std::max(edge, glm::dot(glm::dvec2(p), geometry.normal));
                height = p.z;
            }
        EXPECT_NEAR(edge, geometry.edge, 1e-3 * analytic_pixel_m) << frame;
        EXPECT_NEAR(height, geometry.height, 1e-5 * geometry.height);
    }
}

TEST(HalfPlane, CameraSeesTheReceiverAloneAndSquarePixels) {
    const Shot shot = half_plane_shot({32, 20, 0, 0});
    const Camera camera = camera_at(shot, 0, 1);
    const AnalyticGeometry geometry = analytic_geometry(shot, 0);
    EXPECT_LT(camera.position[2], geometry.height);
    const auto& m = camera.clip_from_view;
    EXPECT_DOUBLE_EQ(m[0] * shot.size[0], -m[5] * shot.size[1]);
    const double depth = m[10] * -camera.position[2] + m[14];  // of the receiver
    EXPECT_GT(depth, 0.1);
    EXPECT_LT(depth, 0.9);
}

}  // namespace
}  // namespace penumbra
