// SPDX-License-Identifier: MIT
// The node cones against Embree: every ray to the sun's disc from a pixel that it calls lit must be free,
// from one that it calls shadowed must be blocked. How much it leaves to rays is measured against the pixels
// in penumbra, counted by the same rays.
#include <bit>
#include <cmath>

#include "host/bvh.h"
#include "nodes/nodes.h"
#include "tests/embree_scene.h"
#include "tests/gpu_test.h"
#include "tests/ray_maker.h"

namespace penumbra::test {
namespace {

const std::filesystem::path root = PENUMBRA_SOURCE_DIR;

const NodeSet& nodes() {
    static const NodeSet set = shadow_nodes();
    return set;
}

CheckedPipeline hybrid_raw(const std::vector<std::string>& settings = {}) {
    Diagnostics diagnostics;
    const auto pipeline = load_pipeline(root / "pipelines/hybrid_raw.json", settings, diagnostics);
    auto result = pipeline ? check(*pipeline, nodes(), diagnostics) : std::nullopt;
    if (!result) throw std::runtime_error(diagnostics.text());
    return std::move(*result);
}

struct Verdicts {
    size_t receivers = 0, lit = 0, shadowed = 0, traced = 0;
    size_t penumbra = 0, penumbra_traced = 0;  // by the rays
    size_t wrong_lit = 0, wrong_shadowed = 0;  // pixels with a ray that contradicts

    double eta() const { return traced ? double(penumbra_traced) / double(traced) : 1; }
};

// Judges one frame with `side` squared rays per pixel that classify left open.
Verdicts judge(Shot shot, double angle_deg, const std::vector<std::string>& settings, uint32_t side) {
    shot.sun_angular_radius_deg = angle_deg;
    SessionOptions options;
    options.size = shot.size;
    options.optimum = false;
    options.jitter = false;
    options.captures = {"view_depth",      "guide_normal",   "receiver_words",
                        "candidate_words", "preloaded_hits", "undecided_words"};
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    std::vector<std::string> all = {"nodes.classify.out.undecided_words=candidate_words"};
    all.insert(all.end(), settings.begin(), settings.end());
    const auto session = Session::open(gpu(), nodes(), hybrid_raw(all), shot, options, diagnostics, warnings);
    if (!session) throw std::runtime_error(diagnostics.text());
    session->run_frame(0, true);

    const std::vector<Triangle> triangles = session->host().scene().triangles(0);
    const EmbreeScene embree(triangles);
    const StandaloneFrame standalone = session->host().frame(0, true);
    const RayMaker maker(*session, nodes(), standalone);
    const auto depth = captured<float>(*session, "view_depth");
    const auto normal = captured<uint32_t>(*session, "guide_normal"),
               receivers = captured<uint32_t>(*session, "receiver_words"),
               candidates = captured<uint32_t>(*session, "candidate_words"),
               hits = captured<uint32_t>(*session, "preloaded_hits"),
               undecided = captured<uint32_t>(*session, "undecided_words");
    const uint32_t tiles_x = (shot.size[0] + 7) / 8;
    Verdicts sum;
    for (uint32_t y = 0; y < shot.size[1]; ++y)
        for (uint32_t x = 0; x < shot.size[0]; ++x) {
            const uint32_t word = y / 4 * tiles_x + x / 8, bit = y % 4 * 8 + x % 8,
                           pixel = y * shot.size[0] + x;
            const auto has = [&](const std::vector<uint32_t>& words) {
                return (words[word] >> bit & 1) != 0;
            };
            sum.receivers += has(receivers);
            if (!has(candidates)) {
                EXPECT_FALSE(has(undecided));
                continue;
            }
            uint32_t blocked = 0;
            for (uint32_t i = 0; i < side * side; ++i) {
                // The rim is where a wrong verdict shows first: cells of equal area, jittered, and a few
                // points on it.
                const uint32_t h = hash(pixel * 4096 + i);
                glm::dvec2 u((i % side + (h & 0xffff) / 65536.0) / side,
                             (i / side + (h >> 16) / 65536.0) / side);
                if (i % 8 == 0) u.x = i % 16 ? 0 : 1 - 0x1p-20;
                blocked += embree.occluded(maker.ray(x, y, depth[pixel], normal[pixel], u));
            }
            const bool in_penumbra = blocked != 0 && blocked != side * side;
            sum.penumbra += in_penumbra;
            if (has(undecided)) {
                ++sum.traced;
                sum.penumbra_traced += in_penumbra;
            } else if (has(hits)) {
                ++sum.shadowed;
                sum.wrong_shadowed += blocked != side * side;
            } else {
                ++sum.lit;
                sum.wrong_lit += blocked != 0;
            }
        }
    return sum;
}

Shot shipped(const char* name, std::array<uint32_t, 2> size) {
    Diagnostics diagnostics;
    auto shot = read_shot(root / "scenes" / (std::string(name) + ".shot.json"), diagnostics);
    if (!shot) throw std::runtime_error(diagnostics.text());
    shot->size = size;
    return *shot;
}

class Cones : public GpuTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(Cones, NeverContradictARay) {
    for (const double angle_deg : {0.0, 0.25, 0.5, 1.0, 2.0}) {
        const Verdicts v = judge(shipped(GetParam(), {160, 90}), angle_deg, {}, 8);
        std::printf(
            "%s %.2f deg: receivers %zu, lit %zu, shadowed %zu, traced %.2f %%, penumbra %.2f %%, eta %.3f\n",
            GetParam(), angle_deg, v.receivers, v.lit, v.shadowed,
            100.0 * double(v.traced) / double(v.receivers), 100.0 * double(v.penumbra) / double(v.receivers),
            v.eta());
        EXPECT_EQ(v.wrong_lit, 0u) << angle_deg;
        EXPECT_EQ(v.wrong_shadowed, 0u) << angle_deg;
        if (angle_deg == 0.25) {
            EXPECT_GT(v.eta(), 0.4);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Shots, Cones,
                         ::testing::Values("colonnade", "engine", "fan", "heightfield", "lamp", "trees"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace penumbra::test
