// SPDX-License-Identifier: MIT
// The node trace_penumbra against Embree: each pixel's ray made anew in double precision, and the distance of
// the first thing that it meets. One that any hit would satisfy is told from it: such a distance is often
// that of something farther away.
#include "tests/alpha_oracle.h"
#include "tests/embree_scene.h"
#include "tests/gpu_test.h"
#include "tests/ray_maker.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

constexpr double lit = 65504;

class TracePenumbra : public GpuTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(TracePenumbra, IsAsWideAsTheNearestBlockerIsFar) {
    SessionOptions options;
    options.size = {384, 216};
    options.captures = {"view_depth", "receiver_normal", "tile_list", "trace_args", "penumbra"};
    const auto session = open_session(shipped_pipeline("sigma"), shot_named(GetParam()), options);

    session->run_frame(0, true);
    const AlphaOracle alpha(session->host().scene());
    EmbreeScene::Blocks blocks;
    if (session->plan().facts.at("alpha"))
        blocks = [&](uint32_t triangle, double u, double v) { return alpha.blocks(triangle, u, v); };
    const EmbreeScene embree(session->host().scene().triangles(0), blocks);
    const StandaloneFrame standalone = session->host().frame(0, true);
    const RayMaker maker(*session, shipped_nodes(), standalone);
    const double half_tangent = 0.5 * std::tan(double(standalone.sun.angular_radius));
    const auto depth = captured_values<float>(*session, "view_depth");
    const auto normal = captured_values<NormalTexel>(*session, "receiver_normal");
    const auto penumbra = captured_values<uint16_t>(*session, "penumbra");
    const auto list = captured_values<std::array<uint32_t, 4>>(*session, "tile_list");
    const uint32_t listed = captured_values<uint32_t>(*session, "trace_args")[3];
    size_t rays = 0, occluded = 0, wrong = 0, sunk = 0;
    std::vector<uint8_t> wanted(penumbra.size());
    for (uint32_t i = 0; i < listed; ++i)
        for (uint32_t bit = 0; bit < 32; ++bit) {
            if (!(list[i][1] >> bit & 1)) continue;
            const uint32_t x = (list[i][0] & 0xffff) * 8 + bit % 8, y = (list[i][0] >> 16) * 4 + bit / 8,
                           pixel = y * 384 + x;
            wanted[pixel] = 1;
            const Ray ray = maker.ray(x, y, depth[pixel], normal[pixel]);
            const auto ours = static_cast<double>(from_half(penumbra[pixel]));
            ++rays;
            if (RayMaker::slope(ray, normal[pixel]) <= 1e-6) {
                ++sunk;
                wrong += ours != 0;
                continue;
            }
            const auto hit = embree.nearest(ray);
            occluded += hit.has_value();
            const double expected = hit ? half_tangent * double(hit->t) : lit;
            wrong += std::abs(ours - expected) > 2e-3 * expected + 1e-6;  // fp16, and rays of 1e-6
        }
    for (size_t i = 0; i < wanted.size(); ++i)
        if (!wanted[i]) {
            EXPECT_EQ(penumbra[i], 0) << i;
        }
    std::printf("%s: %zu rays, %zu occluded, %zu sunk, %zu wrong\n", GetParam(), rays, occluded, sunk, wrong);
    EXPECT_GT(occluded, rays / 50);
    EXPECT_LE(wrong, rays / 2000);
}

INSTANTIATE_TEST_SUITE_P(Shots, TracePenumbra, ::testing::Values("colonnade", "trees", "cards"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace penumbra::test
