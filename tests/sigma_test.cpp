// SPDX-License-Identifier: MIT
// SIGMA's passes on penumbrae made by hand: tiles are what their definition says at any size and workgroup,
// what is lit, dark or hard is left alone to the bit, what is soft is blurred as wide as it is and not wider.
#include <algorithm>
#include <bit>
#include <cmath>
#include <random>

#include "tests/gpu_test.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

constexpr float lit = 65504;
constexpr Extent extent{75, 43};
constexpr float depth_m = 5;

constexpr const char* denoiser = R"({ "penumbra": 1, "name": "sigma_alone",
  "inputs": { "depth": {}, "normal": {}, "motion": {}, "given_penumbra": {} },
  "outputs": ["visibility", "tiles", "past", "shadow1", "penumbra1"],
  "nodes": {
    "guides": { "type": "guides" },
    "given": { "type": "given", "in": { "numbers": "given_penumbra" }, "out": { "copied": "penumbra" } },
    "tiles": { "type": "sigma_tiles" }, "smooth": { "type": "sigma_smooth" },
    "blur": { "type": "sigma_blur", "out": { "penumbra_out": "penumbra0", "shadow_out": "shadow0" } },
    "post": { "type": "sigma_blur", "in": { "penumbra": "penumbra0", "shadow": "shadow0" },
              "out": { "penumbra_out": "penumbra1", "shadow_out": "shadow1" }, "params": { "pass": "second" } },
    "stabilise": { "type": "sigma_stabilise",
                   "in": { "penumbra": "penumbra1", "shadow": "shadow1", "history": "stable@-1", "past_prev": "past@-1" } }
  } })";

// The same of four channels.
std::string coloured_denoiser() {
    std::string text = denoiser;
    const auto put = [&](const std::string& behind, const std::string& more) {
        text.insert(text.find(behind) + behind.size(), more);
    };
    put(R"("given_penumbra": {})", R"(, "translucency": {})");
    put(R"("penumbra1")", R"(, "transmittance")");
    put(R"("sigma_alone",)",
        R"( "resources": { "shadow0": { "format": "rgba8" }, "shadow1": { "format": "rgba8" },
    "stable": { "format": "rgba8" } },)");
    const auto rename = [&](const std::string& from, const std::string& to) {
        text.replace(text.find(from), from.size(), to);
    };
    rename(R"("shadow": "shadow0")", R"("coloured_shadow": "shadow0")");
    rename(R"("shadow": "shadow1", "history")", R"("coloured_shadow": "shadow1", "coloured_history")");
    return text;
}

// A wall that faces the camera, whose penumbra radii are as given; 0 metres of depth is sky.
struct Wall {
    std::vector<float> depth = std::vector<float>(size_t(extent.width) * extent.height, depth_m);
    std::vector<float> penumbra = std::vector<float>(depth.size(), lit);
    std::vector<std::array<uint8_t, 4>> translucency;  // none: one channel alone is denoised
    float& at(uint32_t x, uint32_t y) { return penumbra[size_t(y) * extent.width + x]; }
};

struct Result {
    std::vector<float> visibility, mixed, radius, sky, blurred;
    std::vector<std::vector<float>> transmittance;  // by channel
    std::vector<uint32_t> past;
};

Result run(const Wall& wall, bool cpu, uint32_t frames = 1) {
    ViewRunOptions options;
    options.cpu = cpu;
    options.captures = {"view_depth"};
    options.formats["depth"] = Format::r32f;
    const bool coloured = !wall.translucency.empty();
    ViewRun view(shadow_pipeline(coloured ? coloured_denoiser() : denoiser), extent, options);
    if (coloured) view.set("translucency", wall.translucency);
    const Camera camera = camera_at({0, 0, 0}, 0, extent);
    std::vector<float> depth;  // reverse Z
    for (const float z : wall.depth) depth.push_back(z > 0 ? static_cast<float>(camera.near_m) / z : 0);
    view.set("depth", depth);
    view.set("normal", std::vector<std::array<float, 4>>(wall.depth.size(), {0, 0, 1, 0}));
    view.set("given_penumbra", wall.penumbra);
    view.set("motion", std::vector<std::array<uint16_t, 4>>(wall.depth.size()));
    for (uint32_t i = 0; i < frames; ++i) view.frame(frame_between(camera, camera, extent, i, i == 0));
    const auto tiles = captured_planes(view.view(), "tiles");
    return {captured_planes(view.view(), "visibility")[0],
            tiles[0],
            tiles[1],
            tiles[2],
            captured_planes(view.view(), "shadow1")[0],
            coloured ? captured_planes(view.view(), "transmittance") : std::vector<std::vector<float>>{},
            captured<uint32_t>(view.view(), "past")};
}

// Rays that glass stops, or that nothing does, as SIGMA takes them.
constexpr std::array<uint8_t, 4> clear{255, 255, 255, 255}, glass{0, 230, 89, 26}, dark{0, 0, 0, 0};

// Metres that a pixel of the wall spans.
double pixel_m() {
    return 2 * double(depth_m) /
           (std::abs(double(camera_at({0, 0, 0}, 0, extent).clip_from_view[5])) * extent.height);
}

class Sigma : public GpuTest {};

TEST_F(Sigma, TilesAreWhatTheyAreDefinedAs) {
    Wall wall;
    for (uint32_t y = 0; y < 43; ++y)
        for (uint32_t x = 0; x < 75; ++x) {
            const uint32_t tile = x / 16, row = y / 16;
            if (row == 0 && tile == 1) wall.at(x, y) = 0.1f;  // all dark, softly
            if (row == 0 && tile == 2) wall.at(x, y) = x % 16 == 15 ? float(4 * pixel_m()) : lit;  // mixed
            if (row == 0 && tile == 3) wall.at(x, y) = x % 2 ? 0 : lit;                            // hard
            if (row == 1 && tile == 2) wall.depth[y * 75 + x] = 0;                    // sky alone
            if (row == 1 && tile == 3) wall.depth[y * 75 + x] = y % 2 ? 0 : depth_m;  // sky and lit
            if (row == 2 && tile == 4) wall.at(x, y) = x == 74 && y == 42 ? float(40 * pixel_m()) : lit;
        }
    for (const bool cpu : {true, false}) {
        const Result r = run(wall, cpu);
        const std::vector<float> mixed{0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1},
            sky{0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0};
        EXPECT_EQ(r.mixed, mixed);
        EXPECT_EQ(r.sky, sky);
        EXPECT_NEAR(r.radius[2], 0.25, 0.01);
        EXPECT_EQ(r.radius[14], 1);
        EXPECT_EQ(r.radius[3], 0);
    }
}

TEST_F(Sigma, WhatIsLitDarkOrHardIsLeftAlone) {
    Wall wall;
    for (uint32_t y = 0; y < 43; ++y)
        for (uint32_t x = 0; x < 75; ++x) {
            wall.at(x, y) = (x * 7 + y * 3) % 5 < 2 ? 0 : lit;
            if (y > 30) wall.depth[y * 75 + x] = 0;
        }
    const Result r = run(wall, true, 4);
    for (size_t i = 0; i < r.visibility.size(); ++i)
        ASSERT_EQ(r.visibility[i], wall.depth[i] > 0 && wall.penumbra[i] == 0 ? 0 : 1) << i;
}

// Half of the pixels occluded, at random: where the penumbra is 8 px wide their mean comes out, where it is a
// fifth of one the rays stay as they are.
TEST_F(Sigma, BlursAsFarAsThePenumbraReaches) {
    const auto spread = [&](double radius_px) {
        Wall wall;
        std::mt19937 random(3);
        for (uint32_t y = 0; y < 43; ++y)
            for (uint32_t x = 0; x < 75; ++x)
                if (random() & 1) wall.at(x, y) = float(radius_px * pixel_m());
        const Result r = run(wall, true);
        double sum = 0, squares = 0;
        int count = 0;
        for (uint32_t y = 12; y < 31; ++y)
            for (uint32_t x = 12; x < 63; ++x) {
                const auto root = double(r.blurred[y * 75 + x]);
                sum += root * root;
                squares += std::pow(root * root - 0.5, 2);
                ++count;
            }
        EXPECT_NEAR(sum / count, 0.5, 0.04) << radius_px;
        return std::sqrt(squares / count);
    };
    EXPECT_LT(spread(8), 0.12);
    EXPECT_GT(spread(0.2), 0.3);
}

// What every ray has is what arrives, through whatever passes; a tile of glass alone is no tile of darkness.
TEST_F(Sigma, OneColourStaysWhatItIs) {
    Wall wall;
    wall.translucency.assign(wall.depth.size(), glass);
    std::ranges::fill(wall.penumbra, float(6 * pixel_m()));
    for (uint32_t y = 0; y < 16; ++y)
        for (uint32_t x = 0; x < 16; ++x) wall.translucency[y * 75 + x] = dark;
    const Result r = run(wall, true, 3);
    EXPECT_EQ(r.mixed[0], 0);
    EXPECT_EQ(std::ranges::count(r.mixed, 1.0f), 14);
    for (uint32_t y = 34; y < 43; ++y)
        for (uint32_t x = 50; x < 75; ++x)
            for (size_t c = 0; c < 3; ++c)
                ASSERT_NEAR(r.transmittance[c][y * 75 + x], glass[c + 1] / 255.0, 0.006) << x << " " << y;
    EXPECT_EQ(std::ranges::count(r.visibility, 0.0f), 75 * 43);
}

// Half of the rays through glass, at random: channel by channel the mean comes out, as that of one does.
TEST_F(Sigma, BlursColoursAsItBlursShadows) {
    Wall wall, plain;
    std::mt19937 random(3);
    for (size_t i = 0; i < wall.depth.size(); ++i) {
        const bool lit_ray = random() & 1;
        wall.translucency.push_back(lit_ray ? clear : glass);
        if (!lit_ray) wall.penumbra[i] = plain.penumbra[i] = float(8 * pixel_m());
    }
    const Result r = run(wall, true);
    for (size_t c = 0; c < 3; ++c) {
        const double t = glass[c + 1] / 255.0;
        double sum = 0, squares = 0;
        for (uint32_t y = 12; y < 31; ++y)
            for (uint32_t x = 12; x < 63; ++x) {
                const double error = double(r.transmittance[c][y * 75 + x]) - (t + (1 - t) / 2);
                sum += error;
                squares += error * error;
            }
        EXPECT_NEAR(sum / (19 * 51), 0, 0.04) << c;
        EXPECT_LT(std::sqrt(squares / (19 * 51)), 0.12 * (1 - t) + 0.01) << c;
    }
    // Where glass is as dark as what is opaque, all of its channels are the one.
    for (auto& texel : wall.translucency)
        if (texel == glass) texel = dark;
    const Result grey = run(wall, true, 4), before = run(plain, true, 4);
    EXPECT_EQ(grey.visibility, before.visibility);
    EXPECT_EQ(grey.past, before.past);
    EXPECT_EQ(grey.transmittance[2], grey.transmittance[0]);
    for (size_t i = 0; i < grey.visibility.size(); ++i)
        ASSERT_NEAR(grey.transmittance[0][i], grey.visibility[i], 0.003) << i;
}

// Frames of a surface that is seen again add up to seven in the past's low bits; a tile that is sure has them
// at once.
TEST_F(Sigma, CountsItsFrames) {
    Wall wall;
    for (uint32_t y = 0; y < 43; ++y)
        for (uint32_t x = 16; x < 48; ++x)
            if ((x ^ y) & 1) wall.at(x, y) = float(6 * pixel_m());
    const size_t soft = 20 * 75 + 32, sure = 20 * 75 + 74;
    const Result first = run(wall, true, 1), second = run(wall, true, 2), ninth = run(wall, true, 9);
    EXPECT_EQ(first.past[soft] & 7, 1u);
    EXPECT_EQ(second.past[soft] & 7, 2u);
    EXPECT_GE(ninth.past[soft] & 7, 3u);
    EXPECT_EQ(first.past[sure] & 7, 7u);
    const auto z = std::bit_cast<float>(first.past[soft] & ~7u);
    EXPECT_NEAR(z, depth_m, 1e-5);
}

}  // namespace
}  // namespace penumbra::test
