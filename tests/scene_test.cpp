// SPDX-License-Identifier: MIT
// Scenes of a model and a shot: what moves, what boxes are around it, where a tree is fine, and that far away
// nothing loses its differences.
#include "host/scene/scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/generated/colonnade.h"
#include "host/models/glb_writer.h"
#include "host/scene/moved_boxes.h"
#include "tests/gltf_files.h"

namespace penumbra {
namespace {

// Vertices far from the origin are moved there without losing a bit.
TEST(Model, FarVerticesKeepTheirDifferences) {
    Model model;
    Mesh mesh;
    const float far = 1e6f;
    const std::vector<glm::vec3> positions{{far, 0, 0}, {far + 0.0625f, 0, 0}, {far, 0.001f, 0}};
    add_part(model, mesh, positions, {}, {0, 1, 2}, -1);
    ASSERT_EQ(mesh.parts.size(), 1u);
    const Part& part = mesh.parts[0];
    for (size_t i = 0; i < 3; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_EQ(part.origin[axis] + double(part.positions[i][axis]), double(positions[i][axis]));
        }
    }
    EXPECT_LT(std::abs(part.positions[0].x), 1);
}

TEST(Scene, MovesWhatTheShotMoves) {
    Shot shot;
    shot.objects["arm"].keys = {{.frame = 0},
                                {.frame = 10, .translation = {1, 0, 0}, .rotation_deg = {0, 90, 0}}};
    const Scene scene(small_model(), shot);
    EXPECT_FALSE(scene.moved(3, 3));
    EXPECT_TRUE(scene.moved(3, 4));
    EXPECT_FALSE(scene.moved(10, 11));
    // local = T(translation + moved) * R * S: at frame 10 the scaled point (2, 0, 0) has turned to -z and
    // moved by 1.
    const glm::dvec4 p = scene.transforms(10)[1] * glm::dvec4(1, 0, 0, 1);
    EXPECT_NEAR(p.x, 1, 1e-9);
    EXPECT_NEAR(p.z, 1e-3 - 2, 1e-9);
    EXPECT_EQ(scene.triangles(0).size(), scene.triangles(10).size());
    EXPECT_EQ(scene.triangle_objects(), (std::vector<uint32_t>{0, 0, 0}));
}

// Every corner that is elsewhere, where it was and where it is; nothing of what rests.
TEST(Scene, BoxesAreAroundWhatHasMoved) {
    Shot shot;
    shot.objects["arm"].keys = {{.frame = 0},
                                {.frame = 10, .translation = {1, 0, 0}, .rotation_deg = {0, 90, 0}}};
    const Scene scene(small_model(), shot);
    EXPECT_TRUE(scene.moved_boxes(3, 3).empty());
    EXPECT_TRUE(scene.moved_boxes(10, 11).empty());
    const auto boxes = scene.moved_boxes(3, 7);
    ASSERT_EQ(boxes.size(), 1u);
    const glm::dvec3 camera(1e6, 0, -1e6);
    const blocks::MovedBoxes block = moved_block(boxes, camera);
    ASSERT_EQ(block.count, 1u);
    for (const double frame : {3.0, 7.0})
        for (const Triangle& triangle : scene.triangles(frame))
            for (const auto& corner : triangle.v)
                for (int axis = 0; axis < 3; ++axis) {
                    const double at = corner[axis] + scene.bvh_origin()[axis] - camera[axis];
                    EXPECT_LE(block.boxes[0].lo.v[axis], at);
                    EXPECT_GE(block.boxes[0].hi.v[axis], at);
                }
}

TEST(MovedBoxes, OfTooManySomeShareOne) {
    const glm::dvec3 camera(0.5, 1, -2);
    for (const size_t n : {size_t{1}, size_t{64}, size_t{65}, size_t{1000}}) {
        std::vector<std::array<glm::dvec3, 2>> boxes;
        for (size_t i = 0; i < n; ++i) boxes.push_back({glm::dvec3(double(i)), glm::dvec3(double(i) + 0.1)});
        const blocks::MovedBoxes block = moved_block(boxes, camera);
        ASSERT_EQ(block.count, std::min<size_t>(n, blocks::MOST_MOVED_BOXES));
        for (const auto& box : boxes)
            EXPECT_TRUE(std::any_of(block.boxes, block.boxes + block.count, [&](const blocks::MovedBox& b) {
                const auto holds = [&](int axis) {
                    return b.lo.v[axis] <= box[0][axis] - camera[axis] &&
                           b.hi.v[axis] >= box[1][axis] - camera[axis];
                };
                return holds(0) && holds(1) && holds(2);
            }));
    }
}

// Two directions are enough for something to be seen; what is a line or a point is counted.
TEST(Scene, FlatAndThinNodesAreShown) {
    Part cube{.positions = {}, .indices = {}};
    for (int i = 0; i < 8; ++i) cube.positions.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    cube.indices = {0, 1, 3, 0, 3, 2, 0, 4, 5, 0, 5, 1};
    const glm::dquat turned = glm::normalize(glm::dquat(1, .3, -.2, .5));
    const auto scene_of = [&](const glm::dvec3& scale) {
        Model model;
        model.meshes.push_back({{cube}});
        model.nodes = {Node{.name = "n", .mesh = 0, .rotation = turned, .scale = scale}};
        return Scene(std::move(model), Shot{});
    };
    for (const glm::dvec3 scale :
         {glm::dvec3(.01, .01, 50), {10, 0, 10}, {0, 3, 4}, {-10, 0, 10}, {1e-5, 1e-5, 100}}) {
        const Scene scene = scene_of(scale);
        ASSERT_EQ(scene.instances().size(), 1u) << scale.x;
        const glm::dmat3 shown(scene.transforms(0)[0]), inverse = glm::inverse(shown);
        EXPECT_GT(std::abs(glm::determinant(shown)), 0) << "normals and the way back need an inverse";
        EXPECT_TRUE(std::isfinite(inverse[0][0] + inverse[1][1] + inverse[2][2]));
        const glm::dmat3 wanted =
            glm::mat3_cast(turned) * glm::dmat3(scale.x, 0, 0, 0, scale.y, 0, 0, 0, scale.z);
        for (int c = 0; c < 3; ++c) EXPECT_LT(glm::length(shown[c] - wanted[c]), 2e-6 * 100);
        EXPECT_EQ(glm::determinant(shown) < 0,
                  scale.x * (scale.y == 0 ? 1 : scale.y) * scale.z < 0 && scale.y != 0)
            << "flat is not mirrored";
        EXPECT_GT(area_of(scene.triangles(0)), 0);
    }
    for (const glm::dvec3 scale : {glm::dvec3(0, 0, 5), {0, 0, 0}, {NAN, 1, 1}, {1e200, 1e200, 1e200}})
        EXPECT_EQ(scene_of(scale).dropped_instances(), 1) << scale.z;
}

// What no triangle uses is not seen, and a box is of what is seen.
TEST(Scene, BoxesLeaveOutVerticesThatNothingUses) {
    Model model = small_model();
    model.meshes[0].parts[0].positions.emplace_back(1e6f, INFINITY, 0.0f);
    const Scene scene(std::move(model), Shot{});
    EXPECT_NEAR(scene.box(0)[1].x, 4, 1e-9);
    EXPECT_NEAR(scene.box(0)[1].y, 2, 1e-9);
}

// fp32 is finest about the origin of the tree: the middle, but of a large box where the camera is.
TEST(Scene, AStrayFarAwayLeavesTheTreeFineAtTheCamera) {
    for (const double far : {400., 600., 6e4, 2e8}) {
        Model model = small_model();
        model.nodes.push_back(Node{.name = "stray", .mesh = 0, .translation = {far, 0, 0}});
        Shot shot;
        shot.camera = {{.frame = 0, .position = {1, 50, 3}}, {.frame = 9, .position = {3, 50, 3}}};
        const Scene scene(std::move(model), shot);
        const glm::dvec3 middle = 0.5 * (scene.bounds()[0] + scene.bounds()[1]);
        if (far < 500)
            EXPECT_EQ(scene.bvh_origin(), middle) << far;
        else
            EXPECT_EQ(scene.bvh_origin(), glm::dvec3(2, scene.bounds()[1].y, scene.bounds()[1].z)) << far;
        const float x = scene.triangles(0)[0].v[2][0];
        EXPECT_NEAR(x + scene.bvh_origin().x, 2, 1e-5) << far;
    }
}

// A triangle that reaches far is off at the camera by what its corners are.
TEST(Scene, ALargeTriangleKeepsTheTreeAboutItsMiddle) {
    for (const double scale : {100., 1000., 1e5}) {
        Model model = small_model();
        model.nodes[1].scale = glm::dvec3(scale);
        Shot shot;
        shot.camera = {{.frame = 0, .position = {1, 50, 3}}};
        const Scene scene(std::move(model), shot);
        const glm::dvec3 middle = 0.5 * (scene.bounds()[0] + scene.bounds()[1]);
        EXPECT_EQ(scene.bvh_origin() == middle, scale < 1e5) << scale;
    }
}

TEST(Colonnade, IsTheSameEachTimeAndHasItsGate) {
    const Model model = make_colonnade();
    EXPECT_EQ(to_glb(model), to_glb(make_colonnade()));
    EXPECT_EQ(std::ranges::count(model.nodes, "gate", &Node::name), 1);
    const Scene scene(model, Shot{});
    EXPECT_GT(scene.triangles(0).size(), 100000u);
    EXPECT_LT(scene.triangles(0).size(), 250000u);
    for (const Mesh& mesh : model.meshes)
        for (const Part& part : mesh.parts) {
            Model copy;
            Mesh out;
            add_part(copy, out, part.positions, {}, part.indices, 0);
            EXPECT_EQ(copy.dropped_degenerate, 0u);
            EXPECT_EQ(copy.dropped_nonfinite, 0u);
        }
}

}  // namespace
}  // namespace penumbra
