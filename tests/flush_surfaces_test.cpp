// SPDX-License-Identifier: MIT
// Surfaces that were meant to lie in one plane: whatever turns them, rounding leaves one above the other, and
// the truth has neither hide the other.
#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "host/truth/counted_visibility.h"
#include "tests/scene_file.h"

namespace penumbra::test {
namespace {

constexpr double plate_height = 1e-3;

// Two floors in one plane, and a plate a millimetre above half of them.
Model floors(const glm::dmat4& turn) {
    Model model;
    model.materials = {{}};
    const auto add_at = [&](const char* name, Shape shape, const glm::dvec3& place) {
        shape.transform(turn * glm::translate(glm::dmat4(1), place));
        add(model, name, std::move(shape), 0);
    };
    add_at("floor", ground(2, 2, 1, 1), {0, 0, 0});
    add_at("flush", ground(1.3, 1.7, 1, 2), {0.4, 0, 0.1});
    add_at("plate", ground(5, 5, 1, 1), {5.5, plate_height, 0});
    return model;
}

TEST(FlushSurfaces, DoNotHideEachOther) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto direction = [&] {
        return glm::normalize(glm::dvec3(unit(random), unit(random), unit(random)));
    };
    for (int i = 0; i < 50; ++i) {
        SCOPED_TRACE(i);
        const glm::dmat4 turn = glm::translate(glm::dmat4(1), 20.0 * direction()) *
                                glm::rotate(glm::dmat4(1), 3 * unit(random), direction());
        const Scene scene(floors(turn), Shot{});
        const CountedVisibility counted(scene, 0);
        const glm::dvec3 up(turn[1]);
        for (const bool below_plate : {false, true}) {
            const glm::dvec4 place(below_plate ? 1.2 : -0.3, plate_height / 2, 0.8 * unit(random), 1);
            const ViewRay ray{glm::dvec3(turn * place) - scene.bvh_origin(), -up, 0, 1e-3};
            const auto point = counted.shown(ray, plate_height / 2, up);
            ASSERT_TRUE(point);
            EXPECT_EQ(counted.visibility(*point, {up, 0.02, 8, 1}), below_plate ? 0 : 1);
        }
    }
}

}  // namespace
}  // namespace penumbra::test
