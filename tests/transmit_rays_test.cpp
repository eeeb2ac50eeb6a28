// SPDX-License-Identifier: MIT
// Coloured shadows in the pipelines that have the sun's mask from rays alone: half of a floor under an opaque
// sheet, and below that a pane that reaches further.
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

#include "app/session.h"
#include "host/models/glb_writer.h"
#include "host/truth/sun_visibility.h"
#include "tests/gpu_test.h"
#include "tests/scene_file.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

const glm::dvec3 red(0.9, 0.35, 0.1);
constexpr double pane_edge = 0.6, pane_height = 1, radius_deg = 6;
constexpr double stored = 0.5 / 255 + 1e-3;  // rounding: of the image, and of the pane's map

// A floor that ends at x, so high.
Shape half_plane(double x, double y) {
    Shape shape = ground(30, 30, 1, 1);
    for (glm::vec3& p : shape.positions) p += glm::vec3(float(x) - 30, float(y), 0);
    return shape;
}

Model floor_below(bool pane) {
    Model model;
    model.materials = {{{0.5f, 0.5f, 0.5f, 1}}, {{float(red.x), float(red.y), float(red.z), 1}}};
    model.materials[1].transmission = 1;
    add(model, "floor", ground(6, 6, 2, 2), 0);
    add(model, "opaque", half_plane(-0.7, 2), 0);
    if (pane) add(model, "pane", half_plane(pane_edge, pane_height), 1);
    return model;
}

class TransmitRays : public GpuTest, public ::testing::WithParamInterface<const char*> {
  protected:
    std::unique_ptr<Session> shown(bool pane, std::vector<std::string> captures) const {
        const SceneFile file("floor.glb", to_glb(floor_below(pane)));
        Shot shot;
        shot.model = file.path();
        shot.size = {160, 48};
        shot.frames = 4;
        shot.vertical_fov_deg = 60;
        shot.camera = {{0, {0, 0.95, 0.001}, {0, 0, 0}, {0, 1, 0}}};
        shot.sun_angular_radius_deg = radius_deg;
        shot.sun = {{0, {0, 1, 0}}};
        SessionOptions options;
        options.size = shot.size;
        options.jitter = false;
        options.captures = std::move(captures);
        auto session = open_session(shipped_pipeline(GetParam()), shot, options);
        for (uint32_t frame = 0; frame < shot.frames; ++frame) session->run_frame(frame, frame == 0);
        return session;
    }
};

TEST_P(TransmitRays, ColourTheMaskOfOpaqueTrianglesAndLeaveItAsItIs) {
    const auto session = shown(true, {"transmittance", "visibility", "view_depth"});
    const auto colours = captured_planes(session->view(), "transmittance");
    const auto depth = captured_planes(session->view(), "view_depth")[0],
               mask = captured_planes(session->view(), "visibility")[0];
    EXPECT_TRUE(mask == captured_planes(shown(false, {"visibility"})->view(), "visibility")[0]);
    const double across = std::tan(glm::radians(30.0)) * 160 / 48;
    size_t half = 0, below = 0, edge = 0;
    double square = 0;
    for (size_t i = 0; i < mask.size(); ++i) {
        const double x = ((double(i % 160) + 0.5) / 80 - 1) * across * double(depth[i]), v = double(mask[i]),
                     open = half_plane_visibility(std::atan2(x - pane_edge, pane_height),
                                                  glm::radians(radius_deg));
        for (size_t c = 0; c < 3; ++c) {
            const double through = red[glm::length_t(c)],
                         error = double(colours[c][i]) - v * (1 - (1 - through) * (1 - open));
            if (open == 0 || open == 1)
                EXPECT_NEAR(error, 0, stored) << i << ", channel " << c;
            else
                square += error * error / 3;
        }
        half += open == 0 && v > 0 && v < 1;
        below += open == 0 && v == 1;
        edge += open > 0 && open < 1;
    }
    EXPECT_GT(std::min({half, below, edge}), 300u);
    EXPECT_LT(std::sqrt(square / double(edge)), 0.03);  // of sixteen rays, one in doubt: .06 times 1 - red
}

INSTANTIATE_TEST_SUITE_P(Pipelines, TransmitRays, ::testing::Values("one_ray", "shadows", "many_rays"),
                         [](const auto& name) { return std::string(name.param); });

}  // namespace
}  // namespace penumbra::test
