// SPDX-License-Identifier: MIT
// Who sees a wall's back, which is not drawn, sees what is behind it, and the shadow that it throws there:
// the truth must not take it for a wall whose outline the rasteriser has moved aside.
#include <gtest/gtest.h>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "host/truth/counted_visibility.h"
#include "tests/scene_file.h"

namespace penumbra::test {
namespace {

// A floor, and a wall over it at z = 0 that faces -z.
Model wall(bool single_sided, bool mirrored) {
    Model model;
    model.materials = {{}};
    add(model, "floor", ground(2, 2, 1, 1), 0);
    Shape shape = ground(1, 1, 1, 1);
    shape.transform(glm::rotate(glm::dmat4(1), (mirrored ? 0.5 : -0.5) * glm::pi<double>(), {1, 0, 0}));
    add(model, "wall", std::move(shape), 0);
    if (mirrored) model.nodes.back().scale = {1, 1, -1};
    for (Part& part : model.meshes.back().parts) part.single_sided = single_sided;
    return model;
}

TEST(CulledWall, ThrowsItsShadow) {
    const glm::dvec3 viewer(0.3, 1.5, 3), sun = glm::normalize(glm::dvec3(0.1, 0.6, 0.7));
    for (const bool mirrored : {false, true})
        for (const bool single_sided : {false, true})
            for (const double behind : {-2e-4, -0.1}) {
                const Scene scene(wall(single_sided, mirrored), Shot{});
                const CountedVisibility counted(scene, 0);
                const glm::dvec3 place(0.3, 0, behind), way = glm::normalize(place - viewer);
                const auto point = counted.shown({viewer - scene.bvh_origin(), way, 0, 6.6e-3},
                                                 glm::distance(place, viewer), {0, 1, 0});
                ASSERT_TRUE(point);
                // Both of its sides are drawn: so near, the viewer can only see past its moved outline.
                const bool moved = !single_sided && behind > -1e-3;
                EXPECT_EQ(counted.visibility(*point, {sun, 0.005, 8, 1}), moved ? 1 : 0)
                    << mirrored << single_sided << behind;
            }
}

}  // namespace
}  // namespace penumbra::test
