// SPDX-License-Identifier: MIT
// Analytic scenes: is what the shot says what the closed forms and the geometry show? (The forms themselves:
// sun_visibility_test.)
#include "host/truth/analytic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "host/scene/scene.h"
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

Shot shot_with(AnalyticScene scene, double radius_deg = 0.2665) {
    Shot shot = half_plane_shot(std::move(scene));
    shot.sun_angular_radius_deg = radius_deg;
    return shot;
}

double at(const std::vector<double>& image, const Shot& shot, uint32_t x, uint32_t y) {
    return image[size_t{shot.size[0]} * y + x];
}

// A slit wider than its penumbra is light in its middle and dark beside; one much narrower shows a part.
TEST(Slit, LetsTheSunThrough) {
    const Shot wide = shot_with({16, 0, 0, 0, Slit{40}}), narrow = shot_with({16, 0, 0, 0, Slit{2}});
    EXPECT_EQ(at(analytic_image(wide, 0), wide, 100, 30), 1);
    EXPECT_EQ(at(analytic_image(wide, 0), wide, 70, 30), 0);
    EXPECT_NEAR(at(analytic_image(wide, 0), wide, 80, 30), 0.5, 0.05);
    // 2 of 16 pixels at the disc's middle: 4 / pi * 2 / 16
    EXPECT_NEAR(at(analytic_image(narrow, 0), narrow, 100, 30), 4 / glm::pi<double>() * 2 / 16, 0.003);
}

// Slats much finer than the penumbra average to their openings; coarse ones show.
TEST(Fence, FineSlatsMeltIntoAnAverage) {
    const Shot fine = shot_with({32, 20, 0, 0, Fence{2, 0.3}}),
               coarse = shot_with({2, 0, 0, 0, Fence{40, 0.5}});
    for (const double v : analytic_image(fine, 0)) EXPECT_NEAR(v, 0.7, 0.01);
    const std::vector<double> image = analytic_image(coarse, 0);
    EXPECT_EQ(at(image, coarse, 100, 30), 0);
    EXPECT_EQ(at(image, coarse, 120, 30), 1);
    EXPECT_EQ(at(image, coarse, 140, 30), 0);
    // At 2 rho / p = 1.22, the first zero of J1, the lines vanish; beyond it dark and light change places.
    const auto contrast = [](double penumbra_px) {
        Shot shot = shot_with({penumbra_px, 0, 0, 0, Fence{20, 0.5}});
        shot.sun = {{0, {0, 0, 1}}};
        const std::vector<double> row = analytic_image(shot, 0);
        return at(row, shot, 110, 30) - at(row, shot, 100, 30);  // an opening's middle and a slat's
    };
    EXPECT_NEAR(contrast(4), 1, 1e-9);
    EXPECT_GT(contrast(20), 0.05);
    EXPECT_NEAR(contrast(20 * 1.22), 0, 0.03);
    EXPECT_LT(contrast(20 * 1.6), -0.03);
}

TEST(Polygon, ShadowFallsWhereThePointsAre) {
    const Shot shot = shot_with({4, 0, 0, 0, Polygon{{{-30, -20}, {40, -20}, {40, 10}, {-30, 10}}}});
    const std::vector<double> image = analytic_image(shot, 0);
    EXPECT_EQ(at(image, shot, 75, 15), 0);
    EXPECT_EQ(at(image, shot, 135, 35), 0);
    EXPECT_EQ(at(image, shot, 75, 45), 1);
    EXPECT_EQ(at(image, shot, 145, 15), 1);
    EXPECT_EQ(at(image, shot, 65, 15), 1);
}

TEST(Sphere, ShadowIsRoundAndSoft) {
    Shot shot = shot_with({8, 0, 0, 0, Sphere{10}}, 2);
    shot.sun = {{0, {0, 0, 1}}};
    const std::vector<double> image = analytic_image(shot, 0);
    EXPECT_EQ(at(image, shot, 100, 30), 0);
    EXPECT_EQ(at(image, shot, 120, 30), 1);
    EXPECT_NEAR(at(image, shot, 109, 30), at(image, shot, 100, 39), 1e-12);
    EXPECT_NEAR(at(image, shot, 109, 30), 0.5, 0.1);
}

// Every sun above the horizon leaves the contact itself dark, on the shadow's side.
TEST(Contact, ShadowBeginsAtTheContact) {
    for (const double radius : {0.2665, 5.0}) {
        const Shot wall = shot_with({0, 0, 0, 0, ContactWall{1}}, radius);
        const std::vector<double> image = analytic_image(wall, 0);
        EXPECT_EQ(at(image, wall, 99, 30), 0);
        EXPECT_EQ(at(image, wall, 100, 30), 1);
        const ContactLine line = analytic_contact(wall, 0).value();
        EXPECT_NEAR(line.from[0], 100, 1e-9);
        EXPECT_NEAR(line.away[0], -1, 1e-9);

        const Shot ball = shot_with({0, 0, 0, 0, ContactPoint{20}}, radius);
        const std::vector<double> round = analytic_image(ball, 0);
        const ContactLine point = analytic_contact(ball, 0).value();
        EXPECT_EQ(point.from, point.to);
        const auto x = static_cast<uint32_t>(point.from[0] + 2 * point.away[0]),
                   y = static_cast<uint32_t>(point.from[1] + 2 * point.away[1]);
        EXPECT_EQ(at(round, ball, x, y), 0);
        const std::vector<uint8_t> seen = analytic_receivers(ball, 0);
        EXPECT_LE(std::count(seen.begin(), seen.end(), 0), 8);
        EXPECT_EQ(seen[30 * 200 + 100], 0);
    }
    EXPECT_FALSE(analytic_contact(shot_with({8, 0, 0, 0}), 0));
}

// Naive: dark as soon as n.s < 0. Half the sun still shines there.
TEST(Terminator, GoesThroughAHalfWhereTheSunsCentreSets) {
    Shot shot = shot_with({64, 0, 0, 0, Terminator{}}, 2);
    shot.sun = {{0, {1, 0, 0.5}}};
    const std::vector<double> image = analytic_image(shot, 0);
    EXPECT_EQ(at(image, shot, 10, 30), 0);
    EXPECT_EQ(at(image, shot, 190, 30), 1);
    EXPECT_NEAR(0.5 * (at(image, shot, 99, 30) + at(image, shot, 100, 30)), 0.5, 1e-9);
    for (uint32_t x = 1; x < 200; ++x) EXPECT_GE(at(image, shot, x, 30), at(image, shot, x - 1, 30));
    double last = INFINITY;  // convex: the slope falls all the way
    for (double q = -3; q < 3; q += 0.01) {
        const double slope = terminator_strip(shot, q).slope;
        EXPECT_LE(slope, last + 1e-12);
        last = slope;
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
