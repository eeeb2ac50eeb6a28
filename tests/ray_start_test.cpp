// SPDX-License-Identifier: MIT
// Where a shadow ray starts (shaders/common/ray_offset.glsl): a plane that nothing stands on shades none of
// its own pixels, on a rasteriser of any sub-pixel precision, at any size, tilt and grazing view.
#include <fmt/format.h>

#include <bit>
#include <glm/gtc/matrix_transform.hpp>

#include "app/light_truth.h"
#include "host/images/image_file.h"
#include "host/models/glb_writer.h"
#include "host/models/shapes.h"
#include "tests/gpu_test.h"
#include "tests/ray_maker.h"
#include "tests/scene_file.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/test_folder.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

struct Plane {
    const char* name;
    double half_m, tilt_deg, height_m;  // of the camera, above the plane
    uint32_t cells;                     // along either side
};

class RayStart : public GpuTest, public ::testing::WithParamInterface<Plane> {
  protected:
    // Of many triangles: what a corner's rounding tilts is largest in small ones. The camera looks along the
    // plane, a little down and aside of its diagonal.
    Shot shot() {
        const Plane& plane = GetParam();
        const glm::dmat4 tilt =
            glm::rotate(glm::dmat4(1), glm::radians(plane.tilt_deg), glm::dvec3(0.6, 0, 0.8));
        Shape quad = ground(plane.half_m, plane.half_m, plane.cells, plane.cells);
        quad.transform(tilt);
        Model model;
        model.materials = {{{1, 1, 1, 1}}};
        model.meshes.push_back({{to_part(std::move(quad), 0)}});
        model.nodes = {Node{.name = "plane", .mesh = 0}};
        write_file(path_, to_glb(model));
        normal_ = glm::dvec3(tilt[1]);
        const auto at = [&](double x, double y, double z) {
            return glm::dvec3(tilt * glm::dvec4(x, y, z, 1));
        };
        const glm::dvec3 eye = at(0.07 * plane.half_m, plane.height_m, 0.11 * plane.half_m);
        Shot shot;
        shot.name = "plane";
        shot.model = path_;
        shot.size = {320, 180};
        shot.frames = 4;
        shot.vertical_fov_deg = 70;
        shot.near = 0.05;
        const glm::dvec3 look = eye + glm::dmat3(tilt) * glm::dvec3(-0.83, -0.2, -0.55);
        shot.camera = {{0, {eye.x, eye.y, eye.z}, {look.x, look.y, look.z}, {0.1, 1, 0}}};
        shot.sun_angular_radius_deg = 0.27;
        const glm::dvec3 sun = glm::dmat3(tilt) * glm::dvec3(0.7, 0.35, -0.3);
        shot.sun = {{0, {sun.x, sun.y, sun.z}}};
        return shot;
    }

    TestFolder folder_;
    std::filesystem::path path_ = folder_ / "plane.glb";
    glm::dvec3 normal_;
};

TEST_P(RayStart, APlaneShadesNoneOfItsPixels) {
    SessionOptions options;
    options.size = {320, 180};
    options.captures = {"view_depth", "receiver_normal", "hits"};
    const auto session = open_session(shipped_pipeline("raw"), shot(), options);

    size_t receivers = 0, shaded = 0, sunk = 0;
    double least = INFINITY;  // height of a start above the plane, over its depth
    for (uint32_t frame = 0; frame < 4; ++frame) {
        session->run_frame(frame, frame == 0);
        const StandaloneFrame standalone = session->host().frame(frame, frame == 0);
        EXPECT_EQ(standalone.description.sub_pixel_bits, gpu().limits().subPixelPrecisionBits);

        const RayMaker maker(*session, shipped_nodes(), standalone);
        const auto depth = captured_values<float>(*session, "view_depth");
        const auto normal = captured_values<NormalTexel>(*session, "receiver_normal");
        const auto hits = captured_values<uint32_t>(*session, "hits");
        for (const uint32_t word : hits) shaded += static_cast<size_t>(std::popcount(word));
        const glm::dvec3 origin = session->host().scene().bvh_origin();
        for (uint32_t i = 0; i < depth.size(); ++i) {
            if (depth[i] == 0) continue;
            ++receivers;
            const double lifted =
                glm::dot(normal_, maker.start(i % 320, i / 320, depth[i], normal[i]) + origin);
            sunk += lifted < 0;
            least = std::min(least, lifted / depth[i]);
        }
    }
    std::printf("%s: %zu receivers, %zu shaded, %zu starts below; least height %.2g of the depth\n",
                GetParam().name, receivers, shaded, sunk, least);
    EXPECT_GT(receivers, 60'000u);
    EXPECT_EQ(shaded, 0u);
    EXPECT_EQ(sunk, 0u);
}

// Slopes of up to 8 degrees under a high light shade nobody. Their triangles are a few pixels wide, so that
// many pixels' centres lie just past the edge of what they show, and half of those below a neighbour: rays
// that start there find it from beneath.
class TerrainStart : public GpuTest {
  protected:
    TerrainStart() {
        Shape shape = ground(20, 20, 200, 200);
        uint32_t state = 1;
        for (glm::vec3& at : shape.positions) {
            state = state * 1664525u + 1013904223u;
            at.y = 0.02f * float(state >> 8) * 0x1p-24f;
        }
        Model model;
        model.materials = {{{1, 1, 1, 1}}};
        model.meshes.push_back({{to_part(std::move(shape), 0)}});
        model.nodes = {Node{.name = "terrain", .mesh = 0}};
        write_file(path_, to_glb(model));
        shot_.name = "terrain";
        shot_.model = path_;
        shot_.size = {320, 180};
        shot_.frames = 8;
        shot_.vertical_fov_deg = 60;
        shot_.near = 0.05;
        shot_.camera = {{0, {12, 2, 14}, {0, 0, 0}, {0, 1, 0}}, {7, {11.3, 2, 14}, {0.2, 0, 0}, {0, 1, 0}}};
        shot_.sun_angular_radius_deg = 0.27;
        shot_.sun = {{0, {0.3, 0.8, 0.2}}};
    }

    // Surfaces of eight frames that are not lit, by a pipeline that sees so many at least.
    size_t dark_by(const char* pipeline, size_t least) {
        SessionOptions options;
        options.size = {320, 180};
        options.captures = {"view_depth", "visibility"};
        const auto session = open_session(shipped_pipeline(pipeline), shot_, options);
        size_t receivers = 0, dark = 0;
        for (uint32_t frame = 0; frame < 8; ++frame) {
            session->run_frame(frame, true);
            const auto depth = captured_values<float>(*session, "view_depth");
            const auto visibility = captured_planes(session->view(), "visibility")[0];
            for (size_t i = 0; i < depth.size(); ++i) {
                receivers += depth[i] > 0;
                dark += depth[i] > 0 && visibility[i] < 1;
            }
        }
        EXPECT_GT(receivers, least) << pipeline;
        return dark;
    }

    TestFolder folder_;
    std::filesystem::path path_ = folder_ / "terrain.glb";
    Shot shot_;
};

TEST_F(TerrainStart, NobodyIsSeenFromBelow) {
    for (const char* name : {"raw", "covered"}) EXPECT_EQ(dark_by(name, 200'000), 0u) << name;
}

// A corrugated roof of 45 degrees under a high sun: in its valleys pixels start under the slope that rises
// there, and whoever asks the tree knows that the camera looks through it.
TEST_F(TerrainStart, NobodyIsHiddenByWhatIsLookedThrough) {
    Shape roof;
    constexpr int folds = 240;
    for (int i = 0; i <= folds; ++i)
        for (const double z : {-6.0, 6.0})
            roof.positions.push_back(glm::vec3(0.05 * (i - folds / 2), i % 2 ? 0.05 : 0, z + 0.003 * i));
    for (uint32_t i = 0; i < folds; ++i)
        for (const uint32_t k : {0u, 1u, 2u, 2u, 1u, 3u}) roof.indices.push_back(2 * i + k);
    Model model;
    model.materials = {{{1, 1, 1, 1}}};
    add(model, "roof", std::move(roof), 0);
    write_file(path_, to_glb(model));
    shot_.camera = {{0, {0.3, 9, 8}, {0, 0, 0}, {0, 1, 0}}, {7, {-0.4, 9, 8}, {0.2, 0, 0}, {0, 1, 0}}};
    shot_.sun = {{0, {0.1, 1, 0.2}}};
    for (const char* name : {"covered", "raw", "many_rays"}) EXPECT_EQ(dark_by(name, 100'000), 0u) << name;
}

// Walls whose back is not drawn stand through the floor: what shows right behind one is in its shadow, though
// the camera looks through it.
TEST_F(TerrainStart, WhatIsBehindAWallThatIsNotDrawnIsInItsShadow) {
    Shape walls;
    for (uint32_t i = 0; i < 200; ++i) {
        const double z = 0.0713 * i - 7;
        for (const double x : {-9.0, 9.0})
            for (const double y : {-0.02, 0.02}) walls.positions.push_back(glm::vec3(x, y, z + 0.003 * x));
        for (const uint32_t k : {0u, 1u, 2u, 2u, 1u, 3u}) walls.indices.push_back(4 * i + k);
    }
    Model model;
    model.materials = {{{1, 1, 1, 1}}};
    add(model, "floor", ground(20, 20, 1, 1), 0);
    add(model, "walls", std::move(walls), -1);  // glTF's default material has one side
    write_file(path_, to_glb(model));
    shot_.camera = {{0, {0.3, 4, 9}, {0, 0, 0}, {0, 1, 0}}};
    shot_.sun = {{0, {0.1, 0.6, 0.8}}};
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto reference = open_truth(gpu(), shot_, diagnostics, warnings, false);
    ASSERT_TRUE(reference) << diagnostics.text();
    const std::vector<float> truth = counted_truth(*reference, 0, 64).visibility;
    for (const char* name : {"covered", "many_rays"}) {
        SessionOptions options;
        options.size = shot_.size;
        options.jitter = false;
        options.captures = {"visibility"};
        const auto session = open_session(shipped_pipeline(name), shot_, options);
        session->run_frame(0, true);
        const auto mask = captured_planes(session->view(), "visibility")[0];
        size_t dark = 0, leaks = 0;
        for (size_t i = 0; i < truth.size(); ++i) {
            dark += truth[i] == 0;
            leaks += truth[i] == 0 && mask[i] == 1;
        }
        EXPECT_GT(dark, 5000u);
        EXPECT_EQ(leaks, 0u) << name;
    }
}

// The truth looks for what a pixel shows as far away as the rasteriser's grid may have moved it: by 4 bits of
// sub-pixel precision it finds all of 57 600 but one, and 89 fewer within a 64th of a pixel.
TEST_F(TerrainStart, TheTruthFindsWhatEachPixelShows) {
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto session = open_truth(gpu(), shot_, diagnostics, warnings, false);
    ASSERT_TRUE(session) << diagnostics.text();
    for (const uint32_t frame : {0u, 5u}) EXPECT_LE(counted_truth(*session, frame, 16).lost, 1u) << frame;
}

// The sun stands below the horizon: what is lit is lit by the lamp.
TEST_F(TerrainStart, NorByALampsTruth) {
    shot_.sun = {{0, {0.3, -0.8, 0.2}}};
    ShotLight lamp;
    lamp.kind = LightKind::point;
    lamp.radius = 0.2;
    lamp.keys = {{.frame = 0, .position = {8, 40, 8}}};
    shot_.lights["lamp"] = lamp;
    size_t receivers = 0, dark = 0;
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto session = open_light_truth(gpu(), shot_, "lamp", diagnostics, warnings, false);
    ASSERT_TRUE(session) << diagnostics.text();
    for (uint32_t frame = 0; frame < 8; ++frame) {
        const penumbra::Truth truth = counted_light_truth(*session, frame, 64);
        for (size_t i = 0; i < truth.visibility.size(); ++i) {
            receivers += truth.receiver[i] > 0;
            dark += truth.receiver[i] > 0 && truth.visibility[i] < 1;
        }
    }
    EXPECT_GT(receivers, 200'000u);
    EXPECT_EQ(dark, 0u);
}

// A lamp in the camera's eye shines on all that is seen: also on what of a floor shows beneath a plate a
// fifth of a millimetre high, whose outline the rasteriser has moved aside. Fifteen pixels, if what they are
// seen through hid the lamp.
TEST_F(TerrainStart, NorByWhatItSeesThrough) {
    Model model;
    model.materials = {{{1, 1, 1, 1}}};
    add(model, "floor", ground(20, 20, 1, 1), 0);
    for (int i = 0; i < 400; ++i) {
        Shape plate = box({-0.11, 0, -0.13}, {0.11, 0.0002, 0.13});
        plate.transform(
            glm::translate(glm::dmat4(1), {0.61 * (i % 20 - 10) + 0.017 * i, 0, 0.57 * (i / 20 - 10)}));
        add(model, fmt::format("plate_{}", i).c_str(), std::move(plate), 0);
    }
    write_file(path_, to_glb(model));
    shot_.sun = {{0, {0.3, -0.8, 0.2}}};
    ShotLight lamp;
    lamp.kind = LightKind::point;
    lamp.radius = 1e-4;
    size_t receivers = 0, dark = 0;
    for (uint32_t frame = 0; frame < 8; ++frame) {
        const glm::dvec3 eye(6.1 - 0.07 * frame, 5, 7.3);
        shot_.camera = {{0, {eye.x, eye.y, eye.z}, {0, 0, 0}, {0, 1, 0}}};
        lamp.keys = {{.frame = 0, .position = eye}};
        shot_.lights["lamp"] = lamp;
        Diagnostics diagnostics;
        std::vector<std::string> warnings;
        const auto session = open_light_truth(gpu(), shot_, "lamp", diagnostics, warnings, false);
        ASSERT_TRUE(session) << diagnostics.text();
        const penumbra::Truth truth = counted_light_truth(*session, 0, 64);
        for (size_t i = 0; i < truth.visibility.size(); ++i) {
            receivers += truth.receiver[i] > 0;
            dark += truth.receiver[i] > 0 && truth.visibility[i] < 1;
        }
    }
    EXPECT_GT(receivers, 300'000u);
    EXPECT_LE(dark, 2u);
}

INSTANTIATE_TEST_SUITE_P(Planes, RayStart,
                         ::testing::Values(Plane{"room", 20, 0, 0.4, 64}, Plane{"tilted", 60, 23, 1.7, 64},
                                           Plane{"desk", 0.5, 40, 0.2, 64}, Plane{"hall", 500, 0, 1.7, 1},
                                           Plane{"tilted_hall", 500, 23, 1.7, 1},
                                           Plane{"tilted_desert", 20000, 13, 1.7, 1},
                                           Plane{"slope", 2000, 31, 1.7, 64}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace penumbra::test
