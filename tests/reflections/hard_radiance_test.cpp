// SPDX-License-Identifier: MIT
// Hard cases for radiance, through every pipeline that ships: what must hold whatever the denoiser.
#include <algorithm>
#include <cmath>

#include "host/generated/noise.h"
#include "host/models/model_builder.h"
#include "tests/gpu_test.h"
#include "tests/reflections/radiance_run.h"

namespace penumbra::test {
namespace {

constexpr const char* pipelines[] = {
    "raw_reflections", "raw_indirect", "fidelityfx_reflections", "relax", "relax_indirect", "reflections",
    "indirect",        "lit"};

void add_part(Model& model, Shape shape, int material) {
    model.meshes.push_back({{to_part(std::move(shape), material)}});
    Node& node = model.nodes.emplace_back();
    node.mesh = static_cast<int>(model.meshes.size()) - 1;
}

// A floor before a wall at its feet and a block 1000 km away, with sky beside them; all shine.
Model near_far_and_nothing() {
    Model model = striped_floor({0.02f, 0.3f, 0.9f});
    model.materials.push_back(shining({}));
    for (Material& material : model.materials) material.emissive = {1, 1, 1};
    add_part(model, box({-4, 0, -0.5}, {4, 0.4, -0.4999}), 3);
    add_part(model, box({-9e5, 1e5, -1e6}, {0, 9e5, -9.9e5}), 3);
    return model;
}

// Facets of a pixel's width that lean every way by up to 20 degrees: what a normal map makes of a floor.
Model speckled_normals(float roughness) {
    Shape facets;
    constexpr int side = 60;
    constexpr double width = 0.06;
    uint32_t state = 1;
    const auto tilt = [&] { return 0.36 * width * ((state = pcg(state)) * 0x1p-32 - 0.5); };
    for (int z = 0; z < side; ++z)
        for (int x = 0; x < side; ++x) {
            const glm::dvec3 corner((x - side / 2) * width, 0, (z - side / 2) * width);
            const double a = tilt(), b = tilt();
            const auto first = static_cast<uint32_t>(facets.positions.size());
            for (const auto& [u, v] : {std::pair{0, 0}, {0, 1}, {1, 1}, {1, 0}})
                facets.positions.emplace_back(corner + glm::dvec3(u * width, u * a + v * b, v * width));
            for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) facets.indices.push_back(first + i);
        }
    facets.uv.resize(facets.positions.size());
    Model model = striped_floor({roughness});
    model.materials[0].emissive = {1, 1, 1};
    model.nodes.clear();
    model.meshes.clear();
    add_part(model, facets, 0);
    return model;
}

class HardRadiance : public GpuTest, public ::testing::WithParamInterface<const char*> {
  protected:
    // Runs some frames and hands over each image.
    void run(const Shot& shot, uint32_t frames,
             const std::function<void(uint32_t, const std::array<std::vector<float>, 3>&)>& look) {
        const auto session = open_shipped(GetParam(), shot);
        for (uint32_t frame = 0; frame < frames; ++frame) {
            session->run_frame(frame, frame == 0 || session->host().cut(frame));
            look(frame, colors(*session));
        }
    }
    // Between 0 and what may be stored, in every frame.
    void expect_sane(const Shot& shot, uint32_t frames) {
        run(shot, frames, [](uint32_t frame, const auto& image) {
            for (const auto& plane : image)
                for (size_t i = 0; i < plane.size(); ++i)
                    ASSERT_TRUE(plane[i] >= 0 && plane[i] <= 32752)
                        << plane[i] << " at pixel " << i << ", frame " << frame;
        });
    }
};
INSTANTIATE_TEST_SUITE_P(Pipelines, HardRadiance, ::testing::ValuesIn(pipelines),
                         [](const auto& param_info) { return std::string(param_info.param); });

// Of demodulated signals; of pictures: lit_test.cpp.
class WhiteFurnace : public HardRadiance {
  protected:
    // Under a sky of 1, over a model that shines as bright, every surface is 1; at least `few` pixels of a
    // frame show one. Of the published denoiser, which counts the sky beside it as black, that it is finite.
    void expect_white(Shot shot, size_t few) {
        shot.environment = linear_sky(1, 1);
        if (GetParam() == std::string("fidelityfx_reflections")) return expect_sane(shot, shot.frames);
        size_t ones = 0;
        double farthest = 0;
        run(shot, shot.frames, [&](uint32_t, const auto& image) {
            for (const float pixel : image[0]) {
                if (pixel == 0) continue;  // sky
                ++ones;
                const double off = std::abs(double(pixel) - 1);
                farthest = std::isfinite(off) ? std::max(farthest, off) : INFINITY;
            }
        });
        EXPECT_GT(ones, shot.frames * few);
        EXPECT_LT(farthest, 1e-3);
    }
};
INSTANTIATE_TEST_SUITE_P(Signals, WhiteFurnace,
                         ::testing::ValuesIn(pipelines, pipelines + std::size(pipelines) - 1),
                         [](const auto& param_info) { return std::string(param_info.param); });

Shot in_motion(Shot shot) {
    shot.camera.push_back({8, {0.8, 1.4, 2.8}, {0.2, 0, 0}, {0, 1, 0}});
    return shot;
}

// Whether all pixels are surfaces that lie within `reach` of one.
bool deep_inside(const std::vector<float>& plane, int width, size_t pixel, int reach) {
    const int height = static_cast<int>(plane.size()) / width, x = static_cast<int>(pixel) % width,
              y = static_cast<int>(pixel) / width;
    for (int v = y - reach; v <= y + reach; ++v)
        for (int u = x - reach; u <= x + reach; ++u)
            if (u >= 0 && v >= 0 && u < width && v < height && plane[static_cast<size_t>(v * width + u)] == 0)
                return false;
    return true;
}

// No denoiser may lose or make energy where all radiance is one, whatever moves. The published one does,
// beside the sky and at the image's border: its means over 9x9 and 8x8 pixels count as black what is not
// there.
TEST_P(WhiteFurnace, StaysWhite) {
    Shot shot =
        in_motion(night_shot(striped_floor({0, 0.05f, 0.1f, 0.2f, 0.4f, 0.6f, 0.8f, 1}), {96, 54}, 9));
    shot.environment = linear_sky(1, 1);
    const bool published = GetParam() == std::string("fidelityfx_reflections");
    size_t ones = 0;
    run(shot, 9, [&](uint32_t frame, const auto& image) {
        for (size_t i = 0; i < image[0].size(); ++i) {
            if (image[0][i] == 0) continue;  // sky
            if (published &&
                (i % 96 < 16 || i % 96 >= 80 || i / 96 >= 38 || !deep_inside(image[0], 96, i, 16)))
                continue;
            ++ones;
            ASSERT_NEAR(image[0][i], 1, 1e-3) << "pixel " << i << ", frame " << frame;
        }
    });
    EXPECT_GT(ones, published ? 500u : 9 * 1000u);
}

// Facets of a pixel's width that look every way and shine as bright as the sky: a neighbour's ray is of
// another lobe, or of no like plane at all.
TEST_P(WhiteFurnace, StaysWhiteOverSpeckledNormals) {
    for (const float roughness : {0.05f, 0.3f, 1.0f})
        expect_white(in_motion(night_shot(speckled_normals(roughness), {48, 27}, 3)), 400);
}

// What shines at a surface's feet, 1000 km away and the sky between them are one all alike: neither distances
// nor that a ray misses beside one that hits may be seen.
TEST_P(WhiteFurnace, StaysWhiteWhateverTheDistance) {
    expect_white(in_motion(night_shot(near_far_and_nothing(), {48, 27}, 4)), 400);
}

// Along the floor, down to half a degree, where a rough lobe's rays would go into the surface.
TEST_P(WhiteFurnace, StaysWhiteAtAGrazingView) {
    Shot shot = night_shot(striped_floor({0, 0.3f, 1}), {48, 27}, 4);
    shot.camera = {{0, {0, 0.01, 3}, {0, 0.005, 0}, {0, 1, 0}},
                   {4, {0.1, 0.01, 3}, {0, 0.005, 0}, {0, 1, 0}}};
    expect_white(shot, 200);
}

// Poles of a pixel's width: no neighbour is like them. Some rays are aimed at a body beside them.
TEST_P(WhiteFurnace, StaysWhiteOnThinGeometry) {
    Model model = striped_floor({0.2f, 1});
    for (Material& material : model.materials) material.emissive = {1, 1, 1};
    for (int i = 0; i < 20; ++i) {
        const double x = -2 + 0.2 * i;
        add_part(model, box({x, 0, 0}, {x + 0.01, 1, 0.01}), i % 2);
    }
    add_part(model, box({-0.3, 0.8, 1}, {0.3, 1.4, 1.6}), 0);
    expect_white(in_motion(night_shot(model, {48, 27}, 4)), 400);
}

// Strips of roughness 0 and 1 in turn: a mirror shows the sky that it faces, whatever is beside it.
TEST_P(HardRadiance, AMirrorBesideTheRoughestIsAMirror) {
    Shot shot = in_motion(night_shot(striped_floor({0, 1, 0, 1, 0, 1, 0, 1}), {96, 54}, 4));
    shot.camera[0].position = {0, 1.5, 1};
    shot.environment = linear_sky(0, 1);
    const bool mirrors = GetParam() == std::string("reflections") || GetParam() == std::string("relax") ||
                         GetParam() == std::string("raw_reflections");
    if (!mirrors) return expect_sane(shot, 4);
    const auto session = open_shipped(GetParam(), shot, {}, {}, {}, false);
    double farthest = 0;
    size_t seen = 0;
    for (uint32_t frame = 0; frame < 4; ++frame) {
        session->run_frame(frame, frame == 0);
        const auto image = colors(*session)[0];
        for (size_t i = 0; i < image.size(); ++i) {
            glm::dvec3 at;
            const glm::dvec3 way = mirrored(camera_at(shot, frame, 96.0 / 54), shot.size, i, at);
            if (!(way.y > 0) || std::abs(at.x) > 4 || std::abs(at.z) > 3) continue;
            const double across = std::fmod(at.x + 4, 2);
            if (across < 0.05 || across > 0.95) continue;  // rough, or an edge
            ++seen;
            farthest = std::max(farthest, std::abs(image[i] - 0.5 * (1 + way.y)));
        }
    }
    EXPECT_GT(seen, 4 * 1000u);
    EXPECT_LT(farthest, 0.01);
}

// 1e6 exceeds what fp16 holds by far: it becomes the largest radiance that is stored, never an infinity.
TEST_P(HardRadiance, HugeRadianceIsHeldAndNotSpread) {
    Model model = striped_floor({0.1f, 0.5f, 1});
    model.materials.push_back(shining({1e6f, 1e6f, 1e6f}));
    add_part(model, box({-0.2, 0.5, -1}, {0.2, 0.9, -0.6}), 3);
    Shot shot = in_motion(night_shot(model, {48, 27}, 6));
    shot.environment = linear_sky(0, 0);
    expect_sane(shot, 6);
}

// Half the frame reflects nothing at all; it must stay black beside what is bright.
TEST_P(HardRadiance, NoLightIsBlack) {
    Shot shot = in_motion(night_shot(striped_floor({0, 0.3f, 0.8f}), {48, 27}, 4));
    shot.environment = linear_sky(0, 0);
    run(shot, 4, [](uint32_t, const auto& image) {
        for (const auto& plane : image)
            for (const float v : plane) ASSERT_EQ(v, 0);
    });
}

// What a cut leaves behind is nothing: its frame is the first frame of a shot that begins there.
TEST_P(HardRadiance, ACutForgetsEverything) {
    Shot shot = in_motion(night_shot(striped_floor({0.1f, 0.3f, 0.8f}), {48, 27}, 6));
    shot.cuts = {5};
    std::array<std::vector<float>, 3> cut, fresh;
    run(shot, 6, [&](uint32_t frame, const auto& image) {
        if (frame == 5) cut = image;
    });
    const auto session = open_shipped(GetParam(), shot);
    session->run_frame(5, true);
    fresh = colors(*session);
    size_t unlike = 0;
    for (size_t c = 0; c < cut.size(); ++c) {
        ASSERT_EQ(cut[c].size(), fresh[c].size());
        for (size_t i = 0; i < cut[c].size(); ++i) unlike += cut[c][i] != fresh[c][i];
    }
    EXPECT_EQ(unlike, 0u);
}

// A floor that fills frames of sizes that are no multiple of a tile, down to a pixel: every pixel has its
// light from the first frame on, which has no past.
TEST_P(HardRadiance, EverySizeHasAFirstFrame) {
    for (const std::array<uint32_t, 2> size :
         {std::array{1u, 1u}, std::array{3u, 2u}, std::array{9u, 17u}, std::array{65u, 33u}}) {
        Model model = striped_floor({0.1f, 0.8f});
        for (Material& metal : model.materials) metal.base_color = {1, 1, 1, 1};
        Shot shot = in_motion(night_shot(model, size, 3));
        shot.camera[0].position = {0, 1.5, 0.1};
        shot.environment = linear_sky(1, 1);
        run(shot, 3, [&](uint32_t frame, const auto& image) {
            for (const auto& plane : image)
                for (size_t i = 0; i < plane.size(); ++i)
                    ASSERT_TRUE(plane[i] > 0 && plane[i] <= 32752)
                        << plane[i] << " at pixel " << i << " of " << size[0] << "x" << size[1] << ", frame "
                        << frame;
        });
    }
}

}  // namespace
}  // namespace penumbra::test
