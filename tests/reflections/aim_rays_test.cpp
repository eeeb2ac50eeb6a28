// SPDX-License-Identifier: MIT
// Rays that are aimed at bodies that shine: which these are, and what such rays are worth.
#include <bit>
#include <cmath>

#include "host/materials/emitters.h"
#include "host/models/model_builder.h"
#include "tests/gpu_test.h"
#include "tests/reflections/radiance_run.h"

namespace penumbra::test {
namespace {

float number(uint32_t word) {
    return std::bit_cast<float>(word);
}

Shape cube(const glm::dvec3& middle, double half) {
    return box(middle - glm::dvec3(half), middle + glm::dvec3(half));
}

// Two that hang together nowhere are two, though they are one part; where they stand goes with the node and
// the camera.
TEST(Emitters, AreTheBodiesOfAPart) {
    ModelBuilder builder({shining({10, 10, 10}), shining({0, 0, 0})});
    Shape pair = cube({1, 2, 3}, 0.1);
    pair.append(cube({-1, 2, 3}, 0.2));
    builder.node("pair", builder.mesh(pair, 0), {5, 0, 0});
    builder.solid("dark", cube({0, 0, 0}, 1), 1);
    const Scene scene(builder.take(), Shot());
    const Emitters emitters(scene);
    ASSERT_EQ(emitters.size(), 2u);
    const std::vector<Texel> texels = emitters.texels(0, {0, 1, 0});
    ASSERT_EQ(texels.size(), 4u);
    double luminance = 0, area = 0, radius = 0, x = 0;
    for (size_t i = 0; i < 2; ++i) {
        x += double(number(texels[2 * i][0]));
        EXPECT_NEAR(number(texels[2 * i][1]), 1, 1e-5);
        EXPECT_NEAR(number(texels[2 * i][2]), 3, 1e-5);
        radius += double(number(texels[2 * i][3]));
        luminance += double(number(texels[2 * i + 1][0]));
        area += double(number(texels[2 * i + 1][1]));
    }
    EXPECT_NEAR(x, 10, 1e-5);
    EXPECT_NEAR(radius, 0.3 * std::sqrt(3.0), 1e-5);
    EXPECT_NEAR(luminance, 20, 1e-4);
    EXPECT_NEAR(area, 6 * (0.04 + 0.16) / 4, 1e-5) << "a quarter of a convex body's surface is seen";
}

size_t bodies(const Shape& shape, const Material& material, int times = 1) {
    Texture white{1, 1, {255, 255, 255, 255}};
    ModelBuilder builder({material}, {white});
    for (int i = 0; i < times; ++i) builder.node("body", builder.mesh(shape, 0), {i, 0, 0});
    const Scene scene(builder.take(), Shot());
    return Emitters(scene).size();
}

TEST(Emitters, LeaveOutWhatNobodyCanAimAt) {
    const Material lamp = shining({10, 10, 10});
    Material textured = lamp, glass = lamp;
    textured.emissive_texture = 0;
    glass.alpha_blend = true;
    glass.base_color[3] = 0.5f;
    EXPECT_EQ(bodies(cube({}, 0.1), lamp), 1u);
    EXPECT_EQ(bodies(cube({}, 0.1), textured), 0u) << "its light may be anywhere on it";
    EXPECT_EQ(bodies(cube({}, 0.1), glass), 0u) << "no ray meets it";
    EXPECT_EQ(bodies(rod({0, 0, 0}, {4, 0, 0}, 0.02, 8), lamp), 0u) << "its sphere is empty";
    EXPECT_EQ(bodies(cube({}, 0.1), lamp, 40), 32u);
}

// A vertex that no triangle uses may be no number, which equals every place or none.
TEST(Emitters, AreOfCornersAlone) {
    Shape shape;
    shape.positions = {glm::vec3(NAN)};
    shape.append(cube({1, 2, 3}, 0.1));
    shape.append(cube({-1, 2, 3}, 0.2));
    EXPECT_EQ(bodies(shape, shining({10, 10, 10})), 2u);
}

class AimRays : public GpuTest {};

struct Plate {
    double from, to;  // in x, m
};
const Plate beside = {2, 2.2}, under_half = {0.3, 0.5}, under_all = {0.1, 0.5};

// A bulb of 3 cm above glossy floors, and a dim wall: a lobe finds it once in hundreds of rays. The plate is
// beneath it.
Shot bulb_over_floors(std::array<uint32_t, 2> size, const Plate& plate,
                      const std::vector<float>& roughness = {0.12f, 0.25f, 0.45f, 0.7f},
                      double half_m = 0.03) {
    Model floor = striped_floor(roughness);
    const auto lamp = static_cast<int>(floor.materials.size());
    floor.materials.push_back(shining({400, 300, 200}));
    floor.materials.push_back(shining({0.4f, 0.4f, 0.4f}));
    floor.materials.push_back(shining({0, 0, 0}));
    for (const auto& [shape, material] :
         {std::pair{cube({0.3, 0.9, -1.5}, half_m), lamp},
          {box({-5, 0, -3.2}, {5, 3, -3.1}), lamp + 1},
          {box({plate.from, 0.84, -1.7}, {plate.to, 0.85, -1.3}), lamp + 2}}) {
        floor.meshes.emplace_back().parts.push_back(to_part(shape, material));
        Node& node = floor.nodes.emplace_back();
        node.name = "body";
        node.mesh = static_cast<int>(floor.meshes.size()) - 1;
    }
    return night_shot(floor, size, 96);
}

struct Judged {
    double bias;     // of the mean over pixels and frames, relative
    double squared;  // error of a frame, summed over pixels and channels
};

Judged judge(const Shot& shot, const PlanarImage& truth, const std::string& pipeline,
             const std::vector<std::string>& settings, uint32_t frames = 48) {
    const auto session = open_shipped(pipeline, shot, settings, {}, {}, false);
    double sum = 0, of_truth = 0, squared = 0;
    for (uint32_t frame = 0; frame < frames; ++frame) {
        session->run_frame(frame, true);
        const auto image = colors(*session);
        for (size_t c = 0; c < 3; ++c)
            for (size_t i = 0; i < image[c].size(); ++i) {
                if (!(truth.planes[3].values[i] > 0)) continue;
                const double t = double(truth.planes[c].values[i]);
                sum += double(image[c][i]) / frames;
                of_truth += t / frames;
                squared += (double(image[c][i]) - t) * (double(image[c][i]) - t) / frames;
            }
    }
    return {sum / of_truth - 1, squared};
}

// In first frames, which hold nothing but the gather: as bright as the truth, and a fraction of the error.
TEST_F(AimRays, FindWhatLobesFindByChance) {
    const Shot shot = bulb_over_floors({64, 36}, beside);
    for (const auto& [signal, pipeline] : {std::pair{"specular", "reflections"}, {"diffuse", "indirect"}}) {
        const PlanarImage truth = truth_of(shot, signal, 4096);
        const Judged aimed = judge(shot, truth, pipeline, {}),
                     by_lobes = judge(shot, truth, pipeline, {"nodes.aim=null"});
        std::printf("%s: bias %.4f, %.4f by lobes; squared error %.4f, %.4f\n", signal, aimed.bias,
                    by_lobes.bias, aimed.squared, by_lobes.squared);
        EXPECT_LT(std::abs(aimed.bias), 0.02) << signal;
        EXPECT_LT(aimed.squared, 0.65 * by_lobes.squared) << signal;
    }
}

// With a ray in one pixel of four all of a window's may have gone into cones, and tell nothing of what is
// beside the body; it is not as bright.
TEST_F(AimRays, AreFewAndAllAimed) {
    const Shot shot = bulb_over_floors({64, 36}, beside);
    for (const auto& [signal, pipeline] : {std::pair{"specular", "reflections"}, {"diffuse", "indirect"}}) {
        const PlanarImage truth = truth_of(shot, signal, 4096);
        const std::string few = "nodes.rays.params.rays=quarter";
        const Judged aimed = judge(shot, truth, pipeline, {few}),
                     by_lobes = judge(shot, truth, pipeline, {few, "nodes.aim=null"});
        std::printf("%s: bias %.4f, %.4f by lobes; squared error %.4f, %.4f\n", signal, aimed.bias,
                    by_lobes.bias, aimed.squared, by_lobes.squared);
        EXPECT_LT(aimed.squared, 0.65 * by_lobes.squared) << signal;
    }
}

// Where what a neighbour found is hidden, its weight does not go to the others: one of them may have met the
// body.
TEST_F(AimRays, AskWhatHides) {
    const Shot shot = bulb_over_floors({64, 36}, under_half);
    for (const auto& [signal, pipeline] : {std::pair{"specular", "reflections"}, {"diffuse", "indirect"}}) {
        const PlanarImage truth = truth_of(shot, signal, 4096);
        const Judged asking = judge(shot, truth, pipeline, {"nodes.reconnect.type=reconnect_asking"}),
                     trusting = judge(shot, truth, pipeline, {});
        std::printf("%s: bias %.4f, %.4f trusting; squared error %.4f, %.4f\n", signal, asking.bias,
                    trusting.bias, asking.squared, trusting.squared);
        EXPECT_LT(asking.squared, 1.05 * trusting.squared) << signal;
    }
}

// Narrow lobes that meet a body's rim: what is around it is not taken to be as bright as the body, because a
// neighbour's ray has met it.
TEST_F(AimRays, FindTheRimOfABody) {
    const Shot shot = bulb_over_floors({96, 54}, beside, {0.03f, 0.04f, 0.05f, 0.06f});
    const PlanarImage truth = truth_of(shot, "specular", 4096);
    const Judged aimed = judge(shot, truth, "reflections", {}),
                 by_lobes = judge(shot, truth, "reflections", {"nodes.aim=null"});
    std::printf("bias %.4f, %.4f by lobes; squared error %.1f, %.1f\n", aimed.bias, by_lobes.bias,
                aimed.squared, by_lobes.squared);
    EXPECT_LT(aimed.squared, by_lobes.squared);
}

// Rough lobes send rays into the surface: drawn anew, such a ray has another density than the one that is
// weighed against the cone's.
TEST_F(AimRays, FindALargeBodyFromRoughSurfaces) {
    const Shot shot = bulb_over_floors({96, 54}, beside, {0.2f, 0.7f}, 0.1);
    const PlanarImage truth = truth_of(shot, "specular", 4096);
    const Judged aimed = judge(shot, truth, "reflections", {}),
                 by_lobes = judge(shot, truth, "reflections", {"nodes.aim=null"});
    std::printf("bias %.4f, %.4f by lobes; squared error %.1f, %.1f\n", aimed.bias, by_lobes.bias,
                aimed.squared, by_lobes.squared);
    EXPECT_LT(std::abs(aimed.bias), 0.02);
    EXPECT_LT(aimed.squared, 0.6 * by_lobes.squared);
}

// A body narrower than the digits that are kept of directions, before black: neighbours find it where it is.
// Else its light would count as theirs and as the pixel's own.
TEST_F(AimRays, BringASmallBodysLightOnce) {
    Model model = striped_floor({0.5f});
    model.materials.push_back(shining({400, 300, 200}));
    model.meshes.emplace_back().parts.push_back(to_part(cube({0, 3, 0}, 0.003), 1));
    model.nodes.emplace_back().mesh = static_cast<int>(model.meshes.size()) - 1;
    Shot shot = night_shot(model, {64, 36}, 16);
    shot.environment = linear_sky(0, 0);
    const auto light_of = [&](std::vector<std::string> settings) {
        settings.emplace_back("nodes.aim.params.background=0");
        const auto session = open_shipped("indirect", shot, settings, {}, {}, false);
        double sum = 0;
        for (uint32_t frame = 0; frame < shot.frames; ++frame) {
            session->run_frame(frame, true);
            const auto image = colors(*session);
            for (const float x : image[0]) sum += double(x);
        }
        return sum;
    };
    const double found = light_of({}) / light_of({"nodes.rays.params.hit_normals=false",
                                                  "nodes.reconnect.params.hit_normals=false"});
    std::printf("%.4f of what longer directions find\n", found);
    EXPECT_NEAR(found, 1, 0.05);
}

// Rays go everywhere into a body's cone, and those that meet black things before it take no light from what
// is beside it.
TEST_F(AimRays, FindWhatIsHalfHiddenOrNotThere) {
    for (const Plate& plate : {under_half, under_all}) {
        const Shot shot = bulb_over_floors({64, 36}, plate);
        const Judged aimed = judge(shot, truth_of(shot, "diffuse", 16384), "indirect", {}, 96);
        std::printf("from %.1f: bias %.4f\n", plate.from, aimed.bias);
        EXPECT_LT(std::abs(aimed.bias), 0.01);
    }
}

}  // namespace
}  // namespace penumbra::test
