// SPDX-License-Identifier: MIT
// A light that a frame is run without shows nothing in it: of balls and cameras of every kind none reaches a
// point of the picture, and those that are far beside it are found.
#include "host/shots/light_in_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <random>

namespace penumbra {
namespace {

using Random = std::mt19937;

double between(Random& random, double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
}

blocks::Light light_at(const glm::dvec3& centre, double range) {
    blocks::Light light{};
    light.centre = {
        {static_cast<float>(centre.x), static_cast<float>(centre.y), static_cast<float>(centre.z)}};
    light.range = static_cast<float>(range);
    light.on = 1;
    return light;
}

// Columns right, up, back; `back` from anywhere.
std::array<double, 9> looking(Random& random) {
    const glm::dmat4 turned = glm::rotate(
        glm::rotate(glm::dmat4(1), between(random, 0, 6.3), glm::dvec3(0, 1, 0)), between(random, -1.5, 1.5),
        glm::normalize(glm::dvec3(1, between(random, -1, 1), between(random, -1, 1))));
    std::array<double, 9> columns{};
    const glm::dmat3 m(turned);
    std::copy_n(glm::value_ptr(m), 9, columns.begin());
    return columns;
}

struct Eye {
    Camera camera;
    // A point that is seen at uv in 0 .. 1, so many metres in front, relative to the camera, in the world's
    // axes.
    glm::dvec3 at(double u, double v, double metres) const {
        const glm::dmat4 view_from_clip = glm::inverse(glm::make_mat4(camera.clip_from_view.data()));
        const glm::dmat3 world_from_view = glm::make_mat3(camera.world_from_view.data());
        const glm::dmat4 clip_from_view = glm::make_mat4(camera.clip_from_view.data());
        const glm::dvec4 on_axis = clip_from_view * glm::dvec4(0, 0, -metres, 1);
        const glm::dvec4 p =
            view_from_clip * glm::dvec4(glm::dvec2(2 * u - 1, 2 * v - 1) * on_axis.w, on_axis.z, on_axis.w);
        return world_from_view * (glm::dvec3(p) / p.w);
    }
};

Eye eye(Random& random, bool orthographic) {
    Eye eye;
    eye.camera.world_from_view = looking(random);
    eye.camera.clip_from_view = perspective(between(random, 0.2, 2.2), between(random, 0.4, 2.5), 0.05);
    if (orthographic) {  // no perspective in the last row
        eye.camera.clip_from_view = {between(random, 0.05, 1),
                                     0,
                                     0,
                                     0,
                                     0,
                                     between(random, -1, -0.05),
                                     0,
                                     0,
                                     0,
                                     0,
                                     0.001,
                                     0,
                                     0,
                                     0,
                                     0.5,
                                     1};
    }
    return eye;
}

TEST(LightInView, WhoIsLeftOutReachesNothingOfThePicture) {
    Random random(7);
    uint32_t left_out = 0;
    for (uint32_t i = 0; i < 4000; ++i) {
        const Eye of = eye(random, i % 4 == 3);
        const glm::dvec3 centre(between(random, -20, 20), between(random, -20, 20), between(random, -20, 20));
        const double range = between(random, 0.1, 15);
        if (may_show(light_at(centre, range), of.camera)) continue;
        ++left_out;
        for (uint32_t k = 0; k < 200; ++k) {
            const double u = k % 3 ? between(random, 0, 1) : k % 2,
                         v = between(random, 0, 1);  // and its edges
            const glm::dvec3 seen = of.at(u, v, between(random, 0.05, 60));
            ASSERT_GT(glm::length(seen - centre), range) << i << " at " << u << ", " << v;
        }
    }
    EXPECT_GT(left_out, 1000u);
}

TEST(LightInView, WhoIsInThePictureOrNearItIsNot) {
    Random random(8);
    for (uint32_t i = 0; i < 4000; ++i) {
        const Eye of = eye(random, i % 4 == 3);
        const glm::dvec3 seen =
            of.at(between(random, 0, 1), between(random, 0, 1), between(random, 0.05, 30));
        const glm::dvec3 away = glm::normalize(
            glm::dvec3(between(random, -1, 1), between(random, -1, 1), between(random, -1, 1)));
        const double range = between(random, 0.01, 20);
        EXPECT_TRUE(may_show(light_at(seen + away * range, range), of.camera)) << i;
    }
}

TEST(LightInView, WhoIsOffOrBesideIsLeftOut) {
    Eye of;
    of.camera.clip_from_view = perspective(1.0, 1.5, 0.05);
    blocks::Light light = light_at({0, 0, -5}, 3);
    EXPECT_TRUE(may_show(light, of.camera));
    light.on = 0;
    EXPECT_FALSE(may_show(light, of.camera));
    for (const glm::dvec3 beside : {glm::dvec3(0, 0, 8), glm::dvec3(12, 0, -5), glm::dvec3(-12, 0, -5),
                                    glm::dvec3(0, 9, -5), glm::dvec3(0, -9, -5)})
        EXPECT_FALSE(may_show(light_at(beside, 3), of.camera))
            << beside.x << " " << beside.y << " " << beside.z;
    EXPECT_TRUE(may_show(light_at({0, 0, 8}, 1e9), of.camera)) << "a light without a range";
    EXPECT_TRUE(may_show(light_at({0, 0, 8}, 3), Camera{})) << "a camera that nobody asks for";
}

}  // namespace
}  // namespace penumbra
