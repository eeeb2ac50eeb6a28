// SPDX-License-Identifier: MIT
// The truth by brute force: against a closed form, and against Embree, which sees the scene through primary
// rays and samples of its own.
#include "app/truth.h"

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <random>

#include "host/analytic.h"
#include "tests/alpha_oracle.h"
#include "tests/embree_scene.h"
#include "tests/gpu_test.h"
#include "tests/test_scene.h"

namespace penumbra::test {
namespace {

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

TEST_F(Reference, ConvergesToTheClosedFormOfAHalfPlane) {
    Shot shot;
    shot.analytic = AnalyticScene{16, 20, 1.5, -7.5};
    shot.size = {44, 12};
    shot.frames = 10;
    shot.sun = {{0, {0.3, 0.2, 1}}};
    add_analytic_motion(shot);
    const auto session = open(shot);
    const uint32_t frame = 5;  // never rendered before: the sheet must follow
    const penumbra::Truth counted = counted_truth(*session, frame, 65536),
                          exact = analytic_truth(shot, frame);
    double squares = 0, worst = 0;
    size_t penumbra = 0;
    for (size_t p = 0; p < exact.visibility.size(); ++p) {
        const auto error = static_cast<double>(counted.visibility[p] - exact.visibility[p]);
        squares += error * error;
        worst = std::max(worst, std::abs(error));
        penumbra += exact.visibility[p] > 0 && exact.visibility[p] < 1;
        EXPECT_EQ(counted.receiver[p], 1);
    }
    const double rms = std::sqrt(squares / static_cast<double>(penumbra));
    std::printf("half-plane, 65536 rays: rms %.2g, largest %.2g over %zu pixels of penumbra\n", rms, worst,
                penumbra);
    EXPECT_GT(penumbra, 100u);
    EXPECT_LE(rms, 2e-4);
    EXPECT_LE(worst, 1e-3);
}

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
    Diagnostics diagnostics;
    auto shot = read_shot(std::filesystem::path(PENUMBRA_SOURCE_DIR) / "scenes/cards.shot.json", diagnostics);
    ASSERT_TRUE(shot) << diagnostics.text();
    shot->size = {96, 54};
    const Agreement seen = compare_with_embree(*open(*shot), *shot, 2);
    EXPECT_GT(seen.pixels, 500u);
    EXPECT_GT(seen.soft, 50u);
    EXPECT_LE(seen.off, seen.pixels / 100);
    EXPECT_LE(seen.rms, 1e-2);
}

// Seeds are independent truths of the same thing, and few rays only stay where nothing happens.
TEST_F(Reference, SpendsItsRaysWhereTheShadowEdgesAre) {
    const Shot shot = plaza_shot({160, 90}, 1);
    const auto session = open(shot);
    const penumbra::Truth few = counted_truth(*session, 0, 256), many = counted_truth(*session, 0, 1024);
    size_t dense = 0, receivers = 0;
    for (size_t p = 0; p < many.rays.size(); ++p) {
        if (many.receiver[p] == 0) {
            EXPECT_EQ(many.rays[p], 0);
            continue;
        }
        ++receivers;
        EXPECT_TRUE(many.rays[p] == 64 || many.rays[p] == 1024) << many.rays[p];
        EXPECT_EQ(few.rays[p] == 256, many.rays[p] == 1024);
        dense += many.rays[p] == 1024;
        EXPECT_TRUE(many.rays[p] == 1024 || many.visibility[p] == 0 || many.visibility[p] == 1);
    }
    EXPECT_GT(dense, receivers / 100);
    EXPECT_LT(dense, receivers / 2);
    EXPECT_EQ(rays_cast(1000), 1024u);
}

}  // namespace
}  // namespace penumbra::test
