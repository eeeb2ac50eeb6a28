// SPDX-License-Identifier: MIT
// denoise_sigma.json, for a host that feeds SIGMA: the same rays as hit words with their blockers' distances
// and as penumbra radii are the same picture, to the bit; and what each value of such a host stands for.
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "shaders/common/blocks.h"
#include "tests/gpu_test.h"
#include "tests/shipped.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

constexpr Extent extent{96, 64};
constexpr size_t pixels = size_t{extent.width} * extent.height, tiles = pixels / 32;
constexpr float lit = 65504, sun_radius = 0.02f;

// Of one ray per pixel: how far away what it hits is; nothing where it reaches the sun, 0 where the surface
// itself hides that. Octaves in 64 steps, as blockers are kept: neither form rounds what the other keeps.
using Rays = std::vector<std::optional<float>>;

Rays rays_of(uint32_t frame) {
    std::mt19937 random(frame + 1);
    Rays rays(pixels);
    for (size_t i = 0; i < pixels; ++i) {
        const size_t x = i % extent.width;
        if (random() % extent.width >= x) continue;
        rays[i] = random() % 50 == 0 ? 0.0f : std::exp2(float(random() % 256) / 64 - 1);
    }
    return rays;
}

size_t tile_of(size_t pixel) {
    return pixel / extent.width / 4 * (extent.width / 8) + pixel % extent.width / 8;
}
uint32_t bit_of(size_t pixel) {
    return 1u << (pixel / extent.width % 4 * 8 + pixel % 8);
}

struct Words {
    std::vector<uint32_t> hits = std::vector<uint32_t>(tiles), blockers = std::vector<uint32_t>(3 * tiles);
    bool operator==(const Words&) const = default;
};

Words words_of(const Rays& rays, float times = 1) {
    Words words;
    for (size_t i = 0; i < pixels; ++i) {
        if (!rays[i]) continue;
        const size_t tile = tile_of(i);
        words.hits[tile] |= bit_of(i);
        if (*rays[i] == 0) continue;
        const auto steps =
            static_cast<uint32_t>(std::floor(64 * (std::log2(double(*rays[i] * times)) + 32) + 0.5));
        ++words.blockers[3 * tile];
        words.blockers[3 * tile + 1] += steps;
        words.blockers[3 * tile + 2] += steps * steps;
    }
    return words;
}

// Half of what the sun's radius spans at the blocker's distance.
std::vector<float> radii_of(const Rays& rays) {
    std::vector<float> radii;
    for (const auto& ray : rays) radii.push_back(ray ? 0.5f * *ray * std::tan(sun_radius) : lit);
    return radii;
}

// A wall that faces the camera and the sun.
class Wall {
  public:
    explicit Wall(const std::string& name, const std::vector<std::string>& settings = {})
        : run_(shipped_pipeline(name, settings), extent, options(name)) {
        run_.set("depth", std::vector<float>(pixels, 0.01f));  // near / view depth
        run_.set("normal", std::vector<std::array<float, 4>>(pixels, {0, 0, 1, 0}));
        run_.set("motion", std::vector<std::array<uint16_t, 4>>(pixels));
        for (const char* sun : {"sun", "sun_prev"})
            run_.set(sun, std::vector<blocks::Sun>{{{{0, 0.6f, 0.8f}}, sun_radius}});
    }
    ViewRun& run() { return run_; }
    std::vector<float> frame(uint32_t index) {
        const Camera camera = camera_at({0, 0, 0}, 0, extent);
        run_.frame(frame_between(camera, camera, extent, index, index == 0));
        return captured_planes(run_.view(), "visibility").at(0);
    }

  private:
    static ViewRunOptions options(const std::string& name) {
        ViewRunOptions options;
        options.formats = {{"depth", Format::r32f}, {"normal", Format::rgba32f}, {"motion", Format::rgba16f}};
        if (name == "denoise_sigma") options.formats["penumbra"] = Format::r32f;
        return options;
    }
    ViewRun run_;
};

class FromSigma : public GpuTest {};

TEST_F(FromSigma, TheSameRaysInBothFormsAreTheSamePicture) {
    const std::vector<std::string> distances{"inputs.blockers={}", "nodes.prepare.params.blocks=true",
                                             "nodes.gather.params.rays=distances"};
    Wall words("denoise", distances), others("denoise", distances), radii("denoise_sigma");
    for (uint32_t index = 0; index < 3; ++index) {
        const Rays rays = rays_of(index);
        for (const auto& [wall, times] : {std::pair{&words, 1.0f}, std::pair{&others, 0.125f}}) {
            wall->run().set("hits", words_of(rays).hits);
            wall->run().set("blockers", words_of(rays, times).blockers);
        }
        radii.run().set("penumbra", radii_of(rays));
        const std::vector<float> image = radii.frame(index);
        EXPECT_TRUE(image == words.frame(index)) << index;
        EXPECT_FALSE(image == others.frame(index)) << "distances are of no account";
        const auto soft = std::ranges::count_if(image, [](float v) { return v > 0 && v < 1; });
        EXPECT_GT(soft, 3000) << index;
    }
}

// The node by itself.
struct Converter {
    static constexpr const char* text = R"({ "penumbra": 1, "name": "converter",
  "inputs": { "penumbra": {}, "translucency": { "optional": true }, "sun": {}, "light": { "optional": true } },
  "outputs": ["hits", "blockers"], "nodes": { "from_sigma": { "type": "from_sigma", "params": { "light_size": 0.5 } } } })";

    static Words of(const std::vector<float>& radii, const std::vector<std::array<uint8_t, 4>>& colours,
                    const blocks::Light& light) {
        ViewRunOptions options;
        options.formats = {{"penumbra", Format::r32f}, {"translucency", Format::rgba8}};
        ViewRun run(shadow_pipeline(text), extent, options);
        run.set("penumbra", radii);
        run.set("translucency", colours);
        run.set("sun", std::vector<blocks::Sun>{{{{0, 1, 0}}, sun_radius}});
        run.set("light", std::vector<blocks::Light>{light});
        const Camera camera = camera_at({0, 0, 0}, 0, extent);
        run.frame(frame_between(camera, camera, extent, 0, true));
        return {captured<uint32_t>(run.view(), "hits"), captured<uint32_t>(run.view(), "blockers")};
    }
};

// Of a lamp of size s the radius is s / 2 times d / (D - d), and blockers keep this quotient. What lets light
// through is no hit; what is no number is.
TEST_F(FromSigma, OfALampItIsTheWayToTheBlockerOverTheWayOn) {
    const Rays quotients = rays_of(7);
    std::vector<float> radii;
    for (const auto& q : quotients) radii.push_back(q ? 0.5f * 0.5f * *q : lit);
    std::vector<std::array<uint8_t, 4>> colours(pixels);
    for (size_t i = 0; i < pixels; ++i)
        if (!quotients[i]) colours[i] = {255, 255, 255, 255};
    EXPECT_TRUE(Converter::of(radii, colours, {}) == words_of(quotients));

    Rays expected = quotients;
    for (size_t i = 0; i < pixels; i += 3) {
        colours[i] = {0, 200, 20, 20};  // of red glass, which the ray has hit
        expected[i].reset();
    }
    for (size_t i = 1; i < pixels; i += 300) {
        radii[i] = std::numeric_limits<float>::quiet_NaN();
        colours[i] = {0, 0, 0, 0};
        expected[i] = 0.0f;
    }
    EXPECT_TRUE(Converter::of(radii, colours, {}) == words_of(expected));
    EXPECT_FALSE(words_of(expected) == words_of(quotients));
}

}  // namespace
}  // namespace penumbra::test
