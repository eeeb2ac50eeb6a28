// SPDX-License-Identifier: MIT
// The whole picture of lit.json against closed forms: surfaces that reflect all of a white furnace, the split
// sum in double precision, the sun on diffuse and glossy surfaces, mirrors under a linear sky.
#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <numbers>

#include "app/outputs.h"
#include "app/radiance_truth.h"
#include "host/models/model_builder.h"
#include "nodes/tables/environment_brdf.h"
#include "tests/gpu_test.h"
#include "tests/reflections/radiance_run.h"

namespace penumbra::test {
namespace {

constexpr double sun_color[] = {3, 2.8, 2.5};

class LitPicture : public GpuTest {};

struct Surface {
    std::array<float, 3> base_color{1, 1, 1};
    float metallic = 0, roughness = 1;
    std::array<float, 3> emissive{0, 0, 0};
};

// Strips of floor from x = -4 to 4, one per surface.
Model floor_of(const std::vector<Surface>& surfaces) {
    Model model = striped_floor(std::vector<float>(surfaces.size(), 1));
    for (size_t i = 0; i < surfaces.size(); ++i) {
        Material& material = model.materials[i];
        const auto& c = surfaces[i].base_color;
        material.base_color = {c[0], c[1], c[2], 1};
        material.metallic = surfaces[i].metallic;
        material.roughness = surfaces[i].roughness;
        material.emissive = surfaces[i].emissive;
    }
    return model;
}

struct Pixel {
    size_t index = 0, strip = 0;
    glm::dvec3 to_viewer{0}, rgb{0};
};

// The last of some frames, in linear radiance before anti-aliasing; the floor's pixels that lie well within a
// strip.
class Lit {
  public:
    Lit(const Shot& shot, size_t strips, uint32_t frames = 2) {
        const auto session = open_shipped("lit", shot, {"outputs=[\"lit\"]"});
        for (uint32_t frame = 0; frame < frames; ++frame) session->run_frame(frame, frame == 0);
        const auto image = colors(*session);
        const Camera camera = camera_at(shot, 0, double(shot.size[0]) / shot.size[1]);
        const auto& m = camera.clip_from_view;
        for (size_t i = 0; i < image[0].size(); ++i) {
            const double x = 2 * (static_cast<double>(i % shot.size[0]) + 0.5) / shot.size[0] - 1,
                         y = 2 * (static_cast<double>(i / shot.size[0]) + 0.5) / shot.size[1] - 1;
            const glm::dvec3 ray = glm::normalize(glm::make_mat3(camera.world_from_view.data()) *
                                                  glm::dvec3(x / m[0], y / m[5], -1));
            const glm::dvec3 rgb(image[0][i], image[1][i], image[2][i]);
            const glm::dvec3 eye = glm::make_vec3(camera.position.data()), at = eye - ray * (eye.y / ray.y);
            if (ray.y >= 0 || std::abs(at.x) > 4 || std::abs(at.z) > 2.99) {
                if (ray.y >= 0 || std::abs(at.x) > 4.05 || std::abs(at.z) > 3.05)
                    sky.push_back({i, 0, -ray, rgb});
                continue;
            }
            const double along = (at.x + 4) / 8 * double(strips), within = along - std::floor(along);
            if (within > 0.05 && within < 0.95) floor.push_back({i, static_cast<size_t>(along), -ray, rgb});
        }
    }
    std::vector<Pixel> floor, sky;
};

Shot lit_shot(const std::vector<Surface>& surfaces, EnvironmentSky sky, std::array<uint32_t, 2> size) {
    Shot shot = night_shot(floor_of(surfaces), size);
    shot.environment = sky;
    return shot;
}

// Whatever its roughness, and whether it is a metal, a white surface in white surroundings cannot be seen.
// Without what bounces again between facets a metal of roughness 1 is .45 here.
TEST_F(LitPicture, AWhiteSurfaceInAWhiteFurnaceCannotBeSeen) {
    std::vector<Surface> surfaces;
    for (const float roughness : {0.0f, 0.3f, 0.7f, 1.0f})
        for (const float metallic : {0.0f, 0.5f, 1.0f}) surfaces.push_back({{1, 1, 1}, metallic, roughness});
    const Shot shot = lit_shot(surfaces, linear_sky(1, 1), {96, 54});
    const Lit lit(shot, surfaces.size());
    EXPECT_GT(lit.floor.size(), 1000u);
    EXPECT_GT(lit.sky.size(), 500u);
    for (const auto* pixels : {&lit.floor, &lit.sky})
        for (const Pixel& p : *pixels)
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(p.rgb[c], 1, 2e-3) << "strip " << p.strip << ", pixel " << p.index;
}

double mirrored_share(double f0, const EnvironmentBrdf& b) {
    return (f0 * (b.white - b.grazing) + b.grazing) * (1 + f0 * (1 / b.white - 1));
}

// Any colour, by the integral in double precision instead of the table.
TEST_F(LitPicture, AFurnaceShowsWhatAMaterialReflects) {
    std::vector<Surface> surfaces;
    for (const float roughness : {0.1f, 0.5f, 0.9f})
        for (const float metallic : {0.0f, 1.0f})
            surfaces.push_back({{0.8f, 0.4f, 0.1f}, metallic, roughness, {0.5f, 0, 0.25f}});
    const Shot shot = lit_shot(surfaces, linear_sky(2, 2), {48, 27});
    const Lit lit(shot, surfaces.size());
    EXPECT_GT(lit.floor.size(), 300u);
    for (const Pixel& p : lit.floor) {
        const Surface& s = surfaces[p.strip];
        const double roughness = std::round(255 * double(s.roughness)) / 255;
        const EnvironmentBrdf b = environment_brdf(p.to_viewer.y, roughness);
        for (int c = 0; c < 3; ++c) {
            // The G-buffer has eight bits of it.
            const double base = std::round(255 * double(s.base_color[size_t(c)])) / 255;
            const double share = s.metallic > 0
                                     ? mirrored_share(base, b)
                                     : mirrored_share(0.04, b) + base * (1 - mirrored_share(0.04, b));
            ASSERT_NEAR(p.rgb[c], 2 * share + double(s.emissive[size_t(c)]), 1.2e-2)
                << "strip " << p.strip << ", " << c;
        }
    }
}

// Linear in the height of the direction, the mean under a cosine is a + b 2 / 3, and a mirror's is exact.
TEST_F(LitPicture, AMirrorUnderALinearSky) {
    const std::vector<Surface> surfaces{{{1, 1, 1}, 1, 0}};
    const Shot shot = lit_shot(surfaces, linear_sky(0.25, 4.25), {64, 36});
    const Lit lit(shot, 1);
    EXPECT_GT(lit.floor.size(), 500u);
    const auto radiance = [](double height) { return 0.25 + 4 * (0.5 + 0.5 * height); };
    for (const Pixel& p : lit.floor)  // whose past is kept in ten bits
        ASSERT_NEAR(p.rgb[0], radiance(p.to_viewer.y), 2.5e-3 * radiance(p.to_viewer.y)) << p.index;
    for (const Pixel& p : lit.sky)
        ASSERT_NEAR(p.rgb[0], radiance(-p.to_viewer.y), 1.5e-3 * radiance(-p.to_viewer.y)) << p.index;
}

// A point, of which the diffuse lobe alone reflects, and what a plate hides of it. Nothing is indirect here:
// the floor sees the sky and the plate, which are black.
TEST_F(LitPicture, ALampOnTheFloorIsTheFormula) {
    const std::vector<Surface> surfaces{
        {{0.8f, 0.4f, 0.2f}, 0, 0.6f}, {{0.8f, 0.4f, 0.2f}, 0, 0.2f}, {{0.8f, 0.4f, 0.2f}, 1, 0.6f}};
    Shot shot = lit_shot(surfaces, linear_sky(0, 0), {64, 36});
    ShotLight lamp;
    lamp.strength = 700;
    lamp.color = {1, 0.5, 2};
    lamp.keys = {{0, {0.4, 1.6, 0.3}}};
    shot.lights["lamp"] = lamp;
    const Lit lit(shot, surfaces.size());
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto truth_session = open_lit_truth(gpu(), shot, diagnostics, warnings);
    ASSERT_TRUE(truth_session) << diagnostics.text();
    const Picture truth = lit_truth(*truth_session, 0, 4).lit;
    EXPECT_GT(lit.floor.size(), 400u);
    for (const Pixel& p : lit.floor) {
        const Surface& s = surfaces[p.strip];
        const glm::dvec3 eye(0, 1.5, 3), point = eye - p.to_viewer * (1.5 / p.to_viewer.y),
                                         to_lamp = lamp.keys[0].position - point;
        const double d = glm::length(to_lamp), lux = lamp.strength * to_lamp.y / (d * d * d);
        const EnvironmentBrdf b =
            environment_brdf(p.to_viewer.y, std::round(255 * double(s.roughness)) / 255);
        for (int c = 0; c < 3; ++c) {
            const double base = std::round(255 * double(s.base_color[size_t(c)])) / 255,
                         diffuse = s.metallic > 0 ? 0 : base * (1 - mirrored_share(0.04, b)),
                         expected = diffuse * 0.01 / std::numbers::pi * lux * lamp.color[c];
            ASSERT_NEAR(p.rgb[c], expected, 1e-2 * expected) << "strip " << p.strip << ", pixel " << p.index;
            ASSERT_NEAR(truth.rgb[p.index][c], expected, 1e-2 * expected) << "truth, pixel " << p.index;
        }
    }
}

// Alone under a black sky. Cook and Torrance 1982 with GGX and Schlick's Fresnel term, in double precision.
TEST_F(LitPicture, TheSunOnDiffuseAndGlossySurfaces) {
    const float half = 128.0f / 255;  // .5 is a tie, which a device may round either way
    const std::vector<Surface> surfaces{{{0.8f, 0.4f, 0.2f}, 0, 1},
                                        {{0.8f, 0.4f, 0.2f}, 0, half},
                                        {{0.8f, 0.4f, 0.2f}, 1, half},
                                        {{0.8f, 0.4f, 0.2f}, 1, 0.8f}};
    Shot shot = lit_shot(surfaces, linear_sky(0, 0), {64, 36});
    const glm::dvec3 l = glm::normalize(glm::dvec3(0.2, 0.8, -0.7));
    shot.sun = {{0, l}};
    const Lit lit(shot, surfaces.size());
    EXPECT_GT(lit.floor.size(), 500u);
    for (const Pixel& p : lit.floor) {
        const Surface& s = surfaces[p.strip];
        const double roughness = std::round(255 * double(s.roughness)) / 255, a2 = std::pow(roughness, 4);
        const glm::dvec3 h = glm::normalize(l + p.to_viewer);
        const EnvironmentBrdf b = environment_brdf(p.to_viewer.y, roughness);
        const auto lambda = [&](double z) { return (std::sqrt(1 + a2 * (1 / (z * z) - 1)) - 1) / 2; };
        const double d = a2 / (std::numbers::pi * std::pow(h.y * h.y * (a2 - 1) + 1, 2)),
                     g = 1 / (1 + lambda(l.y) + lambda(p.to_viewer.y));
        for (size_t c = 0; c < 3; ++c) {
            const double base = std::round(255 * double(s.base_color[c])) / 255,
                         f0 = s.metallic > 0 ? base : 0.04,
                         f = (f0 + (1 - f0) * std::pow(1 - glm::dot(h, l), 5)) * (1 + f0 * (1 / b.white - 1)),
                         glossy = d * g * f / (4 * p.to_viewer.y),  // times the cosine of the light
                diffuse = s.metallic > 0 ? 0 : base * (1 - mirrored_share(0.04, b)) * l.y / std::numbers::pi;
            const double expected = sun_color[c] * std::numbers::pi * (glossy + diffuse);
            ASSERT_NEAR(p.rgb[static_cast<int>(c)], expected, 1e-2 * expected + 2e-3)
                << "strip " << p.strip << ", " << c;
        }
    }
}

// A sun of radius a that a mirror shows is as bright as its disc: an irradiance of pi E over pi sin^2 a.
TEST_F(LitPicture, AMirrorShowsTheSunAsBrightAsItIs) {
    const std::vector<Surface> surfaces{{{1, 1, 1}, 1, 0}};
    Shot shot = lit_shot(surfaces, linear_sky(0, 0), {65, 37});
    shot.sun = {{0, glm::normalize(glm::dvec3(0, 1.5, -3))}};  // what the middle pixel mirrors
    shot.sun_angular_radius_deg = 2;
    const Lit lit(shot, 1);
    double brightest = 0;
    for (const Pixel& p : lit.floor) brightest = std::max(brightest, p.rgb.x);
    const double disc = sun_color[0] / std::pow(std::sin(2 * std::numbers::pi / 180), 2);
    EXPECT_NEAR(brightest, disc, 0.02 * disc);
}

// Half in the shadow of a wall: there is nothing of the sun, glossy or not.
TEST_F(LitPicture, NothingOfTheSunIsInTheShadow) {
    Model model = floor_of({{{1, 1, 1}, 1, 0.4f}});
    model.materials.push_back({});
    model.materials.back().base_color = {0, 0, 0, 1};
    model.meshes.push_back({{to_part(box({-9, 5, -9}, {0, 5.1, 9}), 1)}});
    Node node;
    node.mesh = static_cast<int>(model.meshes.size()) - 1;
    model.nodes.push_back(node);
    Shot shot = night_shot(model, {64, 36});
    shot.environment = linear_sky(0, 0);
    shot.sun = {{0, glm::normalize(glm::dvec3(0, 1, -1e-3))}};
    const Lit lit(shot, 1);
    size_t dark = 0, bright = 0;
    for (const Pixel& p : lit.floor) {
        const size_t x = p.index % 64;
        if (x < 28) {
            ASSERT_EQ(p.rgb.x, 0) << p.index;
            ++dark;
        } else if (x > 36) {
            ASSERT_GT(p.rgb.x, 0) << p.index;
            ++bright;
        }
    }
    EXPECT_GT(dark, 200u);
    EXPECT_GT(bright, 200u);
}

// Converged radiance through the same node: what is reflected of white, and the picture that lit.json makes
// of one ray is it but for noise.
TEST_F(LitPicture, TheTruthIsWhatTheMaterialReflects) {
    const std::vector<Surface> surfaces{{{0.8f, 0.4f, 0.1f}, 0, 0.5f}, {{0.8f, 0.4f, 0.1f}, 1, 0.3f}};
    const auto truth_of_picture = [](const Shot& shot, uint32_t rays) {
        Diagnostics diagnostics;
        std::vector<std::string> warnings;
        const auto session = open_lit_truth(gpu(), shot, diagnostics, warnings);
        if (!session) throw std::runtime_error(diagnostics.text());
        return lit_truth(*session, 0, rays);
    };
    const Shot furnace = lit_shot(surfaces, linear_sky(2, 2), {48, 27});
    const LitTruth white = truth_of_picture(furnace, 16);
    size_t seen = 0;
    for (size_t i = 0; i < white.lit.rgb.size(); ++i) {
        const glm::vec3 share = white.specular_share.rgb[i] + white.diffuse_share.rgb[i];
        if (share.x == 0) continue;
        ++seen;
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(white.lit.rgb[i][c], 2 * share[c], 4e-3);
    }
    EXPECT_GT(seen, 300u);
    Shot shot = lit_shot(surfaces, linear_sky(0.2, 1.5), {48, 27});
    shot.sun = {{0, glm::normalize(glm::dvec3(0.2, 0.8, -0.7))}};
    const LitTruth truth = truth_of_picture(shot, 512);
    const Lit lit(shot, surfaces.size(), 9);
    double is = 0, should = 0;
    for (const Pixel& p : lit.floor) {
        is += p.rgb.y;
        should += static_cast<double>(truth.lit.rgb[p.index].y);
    }
    EXPECT_NEAR(is / should, 1, 5e-3);
}

// Both lobes have what they have alone. Diffuse light keeps its past whatever a surface's roughness.
TEST_F(LitPicture, HasTheLightOfEitherLobe) {
    Shot shot = lit_shot({{{1, 1, 1}, 0, 0.1f}, {{1, 1, 1}, 0, 0.5f}, {{1, 1, 1}, 0, 1}}, linear_sky(0.1, 3),
                         {64, 36});
    shot.frames = 5;
    shot.camera.push_back({5, {0.4, 1.4, 2.8}, {0.1, 0, 0}, {0, 1, 0}});
    for (const auto& [pipeline, signal] : {std::pair{"indirect", "diffuse"}, {"reflections", "specular"}}) {
        const std::string output = std::string("outputs=[\"") + signal + "\"]";
        const auto whole = open_shipped("lit", shot, {output}, {}, {}, false);
        const auto alone = open_shipped(pipeline, shot, {}, {}, {}, false);
        for (uint32_t frame = 0; frame < shot.frames; ++frame) {
            whole->run_frame(frame, frame == 0);
            alone->run_frame(frame, frame == 0);
            EXPECT_TRUE(colors(*whole) == colors(*alone)) << signal << ", frame " << frame;
        }
        EXPECT_GT(*std::ranges::max_element(colors(*alone)[0]), 0.5f) << signal;
    }
}

}  // namespace
}  // namespace penumbra::test
