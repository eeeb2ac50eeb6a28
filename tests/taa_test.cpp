// SPDX-License-Identifier: MIT
// The node taa on a device: its published form, computed again in double precision per pixel, and what any
// temporal anti-aliasing owes: a reset passes through, a still image stays, an edge under jitter becomes its
// area, history from outside the screen is none, and nothing finite becomes infinite.
#include <cmath>
#include <limits>
#include <random>

#include "tests/taa_run.h"

namespace penumbra::test {
namespace {

using Color = glm::dvec3;

struct TaaInputs {
    std::vector<Color> color;
    std::vector<glm::dvec2> motion;
    std::vector<float> depth;  // reverse Z, near 5 cm
};

class TaaOnImages : public Taa {
  public:
    TaaOnImages(Extent extent, bool cpu) : Taa(extent, cpu, published), extent_(extent) {}

    TaaInputs still(Color color) const {
        return {std::vector<Color>(pixels(), color), std::vector<glm::dvec2>(pixels(), glm::dvec2(0)),
                std::vector<float>(pixels(), 0.01f)};
    }

    // The node's result; lit() is what it was made of.
    std::vector<Color> frame(const TaaInputs& in, bool reset, glm::dvec2 jitter = glm::dvec2(0)) {
        std::vector<glm::dvec3> motion;
        for (const glm::dvec2& m : in.motion) motion.emplace_back(m, 0);
        const Camera camera = camera_at({0, 0, 0}, 0, extent_);
        FrameDescription description = frame_between(camera, camera, extent_, index_++, reset);
        description.jitter = {jitter.x / extent_.width, jitter.y / extent_.height};
        return Taa::frame(in.color, motion, in.depth, description);
    }

  private:
    Extent extent_;
    uint32_t index_ = 0;
};

Color compress(const Color& c) {
    return c / (1.0 + c);
}
Color expand(const Color& c) {
    return c / glm::max(1.0 - c, 1e-5);
}

// The published form for finite colours in the range of fp16.
class TaaModel {
  public:
    TaaModel(Extent extent, const std::vector<Color>& lit, const std::vector<float>& view_depth,
             const std::vector<glm::dvec2>& motion, const std::vector<Color>& history)
        : size_(extent.width, extent.height),
          lit_(lit),
          view_depth_(view_depth),
          motion_(motion),
          history_(history) {}

    // Compressed, as blended.
    Color pixel(glm::ivec2 p) const {
        const Color now = compress(at(lit_, p));
        const glm::dvec2 v = nearest_motion(p);
        const glm::dvec2 uv = (glm::dvec2(p) + 0.5) / glm::dvec2(size_) + v;
        if (!(uv.x > 0 && uv.y > 0 && uv.x < 1 && uv.y < 1)) return now;
        const double t = std::clamp(glm::length(v) / 0.02, 0.0, 1.0);
        const double scale = 2.5 + (0.5 - 2.5) * t * t * (3 - 2 * t);
        Color sum(0), squares(0);
        double weights = 0;
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                const double w = std::exp(-3.0 * (dx * dx + dy * dy) / 4);
                const Color c = compress(at(lit_, p + glm::ivec2(dx, dy)));
                sum += w * c;
                squares += w * c * c;
                weights += w;
            }
        const Color mean = sum / weights,
                    box = scale * glm::sqrt(glm::max(squares / weights - mean * mean, Color(0)));
        return glm::mix(glm::clamp(compress(glm::max(catmull_rom(uv * glm::dvec2(size_)), Color(0))),
                                   mean - box, mean + box),
                        now, 1.0 / 16);
    }

    // Whether rounding decides if the previous position is on the screen: nothing to compare.
    bool near_border(glm::ivec2 p) const {
        const glm::dvec2 uv = (glm::dvec2(p) + 0.5) / glm::dvec2(size_) + nearest_motion(p);
        return glm::any(glm::lessThan(glm::min(glm::abs(uv), glm::abs(uv - 1.0)), glm::dvec2(1e-5)));
    }

    // Largest difference between the texels of the history that the pixel's result is made of.
    double history_contrast(glm::ivec2 p) const {
        const glm::dvec2 texel = glm::dvec2(p) + 0.5 + nearest_motion(p) * glm::dvec2(size_);
        const glm::ivec2 base(glm::floor(texel - 0.5));
        Color low(1e30), high(-1e30);
        for (int i = 0; i < 16; ++i) {
            const Color& c = at(history_, base + glm::ivec2(i % 4 - 1, i / 4 - 1));
            low = glm::min(low, c);
            high = glm::max(high, c);
        }
        return glm::max(high.x - low.x, glm::max(high.y - low.y, high.z - low.z));
    }

  private:
    const Color& at(const std::vector<Color>& image, glm::ivec2 p) const {
        p = glm::clamp(p, glm::ivec2(0), size_ - 1);
        return image[static_cast<size_t>(p.y) * size_.x + p.x];
    }
    glm::dvec2 nearest_motion(glm::ivec2 p) const {
        glm::ivec2 nearest = p;
        float z = 1e30f;
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                const glm::ivec2 q = p + glm::ivec2(dx, dy);
                if (q != glm::clamp(q, glm::ivec2(0), size_ - 1)) continue;
                const float z_q = view_depth_[static_cast<size_t>(q.y) * size_.x + q.x];
                if (z_q > 0 && z_q < z) {
                    z = z_q;
                    nearest = q;
                }
            }
        return motion_[static_cast<size_t>(nearest.y) * size_.x + nearest.x];
    }
    // Cardinal cubic with tension 1/2 over 4x4 texels, one by one.
    Color catmull_rom(const glm::dvec2& texel) const {
        const glm::dvec2 base = glm::floor(texel - 0.5);
        const auto weights = [](double f) {
            return std::array<double, 4>{((-0.5 * f + 1) * f - 0.5) * f, (1.5 * f - 2.5) * f * f + 1,
                                         ((-1.5 * f + 2) * f + 0.5) * f, (0.5 * f - 0.5) * f * f};
        };
        const auto wx = weights(texel.x - 0.5 - base.x), wy = weights(texel.y - 0.5 - base.y);
        Color sum(0);
        for (int y = 0; y < 4; ++y)
            for (int x = 0; x < 4; ++x)
                sum += wx[static_cast<size_t>(x)] * wy[static_cast<size_t>(y)] *
                       at(history_, glm::ivec2(base) + glm::ivec2(x - 1, y - 1));
        return sum;
    }

    glm::ivec2 size_;
    const std::vector<Color>& lit_;
    const std::vector<float>& view_depth_;
    const std::vector<glm::dvec2>& motion_;
    const std::vector<Color>& history_;
};

double van_der_corput(uint32_t i, uint32_t base) {
    double value = 0, digit = 1;
    for (; i; i /= base) {
        digit /= base;
        value += digit * (i % base);
    }
    return value;
}
glm::dvec2 jitter_of(uint32_t frame) {
    return {van_der_corput(frame % 16 + 1, 2) - 0.5, van_der_corput(frame % 16 + 1, 3) - 0.5};
}

class TaaTest : public GpuTest, public ::testing::WithParamInterface<bool> {};

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN(),
                 infinity = std::numeric_limits<double>::infinity();

// Tolerances: a store rounds by one fp16 step either way; before it, in compressed space, single precision
// and the deviation's root of a difference of squares leave some 1e-5. A sampler that rounds its coordinate
// moves a tap by that part of the contrast, on two axes, under weights whose sum of magnitudes is 1.3 at
// most.
TEST_P(TaaTest, IsThePublishedForm) {
    for (const Extent extent : {Extent{67, 45}, Extent{17, 1}, Extent{203, 117}}) {
        SCOPED_TRACE(testing::Message() << extent.width << "x" << extent.height);
        TaaOnImages taa(extent, GetParam());
        std::mt19937 random(extent.width);
        std::uniform_real_distribution<double> uniform(0, 1);
        std::vector<Color> history;
        size_t differ = 0, compared = 0, thresholds = 0;
        std::string first;
        double worst = 0;
        for (uint32_t index = 0; index < 6; ++index) {
            TaaInputs in = taa.still({0, 0, 0});
            for (size_t i = 0; i < taa.pixels(); ++i) {
                // In 3x3 pixels there is always contrast; between frames most of the image stays, so that the
                // box cuts some.
                const double base =
                    0.3 + 0.2 * static_cast<double>((i % extent.width + i / extent.width) % 3);
                in.color[i] = Color(base * (1 + 0.4 * uniform(random)), base * (0.5 + uniform(random)),
                                    uniform(random) < 0.02 ? 9.0 : base);
                if (uniform(random) < 0.7)
                    in.motion[i] = glm::dvec2(uniform(random) - 0.5, uniform(random) - 0.5) *
                                   (uniform(random) < 0.1 ? 1.5 : 0.05);
                in.motion[i] = {from_half(to_half4({in.motion[i].x, 0, 0, 0})[0]),
                                from_half(to_half4({in.motion[i].y, 0, 0, 0})[0])};
                in.depth[i] =
                    uniform(random) < 0.05 ? 0.0f : static_cast<float>(0.05 / (3 + uniform(random)));
            }
            const std::vector<Color> out = taa.frame(in, index == 0), lit = taa.lit();
            const std::vector<float> depth = taa.view_depth();
            const TaaModel model(extent, lit, depth, in.motion, history);
            for (size_t i = 0; index > 0 && i < out.size(); ++i) {
                const glm::ivec2 p(i % extent.width, i / extent.width);
                if (model.near_border(p)) {
                    ++thresholds;
                    continue;
                }
                const Color wanted = expand(model.pixel(p));
                const double sampler =
                    gpu().info().is_cpu ? 0 : 2 * 1.3 * 1.3 * sampler_error_px() * model.history_contrast(p);
                for (int c = 0; c < 3; ++c) {
                    const double tolerance =
                        half_ulp(wanted[c]) + (3e-5 + sampler) * (1 + wanted[c]) * (1 + wanted[c]);
                    ++compared;
                    worst = std::max(worst, std::abs(out[i][c] - wanted[c]) / tolerance);
                    if (!(std::abs(out[i][c] - wanted[c]) <= tolerance) && differ++ == 0)
                        first = (testing::Message()
                                 << "frame " << index << " pixel " << p.x << ", " << p.y << " channel " << c
                                 << ": " << out[i][c] << " for " << wanted[c] << ", lit " << lit[i][c])
                                    .GetString();
                }
            }
            history = out;
        }
        EXPECT_EQ(differ, 0u) << "of " << compared << "; the first: " << first;
        EXPECT_LE(thresholds, 2 + compared / 3000);
        RecordProperty("worst", std::to_string(worst));
    }
}

TEST_P(TaaTest, PassesAResetThrough) {
    const Extent extent{67, 45};
    TaaOnImages taa(extent, GetParam());
    TaaInputs in = taa.still({5, 5, 5});
    for (int frame = 0; frame < 3; ++frame) taa.frame(in, frame == 0);  // a history that must not show
    std::mt19937 random(1);
    for (Color& c : in.color)
        c = {static_cast<double>(random() % 100) / 400, static_cast<double>(random() % 100) / 7, 0};
    const std::vector<Color> out = taa.frame(in, true), lit = taa.lit();
    for (size_t i = 0; i < out.size(); ++i)
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(out[i][c], lit[i][c], half_ulp(lit[i][c])) << i;
}

TEST_P(TaaTest, AStillConstantImageIsAFixedPoint) {
    TaaOnImages taa({40, 24}, GetParam());
    for (const Color color : {Color(0.18, 0.5, 0.9), Color(0), Color(7, 30, 0.001)}) {
        const TaaInputs in = taa.still(color);
        taa.frame(in, true);
        const std::vector<Color> lit = taa.lit();
        for (uint32_t frame = 0; frame < 40; ++frame) {
            const std::vector<Color> out = taa.frame(in, false, jitter_of(frame));
            for (size_t i = 0; i < out.size(); ++i)
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(out[i][c], lit[i][c], half_ulp(lit[i][c]))
                        << "frame " << frame << " pixel " << i;
        }
    }
}

TEST_P(TaaTest, StaysFiniteWhateverComesIn) {
    TaaOnImages taa({67, 45}, GetParam());
    std::mt19937 random(5);
    const auto one_of = [&](std::initializer_list<double> values) {
        return values.begin()[random() % values.size()];
    };
    for (uint32_t frame = 0; frame < 12; ++frame) {
        TaaInputs in = taa.still({0, 0, 0});
        for (size_t i = 0; i < taa.pixels(); ++i) {
            for (int c = 0; c < 3; ++c)
                in.color[i][c] = one_of({0, 1e-7, 0.5, 1, 65504, 65504, 32768, infinity, -1, nan_value});
            in.motion[i] = {one_of({0, 0.01, -0.01, 65504, nan_value, infinity, -infinity}),
                            one_of({0, 0.003, nan_value, infinity})};
            in.depth[i] = static_cast<float>(one_of({0.01, 0.02, 0, nan_value, infinity, 1}));
        }
        const std::vector<Color> out = taa.frame(in, frame == 0 || frame == 7);
        for (size_t i = 0; i < out.size(); ++i)
            for (int c = 0; c < 3; ++c)
                ASSERT_TRUE(out[i][c] >= 0 && out[i][c] <= 65504)
                    << out[i][c] << " in frame " << frame << ", pixel " << i;
    }
    // and one good frame later, what was bad is no longer to be seen
    const TaaInputs good = taa.still({0.25, 0.5, 0.75});
    taa.frame(good, false);
    for (const Color& c : taa.frame(good, false)) ASSERT_LT(glm::length(c - Color(0.25, 0.5, 0.75)), 0.01);
}

TEST_P(TaaTest, RejectsHistoryFromOutsideTheScreen) {
    const Extent extent{64, 32};
    TaaOnImages taa(extent, GetParam());
    std::mt19937 random(3);
    const auto noise = [&] {
        TaaInputs in = taa.still({0, 0, 0});
        for (Color& c : in.color) c = Color(static_cast<double>(random() % 1024) / 1024);
        return in;
    };
    for (const glm::dvec2 motion : {glm::dvec2(0.25, 0), glm::dvec2(-0.25, 0), glm::dvec2(0, 0.5),
                                    glm::dvec2(0, -0.5), glm::dvec2(nan_value, 0), glm::dvec2(0, nan_value),
                                    glm::dvec2(infinity, 0), glm::dvec2(0, -infinity)}) {
        taa.frame(noise(), true);
        TaaInputs in = noise();
        std::fill(in.motion.begin(), in.motion.end(), motion);
        const std::vector<Color> out = taa.frame(in, false), lit = taa.lit();
        size_t outside = 0, kept = 0, pixels_inside = 0;
        for (size_t i = 0; i < out.size(); ++i) {
            const glm::dvec2 uv = (glm::dvec2(i % extent.width, i / extent.width) + 0.5) /
                                      glm::dvec2(extent.width, extent.height) +
                                  motion;
            const bool inside = uv.x > 0 && uv.y > 0 && uv.x < 1 && uv.y < 1;
            const bool same = std::abs(out[i].x - lit[i].x) <= half_ulp(lit[i].x);
            pixels_inside += inside;
            kept += inside && !same;
            if (inside) continue;
            ++outside;
            ASSERT_TRUE(same) << "pixel " << i << " motion " << motion.x << ", " << motion.y;
        }
        EXPECT_GT(outside, out.size() / 5);
        EXPECT_GE(kept, pixels_inside * 3 / 4) << "history inside the screen is used";
    }
}

// An edge under 16 jitter positions, one sample a frame. The exponential average weighs the latest seven of
// the sixteen frames above their share, by .127 in all; over whole periods the weights are equal. What
// remains is the error of the 16 points themselves, which is counted here, and a few steps of fp16 of a
// history that is stored in every frame.
TEST_P(TaaTest, AnEdgeUnderJitterBecomesItsArea) {
    const Extent extent{48, 32};
    TaaOnImages taa(extent, GetParam());
    const glm::dvec2 across = glm::normalize(glm::dvec2(1, 0.37));
    const double offset = glm::dot(across, glm::dvec2(24, 16));
    const Color dark(0.05), bright(0.8);
    const auto lit_at = [&](glm::dvec2 point) { return glm::dot(across, point) > offset; };
    const uint32_t settled = 160;
    std::vector<double> mean(taa.pixels(), 0), fp16_steps(taa.pixels(), 0);
    std::vector<double> points(taa.pixels(), 0), area(taa.pixels(), 0);
    for (size_t i = 0; i < taa.pixels(); ++i) {
        const glm::dvec2 centre(static_cast<double>(i % extent.width) + 0.5,
                                static_cast<double>(i / extent.width) + 0.5);
        for (uint32_t f = 0; f < 16; ++f) points[i] += lit_at(centre + jitter_of(f)) / 16.0;
        for (int s = 0; s < 4096; ++s)
            area[i] += lit_at(centre + glm::dvec2((s % 64 + 0.5) / 64, (s / 64 + 0.5) / 64) - 0.5) / 4096.0;
    }
    double worst_frame = 0;
    for (uint32_t frame = 0; frame < settled + 16; ++frame) {
        TaaInputs in = taa.still(dark);
        for (size_t i = 0; i < taa.pixels(); ++i)
            if (lit_at(glm::dvec2(i % extent.width, i / extent.width) + 0.5 + jitter_of(frame)))
                in.color[i] = bright;
        const std::vector<Color> out = taa.frame(in, frame == 0, jitter_of(frame));
        if (frame < settled) continue;
        for (size_t i = 0; i < out.size(); ++i) {
            // Averages are taken after c / (1 + c).
            const double coverage =
                (compress(out[i]).x - compress(dark).x) / (compress(bright).x - compress(dark).x);
            mean[i] += coverage / 16;
            const double error = std::abs(coverage - area[i]);
            worst_frame = std::max(worst_frame, error);
            ASSERT_LE(error, 0.127 + std::abs(points[i] - area[i]) + 0.01)
                << "frame " << frame << " pixel " << i;
        }
    }
    double worst_mean = 0;
    size_t partly = 0;
    for (size_t i = 0; i < mean.size(); ++i) {
        partly += area[i] > 0.1 && area[i] < 0.9;
        worst_mean = std::max(worst_mean, std::abs(mean[i] - points[i]));
        ASSERT_NEAR(mean[i], points[i], 0.01) << i;
    }
    EXPECT_GT(partly, 20u);
    RecordProperty("worst_frame", std::to_string(worst_frame));
    RecordProperty("worst_mean", std::to_string(worst_mean));
}

INSTANTIATE_TEST_SUITE_P(Shapes, TaaTest, ::testing::Bool(),
                         [](const auto& test) { return std::string(test.param ? "Cpu" : "Gpu"); });

}  // namespace
}  // namespace penumbra::test
