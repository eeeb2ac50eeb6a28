// SPDX-License-Identifier: MIT
// What shadow maps prove lit, against the rays themselves: the same noise is traced with and without the
// proof, and no pixel may differ. That one property covers acne, shadows that come off their casters, leaks
// at cascades' borders and wires thinner than a texel; the published search on the same maps shows that the
// scenes would tell.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <random>

#include "app/session.h"
#include "host/cascades/cascade_maps.h"
#include "host/models/glb_writer.h"
#include "host/models/shapes.h"
#include "tests/gpu_test.h"
#include "tests/scene_file.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/test_scene.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

namespace fs = std::filesystem;
const fs::path root = PENUMBRA_SOURCE_DIR;
using Bytes = std::vector<std::byte>;

// The classifiers before undenoised rays, where a pixel's verdict can be seen.
const char* const cascades_raw = "../tests/pipelines/cascades_raw";
const char* const taps_raw = "../tests/pipelines/taps_raw";

std::vector<std::byte> glb_of(const std::vector<Shape>& shapes) {
    Model model;
    for (const Shape& shape : shapes)
        add(model, ("node" + std::to_string(model.nodes.size())).c_str(), shape, -1);
    return to_glb(model);
}

Shot shot_of(const fs::path& model, std::array<uint32_t, 2> size, uint32_t frames) {
    Shot shot;
    shot.name = "cascades";
    shot.model = model;
    shot.size = size;
    shot.frames = frames;
    shot.camera = {{0, {0.5, 1.6, 4}, {0, 0.4, 0}, {0, 1, 0}}};
    shot.sun = {{0, {0.5, 0.8, 0.3}}};
    shot.sun_angular_radius_deg = 0.27;
    return shot;
}

// Wires of 6 mm over a floor.
Shot wires_shot() {
    static const SceneFile file("wires.glb",
                                glb_of({ground(8, 8, 4, 4), rod({-2, 0.3, 0}, {2, 0.4, 0.3}, 0.003, 6),
                                        rod({-2, 1.1, 0.4}, {2, 0.9, -0.6}, 0.003, 6),
                                        rod({0.3, 0, 0.2}, {0.3, 1.2, 0.2}, 0.003, 6)}));
    return shot_of(file.path(), {240, 136}, 2);
}

// Boxes that stand on the floor and on each other, seen from close.
Shot contact_shot() {
    static const SceneFile file(
        "contact.glb",
        glb_of({ground(8, 8, 4, 4), box({-0.5, 0, -0.5}, {0.3, 0.5, 0.3}),
                box({-0.2, 0.5, -0.2}, {0.1, 0.53, 0.1}), box({0.6, 0, 0.2}, {0.9, 0.02, 0.6})}));
    Shot shot = shot_of(file.path(), {160, 90}, 2);
    shot.camera = {{0, {-1.5, 0.9, 1.2}, {-0.1, 0.2, 0}, {0, 1, 0}}};
    return shot;
}

// A long row of posts: every slice of the view has casters across its border, and the camera steps by
// millimetres.
Shot steps_shot() {
    static const SceneFile file("steps.glb", [] {
        std::vector<Shape> shapes{ground(60, 60, 8, 8)};
        for (int i = 0; i < 24; ++i)
            shapes.push_back(
                box({-1.5 + 0.2 * (i % 3), 0, 2.0 - 1.8 * i}, {-1.4 + 0.2 * (i % 3), 1.4, 2.1 - 1.8 * i}));
        return glb_of(shapes);
    }());
    Shot shot = shot_of(file.path(), {160, 90}, 6);
    shot.camera = {{0, {0.5, 1.6, 4}, {0, 1.0, 0}, {0, 1, 0}},
                   {5, {0.505, 1.6, 4}, {0.01, 1.0, 0}, {0, 1, 0}}};
    return shot;
}

struct Frames {
    std::vector<Bytes> visibility;
    uint64_t rays = 0;
};

Frames run(const char* name, const std::vector<std::string>& settings, const Shot& shot,
           SessionOptions options = {}) {
    options.size = shot.size;
    options.optimum = false;
    options.captures = {"visibility"};
    const auto session =
        open_session(shipped_pipeline(name, settings, test_nodes()), shot, options, test_nodes());
    Frames frames;
    for (uint32_t frame = 0; frame < shot.frames; ++frame) {
        session->run_frame(frame, frame == 0 || frame == 5);
        const auto bytes = session->view().captured("visibility");
        frames.visibility.emplace_back(bytes.begin(), bytes.end());
        const auto counters = counters_of(session->view(), "trace");
        if (counters.contains("rays")) frames.rays += counters.at("rays");
    }
    return frames;
}

size_t differing(const Frames& a, const Frames& b) {
    size_t count = 0;
    for (size_t f = 0; f < a.visibility.size(); ++f)
        for (size_t i = 0; i < a.visibility[f].size(); ++i) count += a.visibility[f][i] != b.visibility[f][i];
    return count;
}

SessionOptions maps_of(uint32_t size) {
    SessionOptions options;
    options.cascade_size = size;
    return options;
}

class Cascades : public GpuTest {};

TEST_F(Cascades, SpareRaysAndChangeNoPixel) {
    for (const double radius_deg : {0.0, 0.27, 8.0}) {
        SCOPED_TRACE(radius_deg);
        Shot shot = plaza_shot({160, 90}, 2);
        shot.sun_angular_radius_deg = radius_deg;
        const Frames rays = run("raw", {}, shot), hybrid = run(cascades_raw, {}, shot, maps_of(256));
        EXPECT_EQ(differing(rays, hybrid), 0u);
        EXPECT_LT(hybrid.rays, radius_deg < 1 ? rays.rays / 2 : rays.rays * 9 / 10);
    }
}

TEST_F(Cascades, KeepTheShadowsOfWiresThinnerThanATexel) {
    const Shot shot = wires_shot();
    const Frames rays = run("raw", {}, shot), hybrid = run(cascades_raw, {}, shot, maps_of(64));
    EXPECT_EQ(differing(rays, hybrid), 0u);
    EXPECT_LT(hybrid.rays, rays.rays * 9 / 10);
    // Ordinary maps of that size do not see them.
    EXPECT_GT(differing(rays, run(taps_raw, {}, shot, maps_of(64))), 10u);
}

TEST_F(Cascades, KeepShadowsAttachedToTheirCasters) {
    const Shot shot = contact_shot();
    const Frames rays = run("raw", {}, shot);
    EXPECT_EQ(differing(rays, run(cascades_raw, {}, shot, maps_of(512))), 0u);
    // Texels as wide as the lower boxes are high: a bias of a quarter of one, as maps' depths are usually
    // compared with, takes their sides for the floor.
    const std::string biased = "nodes.cascades.params.contact_texels=0.25";
    const Frames exact = run(cascades_raw, {}, shot, maps_of(32));
    EXPECT_EQ(differing(rays, exact), 0u);
    EXPECT_LT(exact.rays, rays.rays * 9 / 10);
    EXPECT_GT(differing(rays, run(cascades_raw, {biased}, shot, maps_of(32))), 0u);
}

TEST_F(Cascades, ChangeNothingAtTheirBordersWhileTheCameraSteps) {
    const Shot shot = steps_shot();
    const Frames rays = run("raw", {}, shot), hybrid = run(cascades_raw, {}, shot, maps_of(256));
    EXPECT_EQ(differing(rays, hybrid), 0u);
    EXPECT_LT(hybrid.rays, rays.rays / 2);
}

TEST_F(Cascades, DoNotDependOnWhereTheWorldIs) {
    Shot shot = wires_shot();
    const Frames here = run(cascades_raw, {}, shot, maps_of(128));
    shot.origin = {1e6, 0, -3e6};
    const Frames there = run(cascades_raw, {}, shot, maps_of(128));
    EXPECT_LE(differing(here, there), 8u);  // rounding of the camera's own position
    EXPECT_NEAR(double(here.rays), double(there.rays), 0.01 * double(here.rays));
}

TEST_F(Cascades, AliasingAndPoisonDoNotShow) {
    const Shot shot = plaza_shot({75, 43}, 8);
    for (const char* name :
         {cascades_raw, taps_raw, "hybrid_cascades", "hybrid_fidelityfx", "cascades_only"}) {
        SessionOptions plain = maps_of(64);
        plain.alias = false;
        const Frames expected = run(name, {}, shot, plain);
        for (const uint32_t poison : {0u, 1u}) {
            SessionOptions options = maps_of(64);
            options.poison = poison;
            EXPECT_EQ(differing(expected, run(name, {}, shot, options)), 0u) << name << " poison " << poison;
        }
    }
}

TEST_F(Cascades, IntervalsDoNotChangeAnswers) {
    const std::string whole = "nodes.cascades.params.use_interval=false";
    for (const Shot& shot : {plaza_shot({96, 64}, 1), wires_shot()}) {
        const Frames rays = run("raw", {}, shot);
        EXPECT_EQ(differing(rays, run(cascades_raw, {}, shot, maps_of(64))), 0u);
        EXPECT_EQ(differing(rays, run(cascades_raw, {whole}, shot, maps_of(64))), 0u);
    }
}

TEST_F(Cascades, TheOrderOfTheTileListDoesNotShow) {
    const Shot shot = plaza_shot({160, 90}, 2);
    const std::vector<std::string> permuted = {R"(nodes.back={"type": "permute_list"})",
                                               R"(nodes.trace.in={"tile_list": "permuted_list"})"};
    for (const char* name : {cascades_raw, taps_raw})
        EXPECT_EQ(differing(run(name, {}, shot, maps_of(128)), run(name, permuted, shot, maps_of(128))), 0u)
            << name;
}

// Filtered maps alone are no reference, but they are shadows: most pixels agree with the rays.
TEST_F(Cascades, AloneGiveShadowsToo) {
    const Shot shot = contact_shot();
    const Frames rays = run("raw", {}, shot), maps = run("cascades_only", {}, shot, maps_of(512));
    const size_t pixels = size_t{shot.size[0]} * shot.size[1] * shot.frames;
    size_t opposite = 0, dark = 0;
    for (size_t f = 0; f < rays.visibility.size(); ++f)
        for (size_t i = 0; i < rays.visibility[f].size(); ++i) {
            opposite += std::abs(int(rays.visibility[f][i]) - int(maps.visibility[f][i])) > 200;
            dark += maps.visibility[f][i] == std::byte{0};
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
    const SceneFile file("soup.glb", glb_of({soup}));
    Shot shot = shot_of(file.path(), {160, 90}, 1);
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
        const Bytes bytes = read_image(gpu(), maps.bounds().get(), CascadeMaps::bounds_format,
                                       maps.bounds().extent, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, layer);
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
