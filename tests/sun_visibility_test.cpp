// SPDX-License-Identifier: MIT
// The closed forms against counted directions: stratified over the sun's cap, met by plain geometry.
#include "host/truth/sun_visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>
#include <random>
#include <vector>

namespace penumbra {
namespace {

using glm::dvec2, glm::dvec3;

// Open share of a cap about `to_sun`, counted in side^2 strata.
double counted(const dvec3& to_sun, double radius, const std::function<bool(const dvec3&)>& blocked,
               int side = 1024) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> in(0, 1);
    const dvec3 x = glm::normalize(glm::cross(dvec3(0.31, 0.77, -0.2), to_sun)), y = glm::cross(to_sun, x);
    int open = 0;
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j) {
            const double t = 2 * (i + in(random)) / side * std::pow(std::sin(radius / 2), 2);  // 1 - cos
            const double angle = 2 * glm::pi<double>() * (j + in(random)) / side;
            const double sine = std::sqrt(t * (2 - t));
            open += !blocked(sine * std::cos(angle) * x + sine * std::sin(angle) * y + (1 - t) * to_sun);
        }
    return static_cast<double>(open) / (static_cast<double>(side) * side);
}

constexpr double noise = 1e-4;  // of 1024^2 stratified directions: side^-1.5 = 3e-5

TEST(HalfPlaneForm, AgreesWithCountedDirections) {
    for (const double degrees : {0.2665, 1.0, 5.0, 10.0, 40.0})
        for (const double share : {-0.95, -0.5, -0.1, 0.0, 0.3, 0.8, 0.99}) {
            const double radius = glm::radians(degrees), distance = share * radius;
            const dvec3 normal(std::cos(distance), 0, std::sin(distance));
            EXPECT_NEAR(half_plane_visibility(distance, radius),
                        counted({0, 0, 1}, radius, [&](const dvec3& d) { return glm::dot(d, normal) < 0; }),
                        noise)
                << degrees << " degrees, " << share;
        }
}

TEST(SphereForm, AgreesWithCountedDirections) {
    for (const double degrees : {0.2665, 2.0, 10.0})
        for (const double size : {0.3, 1.0, 4.0})
            for (const double share : {0.05, 0.4, 0.8, 0.99}) {
                const double radius = glm::radians(degrees), sphere = size * radius;
                const double distance = std::abs(radius - sphere) + share * 2 * std::min(radius, sphere);
                const dvec3 centre(std::sin(distance), 0, std::cos(distance));
                const double rim = std::sin(sphere);
                EXPECT_NEAR(sphere_visibility(distance, sphere, radius),
                            counted({0, 0, 1}, radius,
                                    [&](const dvec3& d) { return glm::length(glm::cross(d, centre)) < rim; }),
                            noise)
                    << degrees << " degrees, " << size << " suns, " << share;
            }
}

TEST(SphereForm, EndsWhereTheDiscsTouch) {
    EXPECT_EQ(sphere_visibility(0.031, 0.02, 0.01), 1);
    EXPECT_EQ(sphere_visibility(0.009, 0.02, 0.01), 0);
    EXPECT_NEAR(sphere_visibility(0.001, 0.01, 0.02), 0.75,
                1e-4);  // an eclipse: a quarter of the disc is hidden
}

// Wherever the sun stands, behind convex and concave outlines, in either winding.
TEST(PolygonForm, AgreesWithCountedDirections) {
    const std::vector<std::vector<dvec2>> outlines = {
        {{-0.7, -0.6}, {0.8, -0.3}, {0.1, 0.9}},
        {{-1.5, -0.4}, {1.5, -0.4}, {1.5, 0.3}, {-1.5, 0.3}},
        {{-0.9, -0.9}, {0.9, -0.8}, {0.1, 0.0}, {0.8, 0.9}, {-0.8, 0.7}},
        {{-9, -9}, {9, -9}, {9, 9}, {-9, 9}},      // hides it all
        {{3, 3}, {5, 3}, {4, 5}},                  // beside it
        {{-0.1, -0.1}, {0.1, -0.1}, {0.0, 0.1}}};  // before it
    for (const double degrees : {0.2665, 3.0})
        for (const dvec3& sun : {dvec3(0.3, 0.2, 1), dvec3(0, 0, 1), dvec3(-1, 0.4, 0.5)})
            for (const std::vector<dvec2>& outline : outlines) {
                const double radius = glm::radians(degrees), scale = std::tan(radius);
                const dvec3 s = glm::normalize(sun);
                const dvec3 x = glm::normalize(glm::cross(dvec3(0.1, 1, 0.2), s)), y = glm::cross(s, x);
                std::vector<dvec3> corners;
                for (const dvec2& p : outline) corners.push_back(7.0 * (s + scale * (p.x * x + p.y * y)));
                const auto inside = [&](const dvec3& d) {
                    const double px = glm::dot(d, x) / glm::dot(d, s) / scale,
                                 py = glm::dot(d, y) / glm::dot(d, s) / scale;
                    bool in = false;
                    for (size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
                        const dvec2 &a = outline[i], &b = outline[j];
                        if ((a.y > py) != (b.y > py) && px < (b.x - a.x) * (py - a.y) / (b.y - a.y) + a.x)
                            in = !in;
                    }
                    return in;
                };
                const double expected = counted(s, radius, inside, 512);
                EXPECT_NEAR(polygon_visibility(s, radius, corners), expected, 3 * noise);
                std::reverse(corners.begin(), corners.end());
                EXPECT_NEAR(polygon_visibility(s, radius, corners), expected, 3 * noise);
            }
}

// A polygon with one edge in view is a half-plane; no counting is involved.
TEST(PolygonForm, WithOneEdgeInViewIsAHalfPlane) {
    for (const double degrees : {0.2665, 10.0})
        for (double share = -0.95; share < 1; share += 0.1) {
            const double radius = glm::radians(degrees), edge = std::tan(share * radius);
            const std::vector<dvec3> corners{
                {edge, -5, 1}, {edge, 5, 1}, {edge + 5, 5, 1}, {edge + 5, -5, 1}};
            EXPECT_NEAR(polygon_visibility({0, 0, 1}, radius, corners),
                        half_plane_visibility(share * radius, radius), 1e-9);
        }
}

// In single precision the same form is wrong by two hundredths at the sun's radius: the naive form.
TEST(HalfPlaneForm, KeepsItsDigits) {
    const double radius = glm::radians(0.2665);
    double worst = 0;
    for (double share = -0.9; share < 0.95; share += 0.1) {
        // The planar form is good to 4e-7 at this radius.
        const double planar =
            0.5 + (std::asin(share) + share * std::sqrt(1 - share * share)) / glm::pi<double>();
        EXPECT_NEAR(half_plane_visibility(share * radius, radius), planar, 1e-6);
        const float r = static_cast<float>(radius), d = static_cast<float>(share) * r;
        const float naive = 0.5f + (std::asin(std::sin(d) / std::sin(r)) -
                                    std::cos(r) * std::asin(std::tan(d) / std::tan(r))) /
                                       (glm::pi<float>() * (1 - std::cos(r)));
        worst = std::max(worst, std::abs(static_cast<double>(naive) - planar));
    }
    EXPECT_GT(worst, 1e-3);
}

}  // namespace
}  // namespace penumbra
