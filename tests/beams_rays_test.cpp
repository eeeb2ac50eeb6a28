// SPDX-License-Identifier: MIT
// The node beams against Embree: every ray to the sun's disc from a pixel that it calls lit must be free,
// from one that it calls shadowed must be blocked. And the rays that are left give what they give without it.
#include <map>

#include "host/bvh/bvh.h"
#include "tests/embree_scene.h"
#include "tests/gpu_test.h"
#include "tests/ray_maker.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/test_scene.h"

namespace penumbra::test {
namespace {

struct Verdicts {
    size_t receivers = 0, lit = 0, shadowed = 0, traced = 0;
    size_t wrong_lit = 0, wrong_shadowed = 0;  // pixels with a ray that contradicts
};

// Judges one frame with `side` squared rays per pixel that a beam decided.
Verdicts judge(Shot shot, double angle_deg, uint32_t side) {
    shot.sun_angular_radius_deg = angle_deg;
    SessionOptions options;
    options.size = shot.size;
    options.jitter = false;
    options.captures = {"view_depth",     "receiver_normal", "receiver_words", "undecided_words",
                        "preloaded_hits", "tile_list",       "trace_args"};
    const auto session = open_session(
        shipped_pipeline("many_rays", {"nodes.classify.out.undecided_words=undecided_words"}), shot, options);
    session->run_frame(0, true);

    const std::vector<Triangle> triangles = session->host().scene().triangles(0);
    const EmbreeScene embree(triangles);
    const StandaloneFrame standalone = session->host().frame(0, true);
    const RayMaker maker(*session, shipped_nodes(), standalone);
    const auto depth = captured_values<float>(*session, "view_depth");
    const auto normal = captured_values<NormalTexel>(*session, "receiver_normal");
    const auto receivers = captured_values<uint32_t>(*session, "receiver_words"),
               candidates = captured_values<uint32_t>(*session, "undecided_words"),
               hits = captured_values<uint32_t>(*session, "preloaded_hits");
    const uint32_t tiles_x = (shot.size[0] + 7) / 8,
                   listed = captured_values<uint32_t>(*session, "trace_args")[3];
    const auto list = captured_values<std::array<uint32_t, 4>>(*session, "tile_list");
    std::vector<uint32_t> undecided(candidates.size());
    for (uint32_t i = 0; i < listed; ++i)
        undecided[(list[i][0] >> 16) * tiles_x + (list[i][0] & 0xffff)] = list[i][1];
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
            if (has(undecided)) {
                ++sum.traced;
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
                const Ray ray = maker.from_ahead(maker.ray(x, y, depth[pixel], normal[pixel], u), x, y,
                                                 depth[pixel], normal[pixel]);
                blocked += RayMaker::slope(ray, normal[pixel]) <= 0 || embree.occluded(ray);
            }
            if (has(hits)) {
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
    Shot shot = shot_named(name);
    shot.size = size;
    return shot;
}

class BeamsOnShots : public GpuTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(BeamsOnShots, NeverContradictARay) {
    size_t lit = 0, shadowed = 0;
    for (const double angle_deg : {0.0, 0.25, 0.5, 1.0, 2.0, 10.0}) {
        const Verdicts v = judge(shipped(GetParam(), {320, 180}), angle_deg, 8);
        std::printf("%s %.2f deg: receivers %zu, lit %zu, shadowed %zu, traced %.2f %%\n", GetParam(),
                    angle_deg, v.receivers, v.lit, v.shadowed,
                    100.0 * double(v.traced) / double(v.receivers));
        EXPECT_EQ(v.wrong_lit, 0u) << angle_deg;
        EXPECT_EQ(v.wrong_shadowed, 0u) << angle_deg;
        lit += v.lit;
        shadowed += v.shadowed;
    }
    EXPECT_GT(lit + shadowed, 100u);
}

// What is proved needs no ray, and what is left gets the ray that it gets without proofs: the words of the
// two pipelines are the same bits, whatever the camera, the sun and the objects do. So are the images, of one
// ray and of several.
void expect_the_words_of_raw(const Shot& shot, std::initializer_list<uint32_t> frames, uint32_t rays = 1) {
    const std::vector<std::string> settings = {"nodes.trace.params.rays_per_pixel=" + std::to_string(rays)};
    struct Run {
        std::vector<std::vector<uint32_t>> words;
        std::vector<std::vector<uint8_t>> images;
    };
    std::map<std::string, Run> runs;
    for (const std::string pipeline : {"raw", "many_rays"}) {
        SessionOptions options;
        options.size = shot.size;
        options.captures = {"hits", "visibility"};
        const auto session = open_session(shipped_pipeline(pipeline, settings), shot, options);
        for (const uint32_t frame : frames) {
            session->run_frame(frame, frame == *frames.begin());
            runs[pipeline].words.push_back(captured_values<uint32_t>(*session, "hits"));
            runs[pipeline].images.push_back(captured_values<uint8_t>(*session, "visibility"));
        }
    }
    const Run& raw = runs.at("raw");
    for (const auto& [pipeline, run] : runs) {
        EXPECT_TRUE(run.images == raw.images) << shot.name << ", " << pipeline;
        for (size_t f = 0; f < raw.words.size(); ++f)
            for (size_t i = 0; i < raw.words[f].size(); ++i)
                ASSERT_EQ(run.words[f][i], raw.words[f][i])
                    << shot.name << ", " << pipeline << ", word " << i << " of frame " << f;
    }
}

TEST_P(BeamsOnShots, ChangeNoRaysAnswer) {
    expect_the_words_of_raw(shipped(GetParam(), {200, 113}), {0, 1, 2, 9});
}

TEST_P(BeamsOnShots, ChangeNoneOfSeveralRays) {
    expect_the_words_of_raw(shipped(GetParam(), {200, 113}), {0, 1}, 5);
}

class BeamsOn : public GpuTest {};

TEST_F(BeamsOn, MovingObjectsChangeNoRaysAnswer) {
    expect_the_words_of_raw(plaza_shot({160, 96}, 8), {0, 1, 2, 7});
}

// A hole lets rays through, whatever surrounds it: a proof that took a leaf card for solid would show here.
TEST_F(BeamsOn, AlphaTestedCardsChangeNoRaysAnswer) {
    expect_the_words_of_raw(shipped("cards", {200, 113}), {0, 1});
    expect_the_words_of_raw(shipped("cards", {200, 113}), {0}, 4);
}

INSTANTIATE_TEST_SUITE_P(Shots, BeamsOnShots,
                         ::testing::Values("colonnade", "engine", "fan", "heightfield", "lamp", "trees"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace penumbra::test
