// SPDX-License-Identifier: MIT
// Hard cases 1 to 6, 9, 46: far origins, scales, depth, normals, cameras that turn round. Numbers are those
// of docs/hard_cases.md; a test shows the naive form failing on the same input where it can be had.
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <limits>
#include <random>

#include "tests/hard_cases/hard_cases.h"
#include "tests/test_scene.h"

namespace penumbra::test {
namespace {

constexpr Extent wide{160, 96};

// ---- 1: the origin

// Where a point of the scene was a frame ago, in pixels: by matrices of absolute positions in single
// precision, against camera-relative ones that are made in double precision and then rounded.
double reprojection_error_px(double distance, bool naive) {
    const Extent extent{1920, 1080};
    const glm::dvec3 origin(distance, 0, distance);
    const Camera before = looking(origin, origin + glm::dvec3(0, 0, -1), 1, extent);
    const Camera now =
        looking(origin + glm::dvec3(0.01, 0, 0), origin + glm::dvec3(0.0117, 0, -1), 1, extent);
    FrameDescription description = frame_between(before, now, extent, 1, false);
    const FrameBlock block = make_frame_block(description);
    double worst = 0;
    for (int i = 0; i < 200; ++i) {
        const double x = 0.3 * std::sin(i * 1.7), y = 0.2 * std::cos(i * 2.3), z = 2 + i % 37;
        const glm::dmat3 axes = glm::make_mat3(now.world_from_view.data());
        const glm::dvec3 relative = axes * glm::dvec3(x * z, y * z, -z);
        const auto exact = [&](const glm::dvec3& rel) {
            const glm::dvec3 world = rel + glm::make_vec3(now.position.data());
            const glm::dvec3 view =
                glm::transpose(glm::dmat3(glm::make_mat3(before.world_from_view.data()))) *
                (world - glm::make_vec3(before.position.data()));
            const glm::dvec4 clip = glm::make_mat4(before.clip_from_view.data()) * glm::dvec4(view, 1);
            return glm::dvec2(clip) / clip.w;
        };
        glm::dvec2 found;
        if (naive) {
            const glm::mat4 clip_from_view(glm::make_mat4(before.clip_from_view.data()));
            const auto view_matrix = [](const Camera& c) {
                const glm::mat3 rotation(glm::transpose(glm::make_mat3(c.world_from_view.data())));
                return glm::translate(glm::mat4(rotation), -glm::vec3(glm::make_vec3(c.position.data())));
            };
            const glm::mat4 reproject =
                clip_from_view * view_matrix(before) * glm::inverse(clip_from_view * view_matrix(now));
            const glm::vec4 clip_now =
                clip_from_view * glm::vec4(float(x * z), float(y * z), float(-z), 1.0f);
            const glm::vec4 clip = reproject * clip_now;
            found = glm::dvec2(clip) / double(clip.w);
        } else {
            glm::mat4 m;
            for (int c = 0; c < 4; ++c)
                for (int r = 0; r < 4; ++r) m[c][r] = block.prev_clip_from_rel.columns[c][r];
            const glm::vec4 clip = m * glm::vec4(glm::vec3(relative), 1.0f);
            found = glm::dvec2(clip) / double(clip.w);
        }
        const glm::dvec2 error = 0.5 * (found - exact(relative)) * glm::dvec2(extent.width, extent.height);
        worst = std::max(worst, std::isfinite(error.x + error.y) ? glm::length(error) : 1e4);
    }
    return worst;
}

TEST(HardCoordinates, ReprojectionIsExactHoweverFarTheOriginIs) {
    for (const double distance : {1e2, 1e4, 1e5, 1e7}) {
        const double naive = reprojection_error_px(distance, true),
                     ours = reprojection_error_px(distance, false);
        figure(("case 1, px at " + std::to_string(distance)).c_str(), naive, ours);
        EXPECT_LT(ours, 2e-3);
        EXPECT_GT(naive, distance < 1e4 ? 0 : 0.3);
    }
}

TEST_F(HardCase, TheOriginIsNowhereToBeSeen) {
    const auto image = [](double distance) {
        Shot shot = plaza_shot({wide.width, wide.height}, 6);
        shot.origin = {distance, 0, -distance};
        return ShotRun("shadows_fast", shot).up_to(5);
    };
    const std::vector<float> here = image(0);
    for (const double distance : {1e3, 1e6, 1e7}) {
        const double error = rms(here, image(distance));
        figure(("case 1, RMSE against the origin at " + std::to_string(distance)).c_str(), NAN, error);
        EXPECT_LT(error, distance < 5e6 ? 1.0 / 255 : 5.0 / 255);
    }
}

// ---- 2: vertices far from the origin

Shape moved(Shape shape, const glm::dvec3& by) {
    for (glm::vec3& p : shape.positions) p += glm::vec3(by);
    return shape;
}

TEST_F(HardCase, VerticesFarFromTheOriginCastWhatTheyCastNearIt) {
    // Multiples of 1/8 m: exact in single precision at a million metres, where its unit is 1/16 m.
    const auto shapes = [](const glm::dvec3& by) {
        return std::vector<Placed>{{"floor", moved(ground(8, 8, 4, 4), by)},
                                   {"block", moved(box({-1, 0, -1}, {-0.5, 1.5, 0.5}), by)},
                                   {"bar", moved(box({0.5, 1, -2}, {0.625, 1.125, 2}), by)}};
    };
    const glm::dvec3 far(1048576, 0, -1048576);
    const Shot here = scene_shot("near", shapes({0, 0, 0}), {160, 96});
    Shot there = scene_shot("far", shapes(far), {160, 96});
    for (CameraKey& key : there.camera) {
        key.position += far;
        key.target += far;
    }
    const std::vector<float> expected = ShotRun("shadows_fast", here).up_to(7),
                             image = ShotRun("shadows_fast", there).up_to(7);
    EXPECT_GT(count_if(expected, [](float v) { return v < 0.1f; }), 150u);
    // Naive: a pixel's point in absolute coordinates of single precision is off by up to half their unit.
    const double unit_m = double(std::nextafter(1048576.0f, 1e9f)) - 1048576, pixel_m = 5.7 * 1.155 / 96;
    const double error = rms(expected, image);
    figure("case 2, px that absolute coordinates are off (naive), RMSE between near and far (ours)",
           0.5 * unit_m / pixel_m, error);
    EXPECT_LT(error, 1.0 / 255);
}

// ---- 3, 5, 46: depth and normals as they come

class GuidesRun {
  public:
    explicit GuidesRun(Extent extent)
        : extent_(extent),
          run_(shadow_pipeline(R"({ "penumbra": 1, "name": "guides", "inputs": { "depth": {}, "normal": {} },
              "outputs": ["view_depth", "guide_normal"], "nodes": { "guides": { "type": "guides" } } })"),
               extent, options()) {}
    void frame(const std::vector<float>& depth, const std::vector<std::array<uint16_t, 4>>& normal,
               const Camera& camera, uint32_t flags = 0) {
        run_.set("depth", depth);
        run_.set("normal", normal);
        FrameDescription description = frame_between(camera, camera, extent_, 0, true);
        description.flags |= flags;
        run_.frame(description);
    }
    std::vector<float> plane(const char* name, size_t channel = 0) {
        return captured_planes(run_.view(), name).at(channel);
    }

  private:
    static ViewRunOptions options() {
        ViewRunOptions options;
        options.formats = {{"depth", Format::r32f}, {"normal", Format::rgba16f}};
        return options;
    }
    Extent extent_;
    ViewRun run_;
};

TEST_F(HardCase, ReverseDepthKeepsItsDistanceFromTenCentimetresToAHundredKilometres) {
    const Extent extent{256, 1};
    const double near = 0.1, far = 1e4;
    Camera camera = looking({0, 0, 0}, {0, 0, -1}, 1, extent, near);
    std::vector<float> depth(256);
    std::vector<double> z(256);
    double naive = 0;
    for (size_t i = 0; i < 256; ++i) {
        z[i] = near * std::pow(1e6, (double(i) + 1) / 256);
        depth[i] = static_cast<float>(near / z[i]);
        // Standard depth of a finite range in the same 32 bits.
        const auto standard = static_cast<float>(far / (far - near) * (1 - near / z[i]));
        if (z[i] < 9e3)
            naive = std::max(naive, std::abs(near / (1 - standard * (far - near) / far) - z[i]) / z[i]);
    }
    GuidesRun run(extent);
    run.frame(depth, std::vector(256, to_half4({0, 0, 1, 0})), camera);
    const std::vector<float> found = run.plane("view_depth");
    double ours = 0;
    for (size_t i = 0; i < 256; ++i) ours = std::max(ours, std::abs(found[i] - z[i]) / z[i]);
    figure("case 3, relative error of the view depth", naive, ours);
    EXPECT_LT(ours, 1e-6);
    EXPECT_GT(naive, 1e-3);
}

TEST_F(HardCase, WhatIsNoDepthIsSky) {
    const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    const std::vector<float> depth = {0, 1, nan, inf, -inf, -0.5f, 2, -0.0f, 1e-40f, 0.25f};
    const Extent extent{static_cast<uint32_t>(depth.size()), 1};
    const Camera camera = looking({0, 0, 0}, {0, 0, -1}, 1, extent);
    GuidesRun run(extent);
    run.frame(depth, std::vector(depth.size(), to_half4({0, 0, 1, 0})), camera);
    const std::vector<float> z = run.plane("view_depth");
    size_t naive = 0;
    for (const float d : depth) {
        const float position = float(camera.near_m) / d;
        naive += d != 0.25f && !(std::isfinite(position) && position > 0 && d < 1);
    }
    for (size_t i = 0; i + 1 < depth.size(); ++i) EXPECT_EQ(z[i], 0) << depth[i];
    EXPECT_FLOAT_EQ(z.back(), float(camera.near_m) / 0.25f);
    figure("case 5, values that become no finite positive distance", double(naive), double(nonfinite(z)));
    for (size_t channel = 0; channel < 4; ++channel)
        EXPECT_EQ(nonfinite(run.plane("guide_normal", channel)), 0u);
}

TEST_F(HardCase, NormalsOfAnyLengthAreUnitAndOfNoneFaceTheCamera) {
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();
    const glm::dvec3 n = glm::normalize(glm::dvec3(0.3, -0.5, 0.7));
    const std::vector<std::array<uint16_t, 4>> normals = {to_half4({n.x, n.y, n.z, 0}),
                                                          to_half4({3 * n.x, 3 * n.y, 3 * n.z, 0}),
                                                          to_half4({n.x / 16, n.y / 16, n.z / 16, 0}),
                                                          to_half4({0, 0, 0, 0}),
                                                          to_half4({nan, 0, 0, 0}),
                                                          to_half4({inf, 0, -inf, 0})};
    const Extent extent{static_cast<uint32_t>(normals.size()), 1};
    GuidesRun run(extent);
    run.frame(std::vector<float>(normals.size(), 0.01f), normals, looking({0, 0, 0}, {0, 0, -1}, 1, extent));
    std::array<std::vector<float>, 3> got;
    for (size_t channel = 0; channel < 3; ++channel) got[channel] = run.plane("guide_normal", channel);
    for (size_t i = 0; i < normals.size(); ++i) {
        const glm::dvec3 found(2 * got[0][i] - 1, 2 * got[1][i] - 1, 2 * got[2][i] - 1);
        EXPECT_LT(glm::distance(found, i < 3 ? n : glm::dvec3(0, 0, 1)), 0.004) << i;  // 10 bits and fp16
    }
    size_t naive = 0;
    for (const auto& texel : normals) {
        const glm::vec3 plain =
            glm::normalize(glm::vec3(from_half(texel[0]), from_half(texel[1]), from_half(texel[2])));
        naive += !std::isfinite(plain.x + plain.y + plain.z);
    }
    figure("case 46, normals of 6 that become NaN", double(naive),
           double(nonfinite(got[0]) + nonfinite(got[1]) + nonfinite(got[2])));
    EXPECT_EQ(naive, 3u);
}

// ---- 4: what was behind the previous camera

TEST_F(HardCase, ATurnRoundLeavesNoHistory) {
    Shot shot = plaza_shot({wide.width, wide.height}, 8);
    const glm::dvec3 eye(0.5, 1.2, 0.2);
    shot.camera = {{0, eye, eye + glm::dvec3(1, -0.4, 0.2), {0, 1, 0}},
                   {3, eye, eye + glm::dvec3(1, -0.4, 0.2), {0, 1, 0}},
                   {4, eye, eye + glm::dvec3(-1, -0.4, -0.2), {0, 1, 0}}};
    shot.objects.clear();
    // Which tiles were proved is remembered by their places, which is no history of what is seen: all are
    // asked here.
    const RunOptions asks_all{.settings = {"nodes.beams.in.proved_before=null"}};
    ShotRun warm("shadows_fast", shot, asks_all), cold("shadows_fast", shot, asks_all);
    warm.up_to(3);
    const std::vector<float> turned = warm.frame(4, false), fresh = cold.frame(4, true);
    EXPECT_EQ(nonfinite(turned), 0u);
    // Naive: a division by w that forgets its sign puts points behind the camera, mirrored, on the screen.
    size_t mirrored = 0, behind = 0;
    const Camera before = camera_at(shot, 3, 160.0 / 96), now = camera_at(shot, 4, 160.0 / 96);
    const PlaneImages floor = see_plane({}, now, now, wide);
    for (size_t i = 0; i < floor.depth.size(); ++i) {
        if (!(floor.depth[i] > 0)) continue;
        const glm::dvec2 uv((double(i % wide.width) + 0.5) / wide.width,
                            (double(i / wide.width) + 0.5) / wide.height);
        const double z = floor.view_depth[i];
        const glm::dvec3 world = glm::make_vec3(now.position.data()) +
                                 glm::dmat3(glm::make_mat3(now.world_from_view.data())) *
                                     (z * glm::dvec3((2 * uv.x - 1) / now.clip_from_view[0],
                                                     (2 * uv.y - 1) / now.clip_from_view[5], -1));
        const glm::dvec3 view = glm::transpose(glm::dmat3(glm::make_mat3(before.world_from_view.data()))) *
                                (world - glm::make_vec3(before.position.data()));
        const glm::dvec4 clip = glm::make_mat4(before.clip_from_view.data()) * glm::dvec4(view, 1);
        if (clip.w > 0) continue;
        ++behind;
        const glm::dvec2 ndc = glm::dvec2(clip) / clip.w;
        mirrored += std::abs(ndc.x) < 1 && std::abs(ndc.y) < 1;
    }
    size_t kept = 0;
    for (size_t i = 0; i < turned.size(); ++i) kept += turned[i] != fresh[i];
    figure("case 4, share of points behind the previous camera that find a history", share(mirrored, behind),
           share(kept, turned.size()));
    EXPECT_GT(behind, 1000u);
    EXPECT_GT(mirrored, behind / 10);
    EXPECT_EQ(kept, 0u);
}

// ---- 9: scale

Shape scaled(Shape shape, double by) {
    for (glm::vec3& p : shape.positions) p *= float(by);
    return shape;
}

std::vector<float> scaled_scene(double scale, const std::string& pipeline, const RunOptions& options) {
    Shot shot = scene_shot("scale" + std::to_string(scale),
                           {{"floor", scaled(ground(8, 8, 4, 4), scale)},
                            {"block", scaled(box({-1.2, 0, -1}, {-0.4, 1.1, -0.2}), scale)},
                            {"bar", scaled(rod({-3, 1.5, 0}, {3, 1.5, 0.5}, 0.08, 12), scale)}},
                           {160, 96});
    for (CameraKey& key : shot.camera) {
        key.position *= scale;
        key.target *= scale;
    }
    shot.near *= scale;
    return ShotRun(pipeline, shot, options).up_to(7);
}

TEST_F(HardCase, TheUnitOfLengthIsNowhereToBeSeen) {
    // Naive: lengths in metres, for a ray's start (0.1 mm, 4 cm) and for the filters' depth (1 m).
    const RunOptions absolute{.settings = {"nodes.trace.params.origin=published"}};
    const std::vector<float> metres = scaled_scene(1, "shadows_fast", {}),
                             absolute_metres = scaled_scene(1, "fidelityfx", absolute);
    for (const double scale : {1e-3, 1e3}) {
        const double naive = rms(absolute_metres, scaled_scene(scale, "fidelityfx", absolute));
        const double ours = rms(metres, scaled_scene(scale, "shadows_fast", {}));
        figure(("case 9, RMSE against metres at " + std::to_string(scale)).c_str(), naive, ours);
        EXPECT_LT(ours, 1.0 / 255);
        EXPECT_GT(naive, 2.0 / 255);
    }
}

// ---- 6: the half pixel

TEST_F(HardCase, ShadowsAreWhereTheyAreToATwentiethOfAPixel) {
    Shot shot;
    shot.analytic = AnalyticScene{.penumbra_px = 8};
    shot.size = {96, 64};
    shot.frames = 64;
    shot.sun = {{0, {0.3, 0.2, 1}}};
    const std::vector<float> mean = ShotRun("raw", shot).mean(64), truth = analytic_truth(shot, 0).visibility;
    Shot corners = shot;  // what the corners of the pixels see
    corners.analytic->offset_px = 0.5;
    const std::vector<float> at_corners = analytic_truth(corners, 0).visibility;
    const auto shift = [&](const std::vector<float>& image) {
        double excess = 0;
        for (size_t i = 0; i < image.size(); ++i) excess += image[i] - truth[i];
        return std::abs(excess) / shot.size[1];
    };
    const double shift_px = shift(mean);
    figure("case 6, px between the edge and its place", shift(at_corners), shift_px);
    EXPECT_GT(shift(at_corners), 0.4);
    EXPECT_LT(shift_px, 0.05);
}

}  // namespace
}  // namespace penumbra::test
