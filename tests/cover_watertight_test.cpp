// SPDX-License-Identifier: MIT
// No sample of the node `cover` slips through an edge of a closed surface, however it lies across the light,
// and few do at corners: their lines are quantised each for itself and need not meet in a point, so that a
// sample beside it can be on the outer side of all. And nothing hides a sample where nothing is.
#include <glm/gtc/matrix_transform.hpp>
#include <map>

#include "tests/cover_run.h"

namespace penumbra::test {
namespace {

class CoverWatertight : public GpuTest {};

Shape icosphere(double radius, int cuts) {
    const double g = (1 + std::sqrt(5.0)) / 2;
    std::vector<glm::dvec3> points;
    for (const double a : {-1.0, 1.0})
        for (const double b : {-g, g})
            for (const glm::dvec3& p : {glm::dvec3(0, a, b), glm::dvec3(a, b, 0), glm::dvec3(b, 0, a)})
                points.push_back(glm::normalize(p));
    std::vector<std::array<uint32_t, 3>> faces;
    for (uint32_t i = 0; i < 12; ++i)
        for (uint32_t j = i + 1; j < 12; ++j)
            for (uint32_t k = j + 1; k < 12; ++k) {
                const auto near = [&](uint32_t a, uint32_t b) {
                    return glm::length(points[a] - points[b]) < 1.06;
                };
                if (!near(i, j) || !near(j, k) || !near(i, k)) continue;
                const bool out =
                    glm::dot(glm::cross(points[j] - points[i], points[k] - points[i]), points[i]) > 0;
                faces.push_back(out ? std::array{i, j, k} : std::array{i, k, j});
            }
    for (int cut = 0; cut < cuts; ++cut) {
        std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
        std::vector<std::array<uint32_t, 3>> finer;
        const auto middle = [&](uint32_t a, uint32_t b) {
            const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), uint32_t(points.size()));
            if (is_new) points.push_back(glm::normalize(points[a] + points[b]));
            return at->second;
        };
        for (const auto& [a, b, c] : faces) {
            const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        faces = std::move(finer);
    }
    Shape shape;
    for (const glm::dvec3& p : points) shape.positions.emplace_back(radius * p);
    for (const auto& f : faces) shape.indices.insert(shape.indices.end(), f.begin(), f.end());
    return shape;
}

// Grids of squares on all six sides.
Shape gridded_box(double half, int cells) {
    Shape shape;
    for (int face = 0; face < 6; ++face) {
        Shape side = ground(half, half, cells, cells);
        const glm::dmat4 turn =
            face < 4 ? glm::rotate(glm::dmat4(1), face * M_PI / 2, glm::dvec3(1, 0, 0))
                     : glm::rotate(glm::dmat4(1), (face == 4 ? 0.5 : -0.5) * M_PI, glm::dvec3(0, 0, 1));
        side.transform(turn * glm::translate(glm::dmat4(1), glm::dvec3(0, half, 0)));
        shape.append(side);
    }
    // The borders' corners are the same numbers only if they are rounded alike.
    for (glm::vec3& p : shape.positions)
        for (int a = 0; a < 3; ++a)
            p[a] = float(std::round(double(p[a]) * cells / (2 * half)) * 2 * half / cells);
    return shape;
}

// A closed ring of needles, sharp ones at its ends.
Shape needles(double radius, double half_height, int count) {
    const ProfilePoint profile[] = {{-half_height, 1e-3},
                                    {-half_height * 0.999, radius},
                                    {half_height, radius},
                                    {half_height * 1.001, 1e-3}};
    return lathe(profile, count);
}

struct Leaks {
    double samples = 0, seen = 0, most = 0;
    size_t pixels = 0, beside_no_corner = 0;
};

void add_leaks(Leaks& leaks, const CoverRun& run) {
    leaks.samples += double(counters_of(run.run().session().view(), "cover").at("pixels")) * run.samples();
    const double radius = std::tan(run.angular_radius());
    for (uint32_t y = 0; y < run.size()[1]; ++y)
        for (uint32_t x = 0; x < run.size()[0]; ++x) {
            const auto v = double(run.visibility[run.at(x, y)]);
            if (v == 0) continue;
            ++leaks.pixels;
            leaks.seen += v * run.samples();
            leaks.most = std::max(leaks.most, v);
            const glm::dvec3 start = run.start(x, y), to_sun = run.to_sun();
            // The receiver's own plane and an edge beside it are two lines that nearly agree, and quantised
            // apart.
            bool corner_ahead = std::abs(glm::dot(run.normal(x, y), to_sun)) < 1.3 * radius;
            for (const Triangle& t : run.triangles)
                for (int k = 0; k < 3 && !corner_ahead; ++k) {
                    const glm::dvec3 d = corner(t, k) - start;
                    const double along = glm::dot(d, to_sun);
                    corner_ahead = along > 0 && glm::length(d - along * to_sun) < 1.3 * radius * along;
                }
            leaks.beside_no_corner += !corner_ahead;
        }
}

struct Shell {
    const char* name;
    Shape shape;
    double share, most;  // of the samples that get in, at most; of a pixel's. Where 700 needles meet in a
                         // point, a few do
};

TEST_F(CoverWatertight, NothingGetsIntoAClosedSurface) {
    double samples = 0;
    const Shell shells[] = {{"sphere", icosphere(5, 5), 0, 0},
                            {"box", gridded_box(4, 40), 0, 0},
                            {"needles", needles(5, 20, 700), 2e-5, 0.2}};
    for (const Shell& shell : shells) {
        Leaks leaks;
        for (const double turn_deg : {0.0, 17.3, 45.0, 121.7}) {
            Shape turned = shell.shape;
            turned.transform(
                glm::rotate(glm::dmat4(1), glm::radians(turn_deg), glm::normalize(glm::dvec3(0.3, 1, -0.2))));
            Shot shot = scene_shot(shell.name + std::to_string(turn_deg),
                                   {{"shell", turned}, {"floor", ground(1.5, 1.5, 1, 1)}}, {256, 144});
            shot.camera = {{0, {0.1, 1.3, 1.9}, {0, -0.2, 0}, {0, 1, 0}}};
            shot.near = 0.01;
            shot.vertical_fov_deg = 80;
            shot.sun = {{0, turn_deg == 0 ? glm::dvec3(0, 1, 0) : glm::dvec3(0.4, 0.8, 0.2)}};
            for (const double angle_deg : {0.2665, 3.0}) {
                shot.sun_angular_radius_deg = angle_deg;
                CoverRun run(shot, {.samples = turn_deg == 45 ? 256u : 128u, .seed = uint32_t(turn_deg)});
                for (uint32_t frame = 0; frame < 2; ++frame) {
                    run.frame(frame);
                    add_leaks(leaks, run);
                }
            }
        }
        std::printf(
            "%s: of %.3g samples %.0f get in, in %zu pixels, up to %.4f of one's; %zu pixels have no corner "
            "before the sun\n",
            shell.name, leaks.samples, leaks.seen, leaks.pixels, leaks.most, leaks.beside_no_corner);
        EXPECT_EQ(leaks.beside_no_corner, 0u);
        EXPECT_LE(leaks.seen / leaks.samples, shell.share);
        EXPECT_LE(leaks.most, shell.most);
        samples += leaks.samples;
    }
    EXPECT_GT(samples, 1e8);
}

// The other way round: a plane alone, of any size and tilt, down to where the sun grazes it. The rounding of
// a count must not make one of none, nor its own triangles an obstacle.
TEST_F(CoverWatertight, NothingHidesTheSunFromAPlaneAlone) {
    for (const double half : {10.0, 1000.0, 10000.0})
        for (const double elevation_deg : {1.0, 3.0, 45.0})
            for (const glm::dvec3& normal :
                 {glm::dvec3(0, 1, 0), glm::dvec3(0.3, 1, 0.2), glm::dvec3(0.5, 0.7, -0.8)}) {
                const glm::dvec3 n = glm::normalize(normal),
                                 u = glm::normalize(glm::cross(n, glm::dvec3(0, 0, 1))), w = glm::cross(u, n);
                Shape plane = ground(half, half, 1, 1);
                plane.transform(glm::dmat4(glm::dmat3(u, n, w)));
                Shot shot = scene_shot("plane" + std::to_string(half) + std::to_string(normal.x),
                                       {{"plane", plane}}, {256, 144});
                shot.camera = {{0, 1.7 * n, 1.7 * n + 3.0 * u + 2.0 * w - 1.2 * n, n}};
                const double e = glm::radians(elevation_deg);
                const glm::dvec3 along = 0.6 * u + 0.8 * w;  // uphill: below the world's horizon it is night
                shot.sun = {{0, std::cos(e) * (along.y < 0 ? -along : along) + std::sin(e) * n}};
                shot.sun_angular_radius_deg = 0.2665;
                CoverRun run(shot);
                for (uint32_t frame = 0; frame < 2; ++frame) {
                    run.frame(frame);
                    size_t dark = 0;
                    for (const float v : run.visibility) dark += v != 1;
                    EXPECT_EQ(dark, 0u)
                        << half << " m, sun at " << elevation_deg << " degrees, normal " << normal.x;
                }
            }
}

}  // namespace
}  // namespace penumbra::test
