// SPDX-License-Identifier: MIT
// The truth of radiance against closed forms: a white furnace, a mirror, a Lambert plane under a constant and
// under a linear sky, and mirrors that see triangles, against double precision.
#include "app/radiance_truth.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/gtc/type_ptr.hpp>
#include <numbers>
#include <random>

#include "host/images/image_decode.h"
#include "host/models/model_builder.h"
#include "nodes/tables/environment_brdf.h"
#include "tests/gpu_test.h"
#include "tests/reflections/radiance_run.h"
#include "tests/test_folder.h"

namespace penumbra::test {
namespace {

class RadianceTruth : public GpuTest {};

TEST_F(RadianceTruth, AWhiteFurnaceIsOneForEveryRoughness) {
    Shot shot = night_shot(striped_floor({0, 0.05f, 0.1f, 0.2f, 0.4f, 0.6f, 0.8f, 1}), {64, 36});
    shot.environment = linear_sky(1, 1);
    for (const char* signal : {"specular", "diffuse"}) {
        const PlanarImage truth = truth_of(shot, signal, 64);
        size_t receivers = 0;
        for (size_t i = 0; i < truth.planes[0].values.size(); ++i) {
            if (truth.planes[3].values[i] == 0) continue;
            ++receivers;
            for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(truth.planes[c].values[i], 1, 1e-5) << signal << i;
            EXPECT_EQ(truth.planes[5].values[i], 0) << "every ray brings 1";
        }
        EXPECT_GT(receivers, 500u);
    }
}

TEST_F(RadianceTruth, AMirrorIsExact) {
    Shot shot = night_shot(striped_floor({0}), {64, 36});
    shot.environment = linear_sky(0.25, 4.25);
    const PlanarImage truth = truth_of(shot, "specular", 16);
    const Camera camera = camera_at(shot, 0, 64.0 / 36);
    size_t receivers = 0;
    for (size_t i = 0; i < truth.planes[0].values.size(); ++i) {
        if (truth.planes[3].values[i] == 0) continue;
        glm::dvec3 origin;
        const double expected = 0.25 + 4 * (0.5 + 0.5 * mirrored(camera, shot.size, i, origin).y);
        // Vulkan lets an arc cosine, which finds the sky's row, be off by 4096 ulp.
        EXPECT_NEAR(truth.planes[0].values[i], expected, 2.5e-4 * expected) << i;
        ++receivers;
    }
    EXPECT_GT(receivers, 500u);
}

// The mean of a + b y under the cosine about y is a + b 2 / 3.
TEST_F(RadianceTruth, ALambertPlaneUnderALinearSky) {
    for (const double up : {2.0, 6.0}) {
        Shot shot = night_shot(striped_floor({1}), {48, 27});
        shot.environment = linear_sky(2, up);
        const PlanarImage truth = truth_of(shot, "diffuse", 1024);
        const double expected = 2 + (up - 2) * (0.5 + 0.5 * 2 / 3);
        double sum = 0, receivers = 0, noise = 0;
        for (size_t i = 0; i < truth.planes[0].values.size(); ++i) {
            if (truth.planes[3].values[i] == 0) continue;
            // `noise` is of three channels.
            EXPECT_NEAR(truth.planes[0].values[i], expected,
                        5.5 * std::sqrt(truth.planes[6].values[i] / 3) + 1e-3);
            sum += truth.planes[0].values[i];
            noise += truth.planes[6].values[i] / 3;
            ++receivers;
        }
        EXPECT_NEAR(sum / receivers, expected, 5 * std::sqrt(noise) / receivers + 1e-3);
    }
}

// Response of the GGX lobe of a floor, without its Fresnel term.
double ggx_response(const glm::dvec3& v, const glm::dvec3& l, double roughness) {
    const double a2 = std::pow(roughness, 4);
    const glm::dvec3 h = glm::normalize(v + l);
    const double d = a2 / (std::numbers::pi * std::pow(h.y * h.y * (a2 - 1) + 1, 2));
    const auto lambda = [&](double c) { return 0.5 * std::sqrt(1 + a2 * (1 - c * c) / (c * c)) - 0.5; };
    return d / (4 * v.y * (1 + lambda(v.y) + lambda(l.y)));
}

// The mean height of what a lobe of the floor shows, by quadrature over the hemisphere.
double mean_height(const glm::dvec3& v, double roughness) {
    constexpr int n = 200;
    double sum = 0, all = 0;
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k) {
            const double y = (i + 0.5) / n, angle = 2 * std::numbers::pi * (k + 0.5) / n,
                         across = std::sqrt(1 - y * y);
            const double f =
                ggx_response(v, {across * std::cos(angle), y, across * std::sin(angle)}, roughness);
            sum += f * y;
            all += f;
        }
    return sum / all;
}

// Rough lobes under a linear sky: rays that a lobe would send into the surface are drawn anew without
// favouring any direction.
TEST_F(RadianceTruth, ARoughFloorUnderALinearSky) {
    for (const float roughness : {0.5f, 0.75f, 1.0f}) {
        Shot shot = night_shot(striped_floor({roughness}), {24, 14});
        shot.environment = linear_sky(0, 2);
        shot.camera = {{0, {0, 2.5, 1}, {0, 0, 0}, {0, 1, 0}}};
        const Camera camera = camera_at(shot, 0, 24.0 / 14);
        const PlanarImage truth = truth_of(shot, "specular", 4096);
        double sum = 0, expected = 0, receivers = 0;
        for (size_t i = 0; i < truth.planes[0].values.size(); ++i) {
            if (truth.planes[3].values[i] == 0) continue;
            glm::dvec3 origin;
            const glm::dvec3 l = mirrored(camera, shot.size, i, origin);
            sum += double(truth.planes[0].values[i]);
            expected += 1 + mean_height({-l.x, l.y, -l.z}, roughness);
            ++receivers;
        }
        EXPECT_GT(receivers, 200);
        EXPECT_NEAR(sum, expected, 1e-3 * expected) << roughness;
    }
}

// One texel of a dark sky, which is bilinear around it.
class BrightSpot {
  public:
    static constexpr uint32_t width = 128, height = 64, x = 40, y = 12;
    static constexpr float radiance = 5000;

    static std::filesystem::path write() {
        PlanarImage image{width, height, {}};
        for (const char* name : {"R", "G", "B"})
            image.planes.push_back(
                {name, PlaneType::real, std::vector<float>(size_t{width} * height, 0.0f), {}});
        for (Plane& plane : image.planes) plane.values[y * width + x] = radiance;
        static const TestFolder folder;
        const auto file = folder / "spot.exr";
        write_exr(file, image);
        return file;
    }

    // The integral of f(direction) times radiance over the four texels' worth of sky that it lights.
    template <class F>
    static double integral(const F& f) {
        constexpr int n = 64;
        const double step = std::numbers::pi / height;
        double sum = 0;
        for (int i = 0; i < n * n; ++i) {
            const double u = 2 * (i % n + 0.5) / n - 1, v = 2 * (int(i / n) + 0.5) / n - 1;
            const double longitude = (x + 0.5 + u) * 2 * std::numbers::pi / width,
                         polar = (y + 0.5 + v) * step;
            const glm::dvec3 direction(std::sin(polar) * std::cos(longitude), std::cos(polar),
                                       std::sin(polar) * std::sin(longitude));
            sum += f(direction) * (1 - std::abs(u)) * (1 - std::abs(v)) * std::sin(polar);
        }
        return double(radiance) * sum * (2.0 / n) * (2.0 / n) * step * 2 * std::numbers::pi / width;
    }
};

// A spot of a thousandth of the sky that has all of its light. Sixteen rays of the lobe find it here and
// there; with as many from the sky's lots every pixel knows it.
TEST_F(RadianceTruth, ABrightSpotOfADarkSkyIsFoundByFewRays) {
    const std::vector<float> roughness{0.4f, 0.7f, 1};
    Shot shot = night_shot(striped_floor(roughness), {48, 27});
    shot.environment = EnvironmentFile{BrightSpot::write(), 1};
    const Camera camera = camera_at(shot, 0, 48.0 / 27);
    for (const char* signal : {"diffuse", "specular"}) {
        const PlanarImage truth = truth_of(shot, signal, 16);
        double squares = 0, ratios = 0, receivers = 0;
        for (size_t i = 0; i < truth.planes[0].values.size(); ++i) {
            if (truth.planes[3].values[i] == 0) continue;
            glm::dvec3 origin;
            const glm::dvec3 direction = mirrored(camera, shot.size, i, origin);
            const glm::dvec3 v(-direction.x, direction.y, -direction.z);
            const double along = (origin.x + 4) / 8 * 3, within = along - std::floor(along);
            if (std::abs(origin.x) > 3.9 || std::abs(origin.z) > 2.9 || within < 0.05 || within > 0.95)
                continue;
            double expected = 0;
            if (signal == std::string("diffuse")) {
                expected = BrightSpot::integral([](const glm::dvec3& l) { return l.y / std::numbers::pi; });
            } else {
                const double r = std::round(255 * double(roughness[size_t(along)])) / 255;
                expected = BrightSpot::integral([&](const glm::dvec3& l) { return ggx_response(v, l, r); }) /
                           environment_brdf(v.y, r).white;
            }
            const double ratio = double(truth.planes[0].values[i]) / expected;
            squares += (ratio - 1) * (ratio - 1);
            ratios += ratio;
            ++receivers;
        }
        EXPECT_GT(receivers, 300) << signal;
        EXPECT_LT(std::sqrt(squares / receivers), 0.35) << signal;
        EXPECT_NEAR(ratios / receivers, 1, 0.03) << signal;
    }
    std::filesystem::remove(std::get<EnvironmentFile>(shot.environment).path);
}

// Where the sky is even a lobe's own rays are left alone.
TEST_F(RadianceTruth, AnEvenSkyHasNoLots) {
    Shot shot = night_shot(striped_floor({1}), {16, 9});
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    for (const bool spot : {false, true}) {
        if (spot) shot.environment = EnvironmentFile{BrightSpot::write(), 1};
        const auto session = open_radiance_truth(gpu(), shot, "diffuse", diagnostics, warnings);
        EXPECT_EQ(std::ranges::count(session->plan().slots, "environment_lots", &HostSlot::name), spot);
    }
    std::filesystem::remove(std::get<EnvironmentFile>(shot.environment).path);
}

struct Soup {
    std::vector<std::array<glm::dvec3, 3>> triangles;
    std::vector<Material> materials;
};

// Triangles above the floor, each with a radiance of its own.
Soup random_triangles(size_t count) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    Soup soup;
    for (size_t i = 0; i < count; ++i) {
        const glm::dvec3 middle(6 * unit(random) - 3, 0.4 + 2 * unit(random), -4 * unit(random) - 0.5);
        auto& corners = soup.triangles.emplace_back();
        for (glm::dvec3& corner : corners)
            corner = glm::vec3(middle + 0.6 * (glm::dvec3(unit(random), unit(random), unit(random)) - 0.5));
        soup.materials.push_back(
            shining({0.01f * static_cast<float>(i + 1), static_cast<float>(unit(random)), 0.5f}));
    }
    return soup;
}

// The nearest triangle, or -1; `edge`: how near its outline (or another's) the ray passes, in weights.
int nearest(const Soup& soup, const glm::dvec3& origin, const glm::dvec3& direction, double& edge) {
    int found = -1;
    double nearest_t = 1e30;
    edge = 1;
    for (size_t i = 0; i < soup.triangles.size(); ++i) {
        const auto& [a, b, c] = soup.triangles[i];
        const glm::dvec3 n = glm::cross(b - a, c - a);
        const double t = glm::dot(a - origin, n) / glm::dot(direction, n);
        if (!(t > 0)) continue;
        const glm::dvec3 p = origin + t * direction;
        const double u = glm::dot(glm::cross(b - p, c - p), n) / glm::dot(n, n),
                     v = glm::dot(glm::cross(c - p, a - p), n) / glm::dot(n, n), w = 1 - u - v;
        edge = std::min({edge, std::abs(u), std::abs(v), std::abs(w)});
        if (std::min({u, v, w}) < 0 || t >= nearest_t) continue;
        nearest_t = t;
        found = static_cast<int>(i);
    }
    return found;
}

class RadianceHits : public RadianceTruth, public ::testing::WithParamInterface<const char*> {};

TEST_P(RadianceHits, AMirrorShowsTheNearestTriangle) {
    const std::string backend = GetParam();
    if (backend == "ray_query" && !gpu().caps().ray_query) GTEST_SKIP() << "the device has no ray queries";
    const Soup soup = random_triangles(150);
    std::vector<Material> materials = soup.materials;
    const int floor = static_cast<int>(materials.size());
    materials.push_back({});
    materials.back().roughness = 0;
    ModelBuilder builder(materials);
    builder.solid("floor", ground(4, 3, 1, 1), floor);
    for (size_t i = 0; i < soup.triangles.size(); ++i) {
        Shape shape;
        for (const glm::dvec3& corner : soup.triangles[i]) shape.positions.emplace_back(corner);
        shape.indices = {0, 1, 2};
        builder.solid("triangle", shape, static_cast<int>(i));
    }
    Shot shot = night_shot(builder.take(), {96, 54});
    shot.environment = linear_sky(5, 5);
    const auto session =
        open_shipped("raw_reflections", shot,
                     {"nodes.rays.params.backend=" + backend, "nodes.rays.params.ambient=[0,0,0]"});
    session->run_frame(0, true);
    const auto image = colors(*session);
    const Camera camera = camera_at(shot, 0, 96.0 / 54);
    size_t looked_at = 0, hits = 0;
    for (size_t i = 0; i < image[0].size(); ++i) {
        glm::dvec3 origin;
        const glm::dvec3 direction = mirrored(camera, shot.size, i, origin);
        if (!(direction.y > 0) || std::abs(origin.x) > 3.9 || std::abs(origin.z) > 2.9) continue;
        const glm::dvec3 eye = glm::make_vec3(camera.position.data());
        double edge_seen, edge;
        const int in_front = nearest(soup, eye, origin - eye, edge_seen);
        const int expected = nearest(soup, origin, direction, edge);
        if (in_front >= 0 || std::min(edge_seen, edge) < 1e-3) continue;
        ++looked_at;
        hits += expected >= 0;
        const float radiance =
            expected < 0 ? 5.0f : soup.materials[static_cast<size_t>(expected)].emissive[0];
        EXPECT_NEAR(image[0][i], radiance, 1e-3 * radiance) << "pixel " << i % 96 << ", " << i / 96;
    }
    EXPECT_GT(looked_at, 800u);
    EXPECT_GT(hits, 150u);
}
INSTANTIATE_TEST_SUITE_P(Backends, RadianceHits, ::testing::Values("bvh", "ray_query"),
                         [](const auto& param_info) { return std::string(param_info.param); });

// What shines and what is lit: base colour times (sun + constant), the sun where nothing stands in the way.
TEST_F(RadianceTruth, AHitIsLitByTheSunThatItSees) {
    Material mirror, white, lid;
    mirror.roughness = 0;
    white.base_color = {0.5f, 0.25f, 1, 1};
    const auto radiance_of_wall = [&](bool shaded) {
        ModelBuilder builder({mirror, white, lid});
        builder.solid("floor", ground(4, 3, 1, 1), 0);
        builder.solid("wall", box({-4, 0, -3.2}, {4, 6, -3.1}), 1);
        if (shaded) builder.solid("lid", box({-9, 9, -9}, {9, 9.1, 9}), 2);
        Shot shot = night_shot(builder.take(), {32, 18});
        shot.sun = {{0, {0, 0.8, 0.6}}};
        const auto session = open_shipped("raw_reflections", shot);
        session->run_frame(0, true);
        const auto image = colors(*session);
        const size_t pixel = 9 * 32 + 16;  // the floor before the wall
        return std::array{image[0][pixel], image[1][pixel], image[2][pixel]};
    };
    const auto lit = radiance_of_wall(false), dark = radiance_of_wall(true);
    const double sun[] = {3, 2.8, 2.5}, ambient[] = {0.16, 0.19, 0.24}, base[] = {0.5, 0.25, 1};
    for (size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(dark[c], base[c] * ambient[c], 1e-3 * base[c]);
        EXPECT_NEAR(lit[c], base[c] * (ambient[c] + 0.6 * sun[c]), 5e-3 * base[c])
            << "the wall faces it at 0.6";
    }
}

// A sheet has two sides, and each is lit as it faces the sun, however its corners are ordered. Its plane
// holds no round numbers, so that the points of hits lie off it on either side: none of them is in its own
// shadow.
TEST_F(RadianceTruth, EitherSideOfASheetIsLitAsItFacesTheSun) {
    Material mirror, white;
    mirror.roughness = 0;
    white.base_color = {1, 1, 1, 1};
    for (const auto& [turned, backend] : {std::pair{false, "bvh"}, {true, "bvh"}, {true, "ray_query"}}) {
        SCOPED_TRACE(testing::Message() << backend << turned);
        if (backend == std::string("ray_query") && !gpu().caps().ray_query) continue;
        ModelBuilder builder({mirror, white});
        builder.solid("floor", ground(4, 3, 1, 1), 0);
        Shape sheet;
        const glm::dvec3 tilt(0.0731, 1, -0.317);
        for (const double x : {-7.13, 7.19}) {
            sheet.positions.emplace_back(glm::dvec3(x, -0.37, -3.217));
            sheet.positions.emplace_back(glm::dvec3(x, -0.37, -3.217) + 9.0 * tilt);
        }
        sheet.indices =
            turned ? std::vector<uint32_t>{0, 1, 2, 2, 1, 3} : std::vector<uint32_t>{0, 2, 1, 2, 3, 1};
        builder.solid("sheet", sheet, 1);
        Shot shot = night_shot(builder.take(), {64, 36});
        const glm::dvec3 to_sun = glm::normalize(glm::dvec3(0.1, 0.7, 0.6));
        shot.sun = {{0, to_sun}};
        shot.sun_angular_radius_deg = 0;
        const auto session = open_shipped(
            "raw_reflections", shot,
            {std::string("nodes.rays.params.backend=") + backend, "nodes.rays.params.ambient=[0,0,0]"});
        session->run_frame(0, true);
        const auto image = colors(*session);
        const glm::dvec3 n = glm::normalize(glm::cross(glm::dvec3(1, 0, 0), tilt));
        const double expected = 3 * glm::dot(n, to_sun);
        ASSERT_GT(expected, 0);
        const Camera camera = camera_at(shot, 0, 64.0 / 36);
        size_t looked_at = 0;
        for (size_t i = 0; i < image[0].size(); ++i) {
            glm::dvec3 origin;
            const glm::dvec3 direction = mirrored(camera, shot.size, i, origin);
            if (!(direction.y > 0) || std::abs(origin.x) > 2.9 || std::abs(origin.z) > 2.9) continue;
            const double way = glm::dot(n, glm::dvec3(0, -0.37, -3.217) - origin) / glm::dot(n, direction);
            const glm::dvec3 hit = origin + way * direction;
            if (!(way > 0) || hit.y > 8 || std::abs(hit.x) > 6) continue;
            ++looked_at;
            EXPECT_NEAR(image[0][i], expected, 5e-3 * expected) << i;
        }
        EXPECT_GT(looked_at, 300u);
    }
}

}  // namespace
}  // namespace penumbra::test
