// SPDX-License-Identifier: MIT
// The truth by brute force: against a closed form, and against Embree, which sees the scene through primary
// rays and samples of its own.
#include "app/truth.h"

#include <cmath>
#include <filesystem>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <random>

#include "host/models/glb_writer.h"
#include "host/truth/analytic.h"
#include "host/truth/sun_visibility.h"
#include "tests/alpha_oracle.h"
#include "tests/embree_scene.h"
#include "tests/gpu_test.h"
#include "tests/scene_file.h"
#include "tests/shot_run.h"
#include "tests/test_scene.h"

namespace penumbra::test {
namespace {

namespace fs = std::filesystem;

class Reference : public GpuTest {
  protected:
    static std::unique_ptr<Session> open(const Shot& shot) {
        Diagnostics diagnostics;
        std::vector<std::string> warnings;
        auto session = open_truth(gpu(), shot, diagnostics, warnings);
        if (!session) throw std::runtime_error(diagnostics.text());
        return session;
    }
};

struct FormError {
    double rms = 0, worst = 0;  // over the penumbra; over all receivers
    size_t penumbra = 0;
};

// 65 536 stratified rays per pixel of the penumbra against the closed form.
FormError converge(Session& session, uint32_t frame) {
    const Shot& shot = session.host().shot();
    const penumbra::Truth counted = counted_truth(session, frame, 65536), exact = analytic_truth(shot, frame);
    FormError out;
    double squares = 0;
    for (size_t p = 0; p < exact.visibility.size(); ++p) {
        if (exact.receiver[p] == 0) continue;
        EXPECT_EQ(counted.receiver[p], 1);
        const auto error = static_cast<double>(counted.visibility[p] - exact.visibility[p]);
        squares += error * error;
        out.worst = std::max(out.worst, std::abs(error));
        out.penumbra += exact.visibility[p] > 0 && exact.visibility[p] < 1;
    }
    out.rms = std::sqrt(squares / static_cast<double>(std::max<size_t>(out.penumbra, 1)));
    return out;
}

struct AnalyticCase {
    const char* name;
    AnalyticScene scene;
    double radius_deg = 0.2665, rms = 2e-4, worst = 1e-3;
    uint32_t height = 12;
};
// What ctest shows of a case.
void PrintTo(const AnalyticCase& c, std::ostream* out) {
    *out << c.name;
}

class AnalyticReference : public Reference, public ::testing::WithParamInterface<AnalyticCase> {};

// Real geometry through the whole pipeline, at a frame that was never rendered before: the caster must
// follow.
TEST_P(AnalyticReference, ConvergesToTheClosedForm) {
    const AnalyticCase& c = GetParam();
    Shot shot;
    shot.analytic = c.scene;
    shot.size = {44, c.height};
    shot.frames = 10;
    shot.sun_angular_radius_deg = c.radius_deg;
    shot.sun = {{0, {0.3, 0.2, 1}}};
    ASSERT_FALSE(analytic_problem(shot, 0)) << analytic_problem(shot, 0)->text;
    add_analytic_motion(shot);
    const FormError found = converge(*open(shot), 5);
    std::printf("%s: rms %.2g, largest %.2g over %zu pixels of penumbra\n", c.name, found.rms, found.worst,
                found.penumbra);
    EXPECT_GT(found.penumbra, 20u);
    EXPECT_LE(found.rms, c.rms);
    EXPECT_LE(found.worst, c.worst);
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, AnalyticReference,
    ::testing::Values(
        AnalyticCase{"half_plane", {16, 20, 1.5, -7.5, HalfPlane{}}},
        AnalyticCase{"tilted_60", {16, 20, 1.5, -7.5, HalfPlane{60}}},
        AnalyticCase{"tilted_85", {16, 70, 1.5, -7.5, HalfPlane{85}}},
        AnalyticCase{"slit", {16, 20, 1.5, -7.5, Slit{6}}},
        AnalyticCase{"fence", {16, 20, 1.5, -7.5, Fence{11, 0.4}}},
        AnalyticCase{"polygon", {16, 20, 1.5, -7.5, Polygon{{{-9, -4}, {8, -5}, {1, 0}, {10, 5}, {-7, 4}}}}},
        AnalyticCase{
            "sphere", {12, 20, 1.5, -7.5, Sphere{5}}, 5, 2e-4, 1e-3, 2},  // a ball has many triangles
        // Facets twice as far off the ball: rms 2.6e-4; rays that start 1/256 pixel off the receiver
        // besides: 3.7e-4.
        AnalyticCase{"contact_point", {0, 20, 0.5, 6, ContactPoint{20}}, 5},
        AnalyticCase{"contact_wall", {0, 20, 1.5, 4, ContactWall{1}}, 5},
        // With normals of 10 bits and rays that may pass over a strip's end, rms 7.8e-3.
        AnalyticCase{"terminator", {32, 0, 0, 0, Terminator{}}, 5}),
    [](const auto& instance) { return std::string(instance.param.name); });

// Uniform over the sun's cap, in double precision and by another map than the shader's.
glm::dvec3 towards_sun(const glm::dvec3& to_sun, double radius, double u, double v) {
    const double t = 2 * u * std::pow(std::sin(radius / 2), 2), sine = std::sqrt(t * (2 - t)),
                 angle = 2 * glm::pi<double>() * v;
    const glm::dvec3 side = glm::normalize(
        glm::cross(to_sun, std::abs(to_sun.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
    return sine * std::cos(angle) * side + sine * std::sin(angle) * glm::cross(to_sun, side) +
           (1 - t) * to_sun;
}

Ray make_ray(const glm::dvec3& origin, const glm::dvec3& direction) {
    Ray ray{};
    for (int i = 0; i < 3; ++i) {
        ray.origin[i] = static_cast<float>(origin[i]);
        ray.direction[i] = static_cast<float>(direction[i]);
    }
    ray.t_min = 0;
    ray.t_max = 1e6f;
    return ray;
}

struct Agreement {
    size_t pixels = 0, soft = 0, off = 0;  // off: by more than 0.03, at silhouettes
    double rms = 0;                        // of the others, in penumbrae
};

// Every few pixels of a frame.
Agreement compare_with_embree(Session& session, const Shot& shot, uint32_t frame) {
    const uint32_t width = shot.size[0], height = shot.size[1];
    const penumbra::Truth truth = counted_truth(session, frame, 4096);
    const AlphaOracle alpha(session.host().scene());
    const EmbreeScene embree(
        session.host().scene().triangles(frame),
        [&](uint32_t triangle, double u, double v) { return alpha.blocks(triangle, u, v); });

    const Camera camera = camera_at(shot, frame, double(width) / height);
    const glm::dmat3 axes = glm::make_mat3(camera.world_from_view.data());
    const glm::dvec3 eye =
        glm::make_vec3(camera.position.data()) - session.host().scene().bvh_origin() - shot.origin;
    const SunState sun = sun_at(shot, frame);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> in(0, 1);
    constexpr int side = 40;
    size_t pixels = 0, off = 0, soft = 0;
    double squares = 0;
    for (uint32_t p = 0; p < width * height; p += static_cast<uint32_t>(1 + random() % 12)) {
        const double ndc_x = 2 * (p % width + 0.5) / width - 1, ndc_y = 2 * (p / width + 0.5) / height - 1;
        const glm::dvec3 view =
            axes * glm::dvec3(ndc_x / camera.clip_from_view[0], ndc_y / camera.clip_from_view[5], -1);
        const auto hit = embree.nearest(make_ray(eye, view));
        if (!hit || truth.receiver[p] == 0) {
            off += hit.has_value() != (truth.receiver[p] != 0);
            continue;
        }
        glm::dvec3 n = glm::normalize(glm::dvec3(hit->normal[0], hit->normal[1], hit->normal[2]));
        if (glm::dot(n, view) > 0) n = -n;
        const glm::dvec3 origin = eye + static_cast<double>(hit->t) * view + 2e-4 * n;
        int lit = 0;
        for (int i = 0; i < side * side; ++i) {
            const glm::dvec3 d = towards_sun(sun.to_sun, sun.angular_radius, (i % side + in(random)) / side,
                                             (i / side + in(random)) / side);
            lit += glm::dot(n, d) > 0 && !embree.occluded(make_ray(origin, d));
        }
        const double expected = static_cast<double>(lit) / (side * side),
                     error = static_cast<double>(truth.visibility[p]) - expected;
        ++pixels;
        soft += expected > 0.02 && expected < 0.98;
        if (std::abs(error) > 0.03)
            ++off;  // the pixel's centre lies on a silhouette
        else
            squares += error * error;
    }
    const double rms = std::sqrt(squares / static_cast<double>(std::max<size_t>(soft, 1)));
    std::printf("%s against Embree: %zu pixels, %zu in penumbrae, %zu off, rms there %.2g\n",
                shot.name.c_str(), pixels, soft, off, rms);
    return {pixels, soft, off, rms};
}

TEST_F(Reference, AgreesWithEmbree) {
    Shot shot = plaza_shot({160, 90}, 8);
    shot.sun_angular_radius_deg = 6;
    const Agreement seen = compare_with_embree(*open(shot), shot, 6);
    EXPECT_GT(seen.pixels, 1500u);
    EXPECT_GT(seen.soft, 60u);
    EXPECT_LE(seen.off, seen.pixels / 300);
    EXPECT_LE(seen.rms, 6e-3);  // what 1600 stratified rays leave
}

// Holes are seen and cast alike: the primary ray goes through the same mask as the raster, the shadow rays as
// trace's. Many pixels show a leaf's edge here.
TEST_F(Reference, AgreesWithEmbreeBehindLeafCards) {
    Shot shot = shot_named("cards");
    shot.size = {96, 54};
    const Agreement seen = compare_with_embree(*open(shot), shot, 2);
    EXPECT_GT(seen.pixels, 500u);
    EXPECT_GT(seen.soft, 50u);
    EXPECT_LE(seen.off, seen.pixels / 100);
    EXPECT_LE(seen.rms, 1e-2);
}

// A wall on the floor, as high as the lift of 1/512 pixel that rays of a rasterised point need, and a
// fiftieth of a pixel beside the point: its edge is half of a sun's height up, and whoever starts on that
// lift looks over it.
TEST_F(Reference, JudgesContactsByThePointItself) {
    Shot shot;
    shot.size = {64, 36};
    shot.vertical_fov_deg = 40;
    shot.near = 0.01;
    shot.camera = {{0, {0, 6, 0}, {0, 0, 0}, {0, 0, -1}}};
    shot.sun_angular_radius_deg = 5;
    shot.sun = {{0, {1, 0.03, 0}}};
    const double pixel = 2 * 6 * std::tan(glm::radians(20.0)) / 36;
    const auto wall_x = static_cast<float>(-0.48 * pixel), height = static_cast<float>(pixel / 512);
    Model model;
    const auto quad = [&](std::vector<glm::vec3> corners) {
        Part part;
        part.positions = std::move(corners);
        part.indices = {0, 1, 2, 0, 2, 3};
        model.meshes.push_back({{part}});
        model.nodes.emplace_back().mesh = static_cast<int>(model.meshes.size()) - 1;
    };
    quad({{-9, 0, -9}, {-9, 0, 9}, {9, 0, 9}, {9, 0, -9}});
    quad({{wall_x, 0, -9}, {wall_x, height, -9}, {wall_x, height, 9}, {wall_x, 0, 9}});
    const SceneFile file("contact.glb", to_glb(model));
    shot.model = file.path();
    const auto session = open(shot);
    const penumbra::Truth truth = counted_truth(*session, 0, 16384);
    const size_t p = 18 * size_t{shot.size[0]} + 31;
    ASSERT_EQ(truth.receiver[p], 1);
    // The wall hides what is below the plane through its edge and the point, which the floor's own plane is
    // part of.
    const auto seen_above = [&](double from_height) {
        const double edge = std::atan2(height - from_height, wall_x + 0.5 * pixel);
        return half_plane_visibility(std::atan(0.03) - edge, glm::radians(5.0));
    };
    EXPECT_NEAR(truth.visibility[p], seen_above(0), 2e-3);
    EXPECT_GT(seen_above(height), seen_above(0) + 0.2) << "what a lift would see is no other";
}

// All pixels have the same rays, and those that no triangle can reach need none of them to be exact.
TEST_F(Reference, MoreRaysChangePenumbraeAlone) {
    const Shot shot = plaza_shot({160, 90}, 1);
    const auto session = open(shot);
    const penumbra::Truth few = counted_truth(*session, 0, 256), many = counted_truth(*session, 0, 1024);
    EXPECT_EQ(few.lost + many.lost, 0u);
    size_t soft = 0, receivers = 0;
    for (size_t p = 0; p < many.rays.size(); ++p) {
        EXPECT_EQ(many.rays[p], many.receiver[p] * 1024);
        receivers += many.receiver[p] > 0;
        soft += few.visibility[p] != many.visibility[p];
        EXPECT_NEAR(few.visibility[p], many.visibility[p], 0.05);
    }
    EXPECT_GT(soft, receivers / 200);
    EXPECT_LT(soft, receivers / 2);
    EXPECT_EQ(rays_cast(1000), 1024u);
}

}  // namespace
}  // namespace penumbra::test
