// SPDX-License-Identifier: MIT
// What shadow maps prove lit, against the rays themselves: the same noise is traced with and without the
// proof, and no pixel may differ. That one property covers acne, shadows that come off their casters, leaks
// at cascades' borders and wires thinner than a texel; the published search on the same maps shows that the
// scenes would tell.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "host/cascades/cascade_maps.h"
#include "tests/cascade_run.h"
#include "tests/test_scene.h"

namespace penumbra::test {
namespace {

// Boxes that stand on the floor and on each other, seen from close.
Shot contact_shot() {
    Shot shot = shadow_shot("contact",
                            {{"floor", ground(8, 8, 4, 4)},
                             {"below", box({-0.5, 0, -0.5}, {0.3, 0.5, 0.3})},
                             {"above", box({-0.2, 0.5, -0.2}, {0.1, 0.53, 0.1})},
                             {"aside", box({0.6, 0, 0.2}, {0.9, 0.02, 0.6})}},
                            {160, 90});
    shot.camera = {{0, {-1.5, 0.9, 1.2}, {-0.1, 0.2, 0}, {0, 1, 0}}};
    return shot;
}

class Cascades : public GpuTest {};

TEST_F(Cascades, SpareRaysAndChangeNoPixel) {
    for (const double radius_deg : {0.0, 0.27, 8.0}) {
        SCOPED_TRACE(radius_deg);
        Shot shot = plaza_shot({160, 90}, 2);
        shot.sun_angular_radius_deg = radius_deg;
        const Frames rays = frames_of("raw", shot, {}, 2),
                     hybrid = frames_of(cascades_raw, shot, maps_of(256), 2);
        EXPECT_EQ(differing(rays, hybrid), 0u);
        EXPECT_LT(hybrid.rays, radius_deg < 1 ? rays.rays / 2 : rays.rays * 9 / 10);
    }
}

TEST_F(Cascades, KeepTheShadowsOfWiresThinnerThanATexel) {
    const Shot shot = wires();
    const Frames rays = frames_of("raw", shot, {}, 2), hybrid = frames_of(cascades_raw, shot, maps_of(64), 2);
    EXPECT_EQ(differing(rays, hybrid), 0u);
    EXPECT_LT(hybrid.rays, rays.rays * 9 / 10);
    // Ordinary maps of that size do not see them.
    EXPECT_GT(differing(rays, frames_of(taps_raw, shot, maps_of(64), 2)), 10u);
}

TEST_F(Cascades, KeepShadowsAttachedToTheirCasters) {
    const Shot shot = contact_shot();
    const Frames rays = frames_of("raw", shot, {}, 2);
    EXPECT_EQ(differing(rays, frames_of(cascades_raw, shot, maps_of(512), 2)), 0u);
    // Texels as wide as the lower boxes are high: a bias of a quarter of one, as maps' depths are usually
    // compared with, takes their sides for the floor.
    const std::string biased = "nodes.cascades.params.contact_texels=0.25";
    const Frames exact = frames_of(cascades_raw, shot, maps_of(32), 2);
    EXPECT_EQ(differing(rays, exact), 0u);
    EXPECT_LT(exact.rays, rays.rays * 9 / 10);
    EXPECT_GT(differing(rays, frames_of(cascades_raw, shot, maps_of(32, {biased}), 2)), 0u);
}

TEST_F(Cascades, DoNotDependOnWhereTheWorldIs) {
    Shot shot = wires();
    const Frames here = frames_of(cascades_raw, shot, maps_of(128), 2);
    shot.origin = {1e6, 0, -3e6};
    const Frames there = frames_of(cascades_raw, shot, maps_of(128), 2);
    EXPECT_LE(differing(here, there), 8u);  // rounding of the camera's own position
    EXPECT_NEAR(double(here.rays), double(there.rays), 0.01 * double(here.rays));
}

TEST_F(Cascades, AliasingAndPoisonDoNotShow) {
    const Shot shot = plaza_shot({75, 43}, 8);
    for (const char* name :
         {cascades_raw, taps_raw, "hybrid_cascades", "hybrid_fidelityfx", "cascades_only"}) {
        RunOptions options{.jitter = true, .cascade_size = 64, .alias = false};
        const Frames expected = frames_of(name, shot, options, 8, 5);
        options.alias = true;
        for (const uint32_t poison : {0u, 1u}) {
            options.poison = poison;
            EXPECT_EQ(differing(expected, frames_of(name, shot, options, 8, 5)), 0u)
                << name << " poison " << poison;
        }
    }
}

TEST_F(Cascades, TheOrderOfTheTileListDoesNotShow) {
    const Shot shot = plaza_shot({160, 90}, 2);
    const std::vector<std::string> permuted = {R"(nodes.back={"type": "permute_list"})",
                                               R"(nodes.trace.in={"tile_list": "permuted_list"})"};
    for (const char* name : {cascades_raw, taps_raw})
        EXPECT_EQ(differing(frames_of(name, shot, maps_of(128), 2),
                            frames_of(name, shot, maps_of(128, permuted), 2)),
                  0u)
            << name;
}

// Filtered maps alone are no reference, but they are shadows: most pixels agree with the rays.
TEST_F(Cascades, AloneGiveShadowsToo) {
    const Shot shot = contact_shot();
    const Frames rays = frames_of("raw", shot, {}, 2),
                 maps = frames_of("cascades_only", shot, maps_of(512), 2);
    const size_t pixels = size_t{shot.size[0]} * shot.size[1] * 2;
    size_t opposite = 0, dark = 0;
    for (size_t f = 0; f < rays.visibility.size(); ++f)
        for (size_t i = 0; i < rays.visibility[f].size(); ++i) {
            opposite += std::abs(rays.visibility[f][i] - maps.visibility[f][i]) > 200.0f / 255;
            dark += maps.visibility[f][i] == 0;
        }
    EXPECT_LT(opposite, pixels / 50);
    EXPECT_GT(dark, pixels / 50);
    EXPECT_LT(dark, pixels / 2);
}

// A wall seen face on, the sun behind the camera, one cascade about it that holds nothing: everything is lit
// for certain.
class WallTest {
  public:
    static constexpr Extent extent{32, 16};
    static constexpr uint32_t size = 64;

    WallTest() : run_(shadow_pipeline(pipeline_text), extent, options()) {
        const size_t pixels = size_t{extent.width} * extent.height;
        const Camera camera = camera_at({0, 0, 0}, 0, extent);
        run_.set("depth",
                 std::vector<float>(pixels, static_cast<float>(camera.near_m / 10)));  // ten metres away
        run_.set("normal", std::vector<std::array<uint16_t, 4>>(pixels, to_half4({0, 0, 1, 0})));
        run_.set("sun", std::vector<blocks::Sun>{{{{0, 0, 1}}, 0.005f}});
        block_.count = 1;
        block_.flags = blocks::BOUNDS_HOLD_ALL;
        blocks::Cascade& c = block_.c[0];
        c.texel_m = 0.5f;
        c.depth_m = 20;
        const float per_m = 1 / (float(size) * c.texel_m);
        c.map = {{{per_m, 0, 0, 0.5f}, {0, per_m, 0, 0.5f}, {0, 0, -1 / c.depth_m, 0}}};
        bounds_.assign(size_t{size} * size, {1e30f, 1e30f, 1e30f, 1e30f});
    }
    uint32_t traced(const blocks::Cascades& block, const std::vector<std::array<float, 4>>& bounds) {
        run_.set("cascades", std::vector<blocks::Cascades>{block});
        run_.set("cascade_bounds", bounds);
        const Camera camera = camera_at({0, 0, 0}, 0, extent);
        run_.frame(frame_between(camera, camera, extent, 0, true));
        return counters_of(run_.view(), "cascades").at("unknown");
    }
    const blocks::Cascades& block() const { return block_; }
    const std::vector<std::array<float, 4>>& bounds() const { return bounds_; }

  private:
    static constexpr const char* pipeline_text = R"({
      "penumbra": 1, "name": "wall", "doc": "Cascades alone.",
      "inputs": { "depth": {}, "normal": {}, "sun": {}, "cascades": {}, "cascade_bounds": { "extent": "any" } },
      "outputs": ["trace_args"],
      "nodes": {
        "guides":   { "type": "guides" },
        "classify": { "type": "classify", "out": { "tile_list": "candidates", "trace_args": "candidate_args" } },
        "cascades": { "type": "cascades" }
      } })";
    static ViewRunOptions options() {
        ViewRunOptions options;
        options.formats = {
            {"depth", Format::r32f}, {"normal", Format::rgba16f}, {"cascade_bounds", Format::rgba32f}};
        options.arrays = {{"cascade_bounds", {size, size}}};
        return options;
    }
    ViewRun run_;
    blocks::Cascades block_{};
    std::vector<std::array<float, 4>> bounds_;
};

TEST_F(Cascades, WhatTheyCannotProveIsTraced) {
    constexpr uint32_t pixels = WallTest::extent.width * WallTest::extent.height;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    WallTest wall;
    EXPECT_EQ(wall.traced(wall.block(), wall.bounds()), 0u);

    blocks::Cascades none = wall.block();
    none.count = 0;
    EXPECT_EQ(wall.traced(none, wall.bounds()), pixels) << "no cascade";
    blocks::Cascades ordinary = wall.block();
    ordinary.flags = 0;
    EXPECT_EQ(wall.traced(ordinary, wall.bounds()), pixels) << "bounds that may lack casters";
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
            for (const float bad : {nan, std::numeric_limits<float>::infinity()}) {
                blocks::Cascades broken = wall.block();
                broken.c[0].map.columns[row][column] = bad;
                EXPECT_EQ(wall.traced(broken, wall.bounds()), pixels) << row << " " << column << " " << bad;
            }
    for (float blocks::Cascade::*length : {&blocks::Cascade::texel_m, &blocks::Cascade::depth_m})
        for (const float bad : {nan, 0.0f, -1.0f}) {
            blocks::Cascades broken = wall.block();
            broken.c[0].*length = bad;
            EXPECT_EQ(wall.traced(broken, wall.bounds()), pixels) << bad;
        }
    blocks::Cascades aside = wall.block();
    aside.c[0].map.columns[0][3] = 7;
    EXPECT_EQ(wall.traced(aside, wall.bounds()), pixels) << "outside of all cascades";
    aside = wall.block();
    aside.c[0].map.columns[0][3] = 1;  // the border runs through the image's middle
    EXPECT_GE(wall.traced(aside, wall.bounds()), pixels / 2) << "across the border";

    std::vector<std::array<float, 4>> broken = wall.bounds();
    for (auto& texel : broken) texel = {nan, nan, nan, nan};
    EXPECT_EQ(wall.traced(wall.block(), broken), pixels) << "bounds that are no numbers";
    std::vector<std::array<float, 4>> blocked = wall.bounds();
    for (auto& texel : blocked) texel = {3, 3, 0, 0};
    EXPECT_EQ(wall.traced(wall.block(), blocked), pixels) << "a caster everywhere";
    for (auto& texel : blocked) texel = {10, 10, 0, 0};
    EXPECT_EQ(wall.traced(wall.block(), blocked), 0u) << "the wall itself";
    blocks::Cascades later = wall.block();  // a broken cascade is skipped, not the end
    later.count = 2;
    later.c[1] = later.c[0];
    later.c[0].texel_m = nan;
    EXPECT_GT(wall.traced(later, wall.bounds()), 0u) << "the second cascade has no layer";
}

// --- the bounds against clipping in double precision
// ---------------------------------------------------------------

using Polygon = std::vector<glm::dvec3>;

Polygon clip(const Polygon& in, int axis, double limit, double sign) {
    Polygon out;
    for (size_t i = 0; i < in.size(); ++i) {
        const glm::dvec3 &a = in[i], &b = in[(i + 1) % in.size()];
        const double da = sign * (limit - a[axis]), db = sign * (limit - b[axis]);
        if (da >= 0) out.push_back(a);
        if ((da < 0) != (db < 0)) out.push_back(glm::mix(a, b, da / (da - db)));
    }
    return out;
}

TEST_F(Cascades, BoundsHoldEveryTriangleInEveryTexelItTouches) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    Shape soup;
    for (int i = 0; i < 160; ++i) {  // large ones, small ones, slivers
        const glm::dvec3 at{3 * unit(random), 1 + unit(random), 3 * unit(random)};  // braces: in this order
        const double size = std::pow(10.0, -2 + 2.3 * std::abs(unit(random)));
        const double thin = i % 3 == 0 ? 1e-3 : 1;
        const glm::dvec3 a{unit(random), unit(random), unit(random)},
            b{unit(random), unit(random), unit(random)};
        const auto first = static_cast<uint32_t>(soup.positions.size());
        soup.positions.insert(soup.positions.end(), {glm::vec3(at), glm::vec3(at + size * a),
                                                     glm::vec3(at + size * (0.5 * a + thin * b))});
        soup.indices.insert(soup.indices.end(), {first, first + 1, first + 2});
    }
    const Shot shot = shadow_shot("soup", {{"soup", soup}}, {160, 90});
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    auto scene = load_scene(shot, diagnostics, warnings);
    ASSERT_TRUE(scene) << diagnostics.text();
    StandaloneHost host(gpu(), shot, std::move(*scene), {{160, 90}, 1, false, 64});
    const CascadeFit fit = host.cascade_fit(0);
    ASSERT_GE(fit.count, 1u);
    CascadeMaps maps(gpu(), host.scene(), 64, host.cascade_layers(), true);
    uint32_t drawn = 0, again = 0, moved = 0;
    gpu().run([&](VkCommandBuffer cmd) { drawn = maps.record(cmd, fit); });
    gpu().run([&](VkCommandBuffer cmd) { again = maps.record(cmd, fit); });
    EXPECT_EQ(drawn, host.cascade_layers());
    EXPECT_EQ(again, 0u) << "nothing has moved";
    CascadeFit aside = fit;  // one cascade moves by a texel, and back: only that one is drawn
    aside.areas[0].corner.x += aside.areas[0].texel_m;
    gpu().run([&](VkCommandBuffer cmd) { moved = maps.record(cmd, aside); });
    EXPECT_EQ(moved, 1u);
    gpu().run([&](VkCommandBuffer cmd) { maps.record(cmd, fit); });

    const std::vector<Triangle> triangles = host.scene().triangles(0);
    size_t tight = 0, touched = 0;
    for (uint32_t layer = 0; layer < fit.count; ++layer) {
        const std::vector<std::byte> bytes =
            read_image(gpu(), maps.bounds().get(), CascadeMaps::bounds_format, maps.bounds().extent,
                       VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, layer);
        std::vector<glm::vec4> bounds(bytes.size() / sizeof(glm::vec4));
        std::memcpy(bounds.data(), bytes.data(), bytes.size());
        const glm::dmat4x3 map = texels_from_metres(fit, layer, host.scene().bvh_origin());
        std::vector<double> least(bounds.size(), 1e30);
        for (const Triangle& triangle : triangles) {
            Polygon whole;
            for (const auto& v : triangle.v) whole.push_back(map * glm::dvec4(v[0], v[1], v[2], 1));
            for (int y = 0; y < 64; ++y)
                for (int x = 0; x < 64; ++x) {
                    const Polygon part =
                        clip(clip(clip(clip(whole, 0, x, -1), 0, x + 1, 1), 1, y, -1), 1, y + 1, 1);
                    const glm::vec4& b = bounds[size_t(y) * 64 + size_t(x)];
                    for (const glm::dvec3& p : part) {
                        const double texel = fit.areas[layer].texel_m;
                        const double plane = b.y + texel * (b.z * (p.x - x - 0.5) + b.w * (p.y - y - 0.5));
                        // What fp32 rounds away of either is in the proof's slack.
                        const double slope = texel * (std::abs(b.z) + std::abs(b.w));
                        const double rounding = 1e-6 + 0x1p-22 * (std::abs(p.z) + slope);
                        ASSERT_LE(b.x, p.z + rounding) << layer << ": " << x << " " << y;
                        ASSERT_LE(plane, p.z + rounding) << layer << ": " << x << " " << y;
                        least[size_t(y) * 64 + size_t(x)] = std::min(least[size_t(y) * 64 + size_t(x)], p.z);
                    }
                }
        }
        for (size_t i = 0; i < bounds.size(); ++i) {
            if (least[i] > 1e29) continue;
            ++touched;
            tight += bounds[i].x > least[i] - 2e-3 * fit.areas[layer].texel_m * 64;
        }
    }
    EXPECT_GT(touched, 1000u);
    EXPECT_GT(tight, touched * 95 / 100) << "a bound far below everything would pass the first half";
}

}  // namespace
}  // namespace penumbra::test
