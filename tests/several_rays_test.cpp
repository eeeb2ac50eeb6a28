// SPDX-License-Identifier: MIT
// Several rays per pixel in trace, on shadows known in closed form: their mean is the visibility, their error
// falls faster than that of independent rays, and the first of them is the ray that is cast where there is no
// other.
#include <cmath>

#include "app/session.h"
#include "host/truth/analytic.h"
#include "tests/gpu_test.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/test_scene.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

std::unique_ptr<Session> open(const Shot& shot, uint32_t rays, SessionOptions options = {},
                              const std::string& name = "raw") {
    const std::vector<std::string> settings = {"outputs=[\"visibility\"]",
                                               "nodes.trace.params.rays_per_pixel=" + std::to_string(rays)};
    options.size = shot.size;
    options.captures.push_back("visibility");
    options.jitter = false;
    return open_session(shipped_pipeline(name, settings), shot, options);
}

Shot analytic_shot(const AnalyticScene& scene) {
    Shot shot;
    shot.analytic = scene;
    shot.size = {120, 60};
    shot.frames = 8;
    shot.sun = {{0, {0.3, 0.2, 1}}};
    add_analytic_motion(shot);
    return shot;
}

std::vector<uint8_t> visibility_of(const Session& session) {
    return captured<uint8_t>(session.view(), "visibility");
}

struct Error {
    double square = 0;  // mean over the penumbra, of one image
    double bias = 0;    // mean over images and the penumbra
    double wrong = 0;   // largest outside of the penumbra
};

Error error_of(const Shot& shot, uint32_t rays, uint32_t frames) {
    const auto session = open(shot, rays);
    Error out;
    double n = 0;
    for (uint32_t frame = 0; frame < frames; ++frame) {
        session->run_frame(frame, frame == 0);
        const std::vector<double> exact = analytic_image(shot, frame);
        const auto image = visibility_of(*session);
        for (size_t p = 0; p < exact.size(); ++p) {
            const double e = image[p] / 255.0 - exact[p];
            if (exact[p] <= 0 || exact[p] >= 1) {
                out.wrong = std::max(out.wrong, std::abs(e));
                continue;
            }
            const double steps = image[p] / 255.0 * rays;
            EXPECT_NEAR(steps, std::round(steps), rays / 509.0) << "a share of " << rays << " rays";
            out.square += e * e;
            out.bias += e;
            ++n;
        }
    }
    EXPECT_GT(n, 5000);
    out.square /= n;
    out.bias /= n;
    return out;
}

class SeveralRays : public GpuTest {};

TEST_F(SeveralRays, AreUnbiasedAndBetterThanIndependentOnes) {
    for (const AnalyticScene& scene :
         {AnalyticScene{24, 20, 0, 0, HalfPlane{}}, AnalyticScene{24, 65, 0, 0, Slit{8}}}) {
        const Shot shot = analytic_shot(scene);
        double one = 0;
        for (const uint32_t rays : {1u, 2u, 4u, 7u, 16u, 64u}) {
            const Error e = error_of(shot, rays, 6);
            if (rays == 1) one = e.square;
            std::printf("%2u rays: error %.4f, as %.1f independent rays; bias %+.4f\n", rays,
                        std::sqrt(e.square), one / e.square, e.bias);
            EXPECT_LT(e.wrong, 0.51 / 255);
            // Neighbours' errors are anticorrelated, so that of the mean is below that of as many independent
            // rays.
            EXPECT_LT(std::abs(e.bias), 3 * std::sqrt(e.square / 5000) + 1e-3) << rays;
            if (rays >= 4) {
                EXPECT_LT(e.square * rays, 0.9 * one) << rays;
            }
            if (rays >= 16) {
                EXPECT_LT(e.square * rays, 0.35 * one) << rays;
            }
        }
    }
}

// Whoever reads the hit words (the denoisers) knows where the ray went.
TEST_F(SeveralRays, TheFirstIsTheOneThatIsCastAlone) {
    std::vector<std::vector<uint32_t>> words[2];
    std::vector<uint8_t> last[2];
    for (const uint32_t rays : {1u, 5u}) {
        SessionOptions options;
        options.captures = {"hits"};
        const auto session = open(plaza_shot({203, 117}, 4), rays, options);
        for (uint32_t frame = 0; frame < 3; ++frame) {
            session->run_frame(frame, frame == 0);
            words[rays > 1].push_back(captured<uint32_t>(session->view(), "hits"));
        }
        last[rays > 1] = visibility_of(*session);
    }
    EXPECT_TRUE(words[0] == words[1]);
    EXPECT_FALSE(last[0] == last[1]);
}

// All rays to a point are one.
TEST_F(SeveralRays, AreOneUnderAPointForASun) {
    Shot shot = plaza_shot({160, 96}, 1);
    shot.sun_angular_radius_deg = 0;
    const auto session = open(shot, 8);
    session->run_frame(0, true);
    const auto counters = counters_of(session->view(), "trace");
    EXPECT_EQ(counters.at("rays"), counters_of(session->view(), "classify").at("unknown"));
    for (const uint8_t v : visibility_of(*session)) EXPECT_TRUE(v == 0 || v == 255);
}

}  // namespace
}  // namespace penumbra::test
