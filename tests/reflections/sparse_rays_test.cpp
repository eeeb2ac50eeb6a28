// SPDX-License-Identifier: MIT
// Pixels without a ray of their own: `rays` of radiance_rays, and rays that a host casts where it likes.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <tuple>

#include "host/models/model_builder.h"
#include "tests/gpu_test.h"
#include "tests/reflections/radiance_run.h"
#include "tests/shipped.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

class SparseRays : public GpuTest {};

Shot floor_in_motion(const std::vector<float>& roughness, uint32_t frames) {
    Shot shot = night_shot(striped_floor(roughness), {96, 54}, frames);
    shot.camera.push_back({8, {0.8, 1.4, 2.8}, {0.2, 0, 0}, {0, 1, 0}});
    return shot;
}

std::vector<std::string> rays(const std::string& which) {
    return {"nodes.rays.params.rays=" + which};
}

// Every pixel of a surface has its turn: of four frames it has a ray in four, two or one; a mirror in all.
TEST_F(SparseRays, ComeInTurns) {
    for (const auto& [roughness, which, turns] :
         {std::tuple{0.3f, "all", 4u}, {0.3f, "half", 2u}, {0.3f, "quarter", 1u}, {0.0f, "quarter", 4u}}) {
        Shot shot = night_shot(striped_floor({roughness}), {57, 33}, 4);
        shot.environment = linear_sky(1, 1);
        const auto session = open_shipped("raw_reflections", shot, rays(which), {}, {}, false);
        std::vector<uint32_t> times;
        for (uint32_t frame = 0; frame < 4; ++frame) {
            session->run_frame(frame, frame == 0);
            const auto image = colors(*session)[0];
            times.resize(image.size());
            for (size_t i = 0; i < image.size(); ++i) times[i] += image[i] > 0;
        }
        const auto surfaces = times.size() - static_cast<size_t>(std::ranges::count(times, 0u));
        EXPECT_GT(surfaces, 500u);
        EXPECT_EQ(static_cast<size_t>(std::ranges::count(times, turns)), surfaces) << which << roughness;
    }
}

// Squared error against the truth, summed over the frame's channels, after some frames of a standing shot.
double error_of(const Shot& shot, const PlanarImage& truth, const std::string& which) {
    const auto session = open_shipped("reflections", shot, rays(which));
    double sum = 0;
    for (uint32_t frame = 0; frame < 12; ++frame) {
        session->run_frame(frame, frame == 0);
        if (frame < 4) continue;
        const auto image = colors(*session);
        for (size_t c = 0; c < 3; ++c)
            for (size_t i = 0; i < image[c].size(); ++i)
                if (truth.planes[3].values[i] > 0)
                    sum += std::pow(double(image[c][i]) - truth.planes[c].values[i], 2);
    }
    return sum;
}

// Half of the rays are worth about half as much, not the black of the pixels that have none.
TEST_F(SparseRays, AreWorthTheirShare) {
    Shot shot = night_shot(striped_floor({0.2f, 0.4f, 0.8f}), {64, 36}, 12);
    shot.environment = linear_sky(0, 4);
    const PlanarImage truth = truth_of(shot, "specular", 512);
    const double all = error_of(shot, truth, "all"), half = error_of(shot, truth, "half"),
                 quarter = error_of(shot, truth, "quarter");
    std::printf("error of half of the rays %.2f, of a quarter %.2f of that of all\n", half / all,
                quarter / all);
    EXPECT_LT(half, 2.4 * all);
    EXPECT_LT(quarter, 5 * all);
}

TEST_F(SparseRays, AWhiteFurnaceStaysWhite) {
    Shot shot = floor_in_motion({0, 0.005f, 0.02f, 0.1f, 0.2f, 0.4f, 0.8f, 1}, 7);
    shot.environment = linear_sky(1, 1);
    for (const char* which : {"half", "quarter"})
        for (const char* pipeline : {"reflections", "indirect"}) {
            const auto session = open_shipped(pipeline, shot, rays(which));
            size_t ones = 0;
            for (uint32_t frame = 0; frame < 7; ++frame) {
                session->run_frame(frame, frame == 0);
                const auto image = colors(*session);
                for (size_t i = 0; i < image[0].size(); ++i) {
                    if (image[0][i] == 0) continue;  // sky
                    ++ones;
                    ASSERT_NEAR(image[0][i], 1, 1e-3)
                        << pipeline << which << ", pixel " << i << ", frame " << frame;
                }
            }
            EXPECT_GT(ones, 7 * 1000u);
        }
}

// Rays of half of the pixels for either lobe are one ray in each.
TEST_F(SparseRays, OneLobePerPixel) {
    Shot shot = floor_in_motion({0.3f}, 4);
    shot.environment = linear_sky(1, 1);
    const auto session = open_shipped("lit_fast", shot, {}, {"radiance", "diffuse_radiance"});
    for (uint32_t frame = 0; frame < shot.frames; ++frame) {
        session->run_frame(frame, frame == 0);
        const auto specular = captured<std::array<uint16_t, 4>>(session->view(), "radiance"),
                   diffuse = captured<std::array<uint16_t, 4>>(session->view(), "diffuse_radiance");
        size_t surfaces = 0;
        for (size_t i = 0; i < specular.size(); ++i) {
            const int rays = (specular[i][3] != 0) + (diffuse[i][3] != 0);
            ASSERT_LE(rays, 1) << "pixel " << i << ", frame " << frame;
            surfaces += static_cast<size_t>(rays);
        }
        EXPECT_GT(surfaces, 1000u);
    }
}

TEST_F(SparseRays, AHostMayCastWhereItLikes) {
    Shot shot = floor_in_motion({0, 0.1f, 0.3f, 0.8f}, 4);
    shot.environment = linear_sky(1, 1);
    const auto session =
        open_shipped("reflections", shot,
                     {"nodes.rays.params.hit_normals=false", "nodes.reconnect.params.hit_normals=false"},
                     {"radiance", "ray_direction"});
    ViewRun host(shipped_pipeline("denoise_radiance"), {shot.size[0], shot.size[1]}, radiance_host_options());
    for (uint32_t frame = 0; frame < shot.frames; ++frame) {
        session->run_frame(frame, frame == 0);
        hand_over_guides(host, *session);
        // Three pixels of five have none, mirrors as well.
        auto radiance = captured<std::array<uint16_t, 4>>(session->view(), "radiance");
        for (size_t i = 0; i < radiance.size(); ++i)
            if ((i % 96 + 2 * (i / 96) + frame) % 5 > 1) radiance[i] = {};
        host.set("radiance", radiance);
        host.set("ray_direction", captured<uint32_t>(session->view(), "ray_direction"));
        host.frame(session->frame_description());
        const auto truth = colors(*session)[0], image = captured_planes(host.view(), "specular").at(0);
        for (size_t i = 0; i < image.size(); ++i)
            if (truth[i] > 0) {
                ASSERT_NEAR(image[i], 1, 1e-3) << "pixel " << i << ", frame " << frame;
            }
    }
}

}  // namespace
}  // namespace penumbra::test
