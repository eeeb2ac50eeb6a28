// SPDX-License-Identifier: MIT
// The node average: the plain mean of what it is given, to the digits that it keeps, for more frames than it
// counts; it starts anew after a reset and wherever the jitter shifts the pixels.
#include <cmath>
#include <random>

#include "tests/gpu_test.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

constexpr const char* pipeline_text = R"({
  "penumbra": 1, "name": "average", "inputs": { "fresh": {} }, "outputs": ["visibility"],
  "nodes": { "average": { "type": "average", "in": { "mean_prev": "mean@-1" } } }
})";

class Average : public GpuTest {
  protected:
    static constexpr Extent extent{19, 7};
    static constexpr size_t pixels = size_t{extent.width} * extent.height;

    static ViewRunOptions options() {
        ViewRunOptions o;
        o.jitters = true;
        o.formats = {{"fresh", Format::r16f}};
        return o;
    }

    // One frame in which every pixel is the same; what the first of them has become.
    double frame(double fresh, bool reset = false, double jitter = 0, double prev_jitter = 0) {
        const uint16_t half = to_half4({fresh, 0, 0, 0})[0];
        run_.set("fresh", std::vector<uint16_t>(pixels, half));
        const Camera camera = camera_at({0, 0, 0}, 0, extent);
        FrameDescription f = frame_between(camera, camera, extent, index_++, reset);
        f.jitter = {jitter, 0};
        f.prev_jitter = {prev_jitter, 0};
        run_.frame(f);
        const std::vector<float> image = captured_planes(run_.view(), "visibility")[0];
        for (const float v : image) EXPECT_EQ(v, image[0]);
        return image[0];
    }

    ViewRun run_{shadow_pipeline(pipeline_text), extent, options()};
    uint32_t index_ = 0;
};

TEST_F(Average, IsTheMeanOfAllFrames) {
    std::mt19937 random(1);
    double sum = 0;
    for (int n = 1; n <= 900; ++n) {
        const double fresh = double(random() % 129) / 128;  // fp16 holds it
        sum += fresh;
        // Two roundings: a mean of 22 bits each frame, which later frames average, and the image's fp16.
        EXPECT_NEAR(frame(fresh, n == 1), sum / n, half_ulp(sum / n) + 4 * 0x1p-22) << n << " frames";
    }
}

TEST_F(Average, StandsStillForEver) {
    frame(1, true);
    for (int i = 0; i < 3000; ++i) ASSERT_EQ(frame(1), 1) << i;
    double v = 1;
    for (int i = 0; i < 3000; ++i) {
        const double next = frame(0);
        ASSERT_LE(next, v) << "the mean of more zeros rises";
        v = next;
    }
    EXPECT_LT(v, 0.06) << "after its last count it must go on forgetting";
}

TEST_F(Average, StartsAnewAfterAResetAndWhereTheJitterShifts) {
    frame(1, true);
    EXPECT_EQ(frame(0), 0.5);
    EXPECT_EQ(frame(0, true), 0) << "a reset";
    EXPECT_EQ(frame(1), 0.5);
    EXPECT_EQ(frame(1, false, 0.01, 0), 1) << "another jitter than the last frame's";
    EXPECT_EQ(frame(0, false, 0.01, 0.01), 0.5) << "the same jitter";
}

}  // namespace
}  // namespace penumbra::test
