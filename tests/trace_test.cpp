// SPDX-License-Identifier: MIT
// The node trace, as it runs in a pipeline, against Embree: the test makes each pixel's ray anew in double
// precision from the depth and normal that the node read, the noise tile and the sun, and asks Embree. Where
// the two differ, double precision must say that the ray passes an edge, or the border of an alpha mask's
// texel, within rounding. A ray that points into its own surface meets it, whatever Embree finds behind its
// offset origin.
#include "tests/alpha_oracle.h"
#include "tests/embree_scene.h"
#include "tests/gpu_test.h"
#include "tests/ray_maker.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"

namespace penumbra::test {
namespace {

class Trace : public GpuTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(Trace, AgreesWithEmbreeOnAMillionShadowRays) {
    SessionOptions options;
    options.size = {1280, 720};
    options.captures = {"view_depth", "receiver_normal", "tile_list", "trace_args", "hits"};
    const auto session = open_session(shipped_pipeline("raw"), shot_named(GetParam()), options);

    const AlphaOracle alpha(session->host().scene());
    EmbreeScene::Blocks blocks;
    if (session->plan().facts.at("alpha"))
        blocks = [&](uint32_t triangle, double u, double v) { return alpha.blocks(triangle, u, v); };
    constexpr double rounding = 1e-6;
    size_t rays = 0, blocked = 0, differ = 0, sunk = 0, slipped = 0;
    for (uint32_t frame = 0; rays < 1'000'000 && frame < 8; ++frame) {
        const std::vector<Triangle> triangles = session->host().scene().triangles(frame);
        const EmbreeScene embree(triangles, blocks);
        session->run_frame(frame, frame == 0);
        const StandaloneFrame standalone = session->host().frame(frame, frame == 0);
        const RayMaker maker(*session, shipped_nodes(), standalone);
        const auto depth = captured_values<float>(*session, "view_depth");
        const auto normal = captured_values<NormalTexel>(*session, "receiver_normal");
        const auto hits = captured_values<uint32_t>(*session, "hits");
        const auto list = captured_values<std::array<uint32_t, 4>>(*session, "tile_list");
        const uint32_t listed = captured_values<uint32_t>(*session, "trace_args")[3];
        for (uint32_t i = 0; i < listed; ++i) {
            const uint32_t tile_x = list[i][0] & 0xffff, tile_y = list[i][0] >> 16;
            for (uint32_t bit = 0; bit < 32; ++bit) {
                if (!(list[i][1] >> bit & 1)) continue;
                const uint32_t x = tile_x * 8 + bit % 8, y = tile_y * 4 + bit / 8, pixel = y * 1280 + x;
                const Ray ray = maker.ray(x, y, depth[pixel], normal[pixel]);
                const bool ours = hits[tile_y * 160 + tile_x] >> bit & 1;
                ++rays;
                blocked += ours;
                const double slope = RayMaker::slope(ray, normal[pixel]);
                if (slope < -rounding) {
                    EXPECT_TRUE(ours) << "pixel " << x << ", " << y << " of frame " << frame;
                    ++sunk;
                    slipped += !embree.occluded(ray);
                    continue;
                }
                if (slope < rounding) continue;  // either way
                if (ours == embree.occluded(ray)) continue;
                ++differ;
                // Two roundings apart: the node made its ray in single precision, of coordinates as large as
                // the scene.
                const Ray past = maker.past_what_is_asked(ray, x, y, depth[pixel], normal[pixel]);
                EXPECT_NE(alpha.truth(triangles, ours ? ray : past, 8e-6),
                          ours ? Truth::clear : Truth::blocked)
                    << "pixel " << x << ", " << y << " of frame " << frame;
                ASSERT_LT(differ, 2000u) << "too many differences to be rounding";
            }
        }
    }
    std::printf(
        "%s: %zu rays, %zu blocked, %zu differ from Embree; %zu point into their surface, %zu would slip "
        "past\n",
        GetParam(), rays, blocked, differ, sunk, slipped);
    RecordProperty("differ", static_cast<int>(differ));
    EXPECT_GE(rays, 1'000'000u);
    EXPECT_GT(blocked, rays / 100);
    EXPECT_LT(blocked, rays - rays / 100);
}

INSTANTIATE_TEST_SUITE_P(Shots, Trace, ::testing::Values("colonnade", "engine", "cards"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace penumbra::test
