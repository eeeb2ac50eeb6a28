// SPDX-License-Identifier: MIT
// The exact area of what hides a light (coverage_oracle.h) against closed forms, against thousands of points,
// against the images known in closed form, and against the reference renderer.
#include "tests/coverage_oracle.h"

#include <cmath>
#include <numbers>
#include <random>

#include "host/truth/analytic.h"
#include "tests/cover_run.h"

namespace penumbra::test {
namespace {

using std::numbers::pi;

glm::dvec3 line(double angle, double c) {
    return {std::cos(angle), std::sin(angle), c};
}
double half_disc(double c) {
    return 0.5 + (c * std::sqrt(1 - c * c) + std::asin(c)) / pi;
}
double share(const std::vector<ConvexPart>& parts, double radius = 0) {
    return hidden_share(parts, radius);
}

TEST(CoverageOracle, GivesTheClosedForms) {
    for (double angle = 0; angle < 2 * pi; angle += pi / 7)
        for (const double c : {-0.999, -0.5, 0.0, 0.25, 0.9}) {
            EXPECT_NEAR(share({{line(angle, c)}}), half_disc(c), 1e-9);
            // A strip; its two sides as two half-planes; one that holds the other.
            EXPECT_NEAR(share({{line(angle, c), line(angle + pi, 0.3)}}),
                        std::max(half_disc(c) - half_disc(-0.3), 0.0), 1e-9);
            EXPECT_NEAR(share({{line(angle, c)}, {line(angle + pi, -c)}}), 1, 1e-9);
            EXPECT_NEAR(share({{line(angle, c)}, {line(angle, c / 2 - 0.5)}}), half_disc(c), 1e-9);
            // Wedges at the middle.
            for (const double opening : {0.1, 1.0, 3.0})
                EXPECT_NEAR(share({{line(angle, 0), line(angle + pi - opening, 0)}}), opening / (2 * pi),
                            1e-9);
        }
    EXPECT_EQ(share({}), 0);
    EXPECT_EQ(share({{}}), 0);
    EXPECT_NEAR(share({{line(0, 2)}}), 1, 1e-12);
    // A plane through the cap's middle halves it; a lune of two is its angle's share.
    for (const double radius : {0.005, 0.2, 1.0}) {
        EXPECT_NEAR(share({{line(1, 0)}}, radius), 0.5, 1e-9);
        EXPECT_NEAR(share({{line(1, 0), line(1 + pi - 0.7, 0)}}, radius), 0.7 / (2 * pi), 1e-9);
        EXPECT_NEAR(share({{line(1, 2)}}, radius), 1, 1e-9);
    }
}

TEST(CoverageOracle, AgreesWithManyRays) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> in(-1, 1);
    for (const double radius : {0.005, 0.3})
        for (int scene = 0; scene < 6; ++scene) {
            const SeenLight light = seen_light({0.3, 0.9, -0.2}, radius);
            struct Corners {
                glm::dvec3 v[3];
            };
            std::vector<Corners> triangles(8);
            std::vector<ConvexPart> parts;
            for (Corners& t : triangles) {
                // One in four reaches behind the receiver.
                for (int k = 0; k < 3; ++k)
                    t.v[k] = (in(random) < -0.5 && k == 0 ? -1.0 : 2.0 + in(random)) *
                             (light.axes * glm::dvec3(1.3 * std::tan(radius) * in(random),
                                                      1.3 * std::tan(radius) * in(random), 1));
                parts.push_back(hidden_by(light, glm::dvec3(0), {t.v[0], t.v[1], t.v[2]}));
            }
            constexpr int side = 500;
            int hidden = 0;
            for (int i = 0; i < side * side; ++i) {
                const double u = (i % side + 0.5 + 0.5 * in(random)) / side,
                             angle = 2 * pi * (i / side + 0.5 + 0.5 * in(random)) / side;
                const double cosine = 1 - u * (1 - std::cos(radius)), sine = std::sqrt(1 - cosine * cosine);
                const glm::dvec3 d =
                    light.axes * glm::dvec3(sine * std::cos(angle), sine * std::sin(angle), cosine);
                bool met = false;
                for (const Corners& t : triangles) {  // Moeller and Trumbore 1997
                    const glm::dvec3 e1 = t.v[1] - t.v[0], e2 = t.v[2] - t.v[0], p = glm::cross(d, e2),
                                     s = -t.v[0];
                    const double det = glm::dot(e1, p), a = glm::dot(s, p) / det;
                    const glm::dvec3 q = glm::cross(s, e1);
                    const double b = glm::dot(d, q) / det;
                    met = met || (a >= 0 && b >= 0 && a + b <= 1 && glm::dot(e2, q) / det > 0);
                }
                hidden += met;
            }
            EXPECT_NEAR(share(parts, radius), hidden / double(side * side), 1e-3);
        }
}

class CoverageOracleOn : public GpuTest {};

// Real geometry, seen by these scenes' orthographic camera from above; a hundredth of a millimetre off the
// receiver, whose corners are rounded.
TEST_F(CoverageOracleOn, AgreesWithTheClosedFormOfAnImage) {
    for (const AnalyticScene& scene :
         {AnalyticScene{16, 20, 0, -7.5, HalfPlane{}}, AnalyticScene{16, 20, 0, -7.5, Slit{6}},
          AnalyticScene{16, 20, 0, -7.5, Polygon{{{-9, -4}, {8, -5}, {1, 0}, {10, 5}, {-7, 4}}}}}) {
        Shot shot;
        shot.analytic = scene;
        shot.size = {44, 12};
        shot.sun = {{0, {0.3, 0.2, 1}}};
        const std::vector<double> exact = analytic_image(shot, 0);
        CoverRun run(shot, {.samples = 256});
        run.frame(0);
        const Camera camera = analytic_camera(shot);
        double worst = 0, worst_node = 0;
        for (uint32_t y = 0; y < 12; ++y)
            for (uint32_t x = 0; x < 44; ++x) {
                worst_node = std::max(worst_node,
                                      std::abs(double(run.visibility[run.at(x, y)]) - exact[run.at(x, y)]));
                const SeenLight light = seen_light(run.to_sun(), run.angular_radius());
                std::vector<ConvexPart> parts;
                const glm::dmat4 clip = glm::make_mat4(camera.clip_from_view.data());
                const glm::dmat3 world = glm::make_mat3(camera.world_from_view.data());
                const glm::dvec2 ndc((x + 0.5) / 44 * 2 - 1, (y + 0.5) / 12 * 2 - 1);
                glm::dvec3 at =
                    glm::make_vec3(camera.position.data()) +
                    world * glm::dvec3((ndc.x - clip[3].x) / clip[0].x, (ndc.y - clip[3].y) / clip[1].y, 0);
                at -= world[2] * (at.z / world[2].z);
                for (const Triangle& t : run.triangles)
                    parts.push_back(hidden_by(
                        light, at - run.run().session().host().scene().bvh_origin() + glm::dvec3(0, 0, 1e-5),
                        {corner(t, 0), corner(t, 1), corner(t, 2)}));
                worst =
                    std::max(worst, std::abs(1 - share(parts, run.angular_radius()) - exact[run.at(x, y)]));
            }
        std::printf("oracle off by up to %.2g, the node by up to %.4f\n", worst, worst_node);
        EXPECT_LT(worst, 1e-3);
        EXPECT_LT(worst_node, 0.02);
    }
}

TEST_F(CoverageOracleOn, AgreesWithTheReferenceRenderer) {
    Shape soup = box({-0.5, 0.3, -0.2}, {0.4, 0.8, 0.3});
    soup.append(rod({-1, 0.9, 0.5}, {1, 1.1, -0.4}, 0.03, 5));
    Shot shot = scene_shot("oracle", {{"soup", soup}, {"floor", ground(3, 3, 1, 1)}}, {48, 27});
    shot.camera = {{0, {0.2, 2, 2}, {-0.3, 0, -0.2}, {0, 1, 0}}};
    shot.sun_angular_radius_deg = 5;
    CoverRun run(shot);
    run.frame(0);
    const penumbra::Truth counted = truth_of(shot, 0, 4096);
    double squares = 0, worst = 0;
    size_t partial = 0;
    for (uint32_t y = 0; y < 27; ++y)
        for (uint32_t x = 0; x < 48; ++x) {
            if (!run.is_receiver(x, y)) continue;
            const double exact = exact_visibility(run, x, y),
                         e = double(counted.visibility[run.at(x, y)]) - exact;
            partial += exact > 0 && exact < 1;
            squares += e * e;
            worst = std::max(worst, std::abs(e));
        }
    std::printf("%zu pixels of penumbra: rms %.5f, largest %.4f\n", partial,
                std::sqrt(squares / double(partial)), worst);
    EXPECT_GT(partial, 20u);
    EXPECT_LT(std::sqrt(squares / double(partial)), 1.5e-3);
    EXPECT_LT(worst, 6e-3);
}

}  // namespace
}  // namespace penumbra::test
