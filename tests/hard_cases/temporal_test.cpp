// SPDX-License-Identifier: MIT
// Hard cases 36 to 51 and 55: what a history does in the long run, after a jump, under broken input, in small
// formats. The naive forms are the published denoiser (fidelityfx.json) or a few lines of arithmetic on the
// same samples.
#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <limits>
#include <random>
#include <set>

#include "host/truth/analytic.h"
#include "tests/hard_cases/hard_cases.h"
#include "tests/shipped.h"
#include "tests/test_scene.h"

namespace penumbra::test {
namespace {

// ---- 36, 37: the light or what stands in it jumps

struct Jump {
    uint32_t k90 = 0;        // frames after the jump until nine tenths of the difference are gone for good
    uint32_t k90_naive = 0;  // of an exponential average of weight 1/20 over the same rays
};

Jump jump(const Shot& shot, uint32_t at, uint32_t frames) {
    const std::vector<float> before = truth_of(shot, at - 1, 64).visibility,
                             after = truth_of(shot, at, 64).visibility;
    ShotRun run("shadows_fast", shot), rays("raw", shot);
    std::vector<float> average;
    double whole = 0;
    for (size_t i = 0; i < before.size(); ++i) whole += std::abs(before[i] - after[i]) > 0.5f;
    EXPECT_GT(whole, 200);
    Jump result;
    for (uint32_t frame = 0; frame < frames; ++frame) {
        const std::vector<float> v = run.frame(frame, frame == 0), bits = rays.frame(frame, frame == 0);
        if (average.empty()) average = bits;
        double left = 0, left_naive = 0;
        for (size_t i = 0; i < v.size(); ++i) {
            average[i] += 0.05f * (bits[i] - average[i]);
            if (!(std::abs(before[i] - after[i]) > 0.5f)) continue;
            left += std::abs(v[i] - after[i]);
            left_naive += std::abs(average[i] - after[i]);
        }
        if (frame < at) continue;
        if (left > 0.1 * whole) result.k90 = frame - at + 1;
        if (left_naive > 0.1 * whole) result.k90_naive = frame - at + 1;
    }
    return result;
}

Shot still_plaza() {
    Shot shot = plaza_shot({160, 96}, 64);
    shot.camera.resize(1);
    shot.sun.resize(1);
    shot.objects.clear();
    return shot;
}

TEST_F(HardCase, AJumpOfTheSunIsFollowedAtOnce) {
    Shot shot = still_plaza();
    shot.sun = {{0, {0.4, 0.8, 0.2}}, {11, {0.4, 0.8, 0.2}}, {12, {-0.1, 0.8, 0.3}}};  // 32 degrees
    const Jump found = jump(shot, 12, 20);
    figure("case 36, frames until a jump of the sun is followed", found.k90_naive, found.k90);
    EXPECT_LE(found.k90,
              2u);  // 3 where the noise of the new samples alone has to tell (inputs.sun_prev=null)
    EXPECT_GT(found.k90_naive, 2u);
}

TEST_F(HardCase, AJumpOfACasterIsFollowedAtOnce) {
    Shot shot = still_plaza();
    shot.objects["block"].keys = {{11, {0, 0, 0}, {0, 0, 0}}, {12, {1.5, 0.3, 0.8}, {0, 30, 0}}};
    const Jump found = jump(shot, 12, 20);
    figure("case 37, frames until a jump of a caster is followed", found.k90_naive, found.k90);
    EXPECT_LE(found.k90, 2u);
    EXPECT_GT(found.k90_naive, 2u);
}

// ---- 40, 42: arithmetic of an average (41 and the long run of 42: soak_test.cpp)

// A wall whose every block holds one pixel that stays dark, so that no block is skipped; the others are dark
// for 8 frames, and lit from then on.
TEST_F(HardCase, AnAverageInHalfFloatsReachesItsEnd) {
    const Extent extent{64, 32};
    const Camera camera = camera_at({0, 0, 0}, 0, extent);
    DenoiseRun run(shipped_pipeline("denoise"), extent, {"state"});
    const PlaneImages wall = see_plane({{0, 0, -5}, {0, 0, 1}}, camera, camera, extent);
    const auto stays_dark = [](uint32_t x, uint32_t y) { return x % 8 == 3 && y % 8 == 5; };
    float naive = 0;
    for (uint32_t f = 0; f < 264; ++f) {
        const auto words =
            hit_words(extent, [&](uint32_t x, uint32_t y) { return f >= 8 && !stays_dark(x, y); });
        run.frame(wall, words, frame_between(camera, camera, extent, f, f == 0));
        if (f >= 8) naive = glm::unpackHalf1x16(glm::packHalf1x16(naive + (1 - naive) / 20));
    }
    const std::vector<float> v = run.kept_visibility();
    double ours = 0;
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x)
            if (!stays_dark(x, y)) ours = std::max(ours, std::abs(double(v[y * extent.width + x]) - 1));
    figure("case 40, distance from 1 after 256 lit frames", 1 - naive, ours);
    EXPECT_LE(ours, 1.0 / 1024);
    EXPECT_GT(1 - naive, 4.0 / 1024);
}

// The frame's number wraps round after two years at 60 Hz.
TEST_F(HardCase, TheFrameNumberMayWrap) {
    const Extent extent{64, 32};
    const Camera camera = camera_at({0, 0, 0}, 0, extent);
    const PlaneImages wall = see_plane({{0, 0, -5}, {0, 0, 1}}, camera, camera, extent);
    const auto counts_after = [&](uint32_t first) {
        DenoiseRun run(denoiser(), extent, {"state"});
        std::mt19937 random(42);
        for (uint32_t f = 0; f < 12; ++f) {
            const auto words = hit_words(extent, [&](uint32_t, uint32_t) { return (random() & 1) != 0; });
            run.frame(wall, words, frame_between(camera, camera, extent, first + f, f == 0));
            EXPECT_EQ(nonfinite(run.plane("visibility")), 0u);
        }
        double sum = 0;
        for (const float c : run.kept_frames()) sum += c;
        return sum / (extent.width * extent.height);
    };
    const double wrapped = counts_after(0xFFFFFFFAu), plain = counts_after(0);
    figure("case 42, frames that a history has after 12 of them, without a wrap (naive) and with one", plain,
           wrapped);
    EXPECT_NEAR(wrapped, plain, 0.2);  // rounding is random, and depends on the frame's number
    EXPECT_GT(plain, 6);
}

// ---- 43: every direction of an edge

TEST_F(HardCase, NoDirectionOfAnEdgeIsWorseThanOthers) {
    const auto spread = [](const RunOptions& options) {
        double low = 1e30, high = 0;
        for (const double angle : {0.0, 22.5, 45.0, 67.5, 90.0, 112.5, 135.0, 157.5}) {
            const Shot shot = edge_shot(16, angle, {96, 96}, 32);
            // The rays alone: what a denoiser gets to average.
            const double n =
                n_eff(ShotRun("raw", shot, options).mean(32), analytic_truth(shot, 0).visibility);
            low = std::min(low, n);
            high = std::max(high, n);
        }
        return high / low;
    };
    const double naive = spread({.settings = {"nodes.trace.params.sampling=published"}}), ours = spread({});
    figure("case 43, best over worst direction of an edge, N_eff of 32 frames", naive, ours);
    EXPECT_LT(ours, 1.3);
    EXPECT_GT(naive, 4);
}

// ---- 44: the tile of noise repeats

using Lag = std::array<int, 2>;

// Correlation of the noise of pixels `lag` apart.
double correlation(const std::vector<float>& noise, const Shot& shot, const Lag& lag) {
    const int width = int(shot.size[0]), height = int(shot.size[1]);
    double both = 0, one = 0, other = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const int u = x + lag[0], v = y + lag[1];
            if (u < 0 || v < 0 || u >= width || v >= height) continue;
            const double a = noise[size_t(y * width + x)], b = noise[size_t(v * width + u)];
            both += a * b;
            one += a * a;
            other += b * b;
        }
    return both / std::sqrt(one * other);
}

// The correlation 128 px away along the edge, and its root mean square at other distances.
struct Repetition {
    double at_tile = 0, elsewhere = 0;
};

Repetition repetition(const std::vector<float>& noise, const Shot& shot, const Lag& along) {
    const auto at = [&](int pixels) {
        return correlation(noise, shot, {along[0] * pixels, along[1] * pixels});
    };
    double squares = 0;
    int count = 0;
    for (int pixels = 80; pixels <= 176; pixels += 4) {
        if (std::abs(pixels - 128) <= 8) continue;
        squares += at(pixels) * at(pixels);
        ++count;
    }
    return {at(128), std::sqrt(squares / count)};
}

// The noise is the difference of two seeds: what bias a denoiser has is the same all along an edge, and would
// be taken for repetition at every distance. The naive form takes the tile as it is.
TEST_F(HardCase, TheNoiseTileDoesNotRepeat) {
    struct Case {
        const char* name;
        double edge_deg;
        std::array<uint32_t, 2> size;
        Lag along;
    };
    for (const Case& c : {Case{"x", 90, {384, 96}, {1, 0}}, Case{"y", 0, {96, 384}, {0, 1}},
                          Case{"diagonal", 45, {288, 288}, {1, -1}}}) {
        SCOPED_TRACE(c.name);
        const Shot shot = edge_shot(200, c.edge_deg, c.size, 16);
        const std::vector<float> truth = analytic_truth(shot, 0).visibility;
        const auto judge = [&](const char* pipeline, const RunOptions& options = {}) {
            std::array<std::vector<float>, 2> noise;
            ShotRun run(pipeline, shot, options);
            for (const uint32_t seed : {0u, 1u}) {
                run.session().set_param("seed", seed);
                for (uint32_t frame = 0; frame < 16; ++frame) {
                    const std::vector<float> image = run.frame(frame, frame == 0);
                    if (frame != 0 && frame != 15) continue;
                    std::vector<float>& n = noise[frame != 0];
                    n.resize(image.size());
                    for (size_t i = 0; i < n.size(); ++i) n[i] = image[i] - n[i];
                    if (pipeline == std::string_view("shadows_fast") && c.along[1] == 0 && seed == 0) {
                        EXPECT_LT(rms(image, truth), frame == 0 ? 1.0 / 32 : 1.0 / 128);
                        figure("case 44, error of shadows after frame", frame, rms(image, truth));
                    }
                }
            }
            std::array<Repetition, 2> found;
            for (const int last : {0, 1}) {
                found[last] = repetition(noise[last], shot, c.along);
                figure(("case 44, " + std::string(options.settings.empty() ? pipeline : "tile as it is") +
                        ", " + c.name + ", frames: " + (last ? "16" : "1") +
                        ": correlation at other distances (naive), 128 px apart (ours)")
                           .c_str(),
                       found[last].elsewhere, found[last].at_tile);
            }
            return found;
        };
        for (const Repetition& r : judge("raw", {.settings = {"nodes.trace.params.sampling=published"}}))
            EXPECT_GT(r.at_tile, 0.9);
        for (const char* pipeline : {"raw", "shadows_fast"})
            for (const Repetition& r : judge(pipeline))
                EXPECT_LT(std::abs(r.at_tile), 3 * r.elsewhere) << pipeline;
    }
}

// ---- 45, 47: broken input

TEST_F(HardCase, MotionThatIsNoMotionIsNoHistory) {
    const Extent extent{64, 32};
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    const std::vector<std::array<float, 2>> broken = {{nan, 0},  {0, nan},        {inf, 0},   {0, -inf},
                                                      {1e6f, 0}, {-1e30f, 1e30f}, {nan, inf}, {2, 0}};
    const Camera camera = camera_at({0, 0, 0}, 0, extent);
    DenoiseRun run(denoiser(), extent, {"state"});
    std::mt19937 random(45);
    std::vector<uint32_t> last;
    for (uint32_t f = 0; f < 12; ++f) {
        PlaneImages wall = see_plane({{0, 0, -5}, {0, 0, 1}}, camera, camera, extent);
        if (f == 11)
            for (size_t i = 0; i < wall.motion.size(); ++i)
                wall.motion[i] =
                    i % 16 < broken.size() ? broken[i % 16] : std::array{1e-40f, -1e-42f};  // no motion
        last = hit_words(extent, [&](uint32_t, uint32_t) { return (random() & 1) != 0; });
        run.frame(wall, last, frame_between(camera, camera, extent, f, f == 0));
    }
    const std::vector<float> count = run.kept_frames(), v = run.plane("visibility");
    size_t kept = 0, lost = 0, of_broken = 0;
    for (size_t i = 0; i < count.size(); ++i) {
        const bool one = count[i] < 1.5f;
        if (i % 16 < broken.size()) {
            ++of_broken;
            kept += !one;
        } else {
            lost += one;
        }
    }
    // A clamp to the image, as it is often written: min and max drop a NaN on one side or the other.
    size_t naive = 0;
    for (const auto& m : broken) naive += std::isfinite(std::fmin(std::fmax(0.5f + m[0], 0.0f), 1.0f));
    figure("case 45, share of broken motions that find a history", double(naive) / double(broken.size()),
           double(kept) / double(of_broken));
    EXPECT_EQ(kept, 0u);
    EXPECT_EQ(lost, 0u);
    EXPECT_EQ(nonfinite(v), 0u);
}

TEST_F(HardCase, OneBrokenPixelStaysOnePixel) {
    const Extent extent{96, 64};
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const uint32_t centre = 32 * 96 + 48;
    const Camera camera = camera_at({0, 0, 0}, 0, extent);
    for (const int what : {0, 1, 2}) {
        DenoiseRun harmed(denoiser(), extent, {"state"}), unharmed(denoiser(), extent, {"state"});
        std::mt19937 random(47);
        for (uint32_t f = 0; f < 10; ++f) {
            const PlaneImages wall = see_plane({{0, 0, -5}, {0, 0, 1}}, camera, camera, extent);
            PlaneImages broken = wall;
            if (f == 6 && what == 0) broken.depth[centre] = nan;
            if (f == 6 && what == 1) broken.normal[centre] = to_half4({nan, nan, nan, 0});
            if (f == 6 && what == 2) broken.motion[centre] = {nan, nan};
            const auto words = hit_words(extent, [&](uint32_t x, uint32_t) { return random() % 96 >= x; });
            harmed.frame(broken, words, frame_between(camera, camera, extent, f, f == 0));
            unharmed.frame(wall, words, frame_between(camera, camera, extent, f, f == 0));
            EXPECT_EQ(nonfinite(harmed.plane("visibility")), 0u) << what << ", frame " << f;
            if (f < 7) continue;
            // What a frame keeps for the next differs where it was harmed and, by what is forgotten around
            // it, in its block.
            const std::vector<float> a = harmed.kept_visibility(), b = unharmed.kept_visibility();
            for (uint32_t i = 0; i < a.size(); ++i) {
                const int dx = std::abs(int(i % 96) - 48), dy = std::abs(int(i / 96) - 32);
                ASSERT_TRUE(a[i] == b[i] || (dx <= 24 && dy <= 24))
                    << what << ", frame " << f << ", " << dx << ", " << dy;
            }
        }
    }
}

// ---- 49: one pixel lit, the next one dark

TEST_F(HardCase, ACheckerboardOfPixelsStaysOne) {
    const Extent extent{64, 48};
    const Camera camera = camera_at({0, 0, 0}, 0, extent);
    const PlaneImages wall = see_plane({{0, 0, -5}, {0, 0, 1}}, camera, camera, extent);
    const auto words = hit_words(extent, [](uint32_t x, uint32_t y) { return (x + y) % 2 == 0; });
    const auto error = [&](const CheckedPipeline& pipeline) {
        DenoiseRun run(pipeline, extent, {});
        for (uint32_t f = 0; f < 32; ++f)
            run.frame(wall, words, frame_between(camera, camera, extent, f, f == 0));
        const std::vector<float> v = run.plane("visibility");
        double worst = 0;
        for (uint32_t i = 0; i < v.size(); ++i)
            worst = std::max(worst, std::abs(double(v[i]) - ((i % 64 + i / 64) % 2 == 0 ? 1 : 0)));
        return worst;
    };
    const double naive = error(published_denoiser()), ours = error(denoiser());
    figure("case 49, largest error of a checkerboard of pixels after 32 frames", naive, ours);
    EXPECT_LT(ours, 0.05);
    EXPECT_GT(naive, 0.05);
}

// ---- 51: a slow pan

TEST_F(HardCase, ASlowPanBlursNoHistory) {
    // A sheet beside the view whose penumbra, 16 pixels wide, falls into its middle; the camera looks
    // straight down.
    const double height = 3, sheet = 0.8, pixel = 2 * height * std::tan(glm::radians(20.0)) / 96;
    Shot shot = scene_shot(
        "pan", {{"floor", ground(6, 6, 4, 4)}, {"sheet", box({1.2, sheet, -5}, {4, sheet + 0.01, 5})}},
        {128, 96});
    shot.vertical_fov_deg = 40;
    shot.sun = {{0, {1.5, 1, 0}}};
    shot.sun_angular_radius_deg =
        glm::degrees(std::atan(0.5 * 16 * pixel / sheet / (1 + 1.5 * 1.5) * std::sqrt(1 + 1.5 * 1.5)));
    const auto score = [&](const char* pipeline, double px_per_frame) {
        Shot panned = shot;
        const glm::dvec3 from(-0.3, height, 0), step(px_per_frame * pixel, 0, px_per_frame * pixel);
        panned.camera = {{0, from, from - glm::dvec3(0, 1, 0), {0, 0, -1}},
                         {31, from + 31.0 * step, from + 31.0 * step - glm::dvec3(0, 1, 0), {0, 0, -1}}};
        const std::vector<float> truth = truth_of(panned, 31, 1024).visibility;
        ShotRun run(pipeline, panned, {.captures = {"view_depth"}, .facts = {{"moves", true}}});
        const std::vector<float> image = run.up_to(31), z = run.plane("view_depth");
        const auto on_floor = [&](size_t i) { return std::abs(z[i] - height) < 0.01 && i % 128 < 96; };
        return n_eff(image, truth, on_floor);
    };
    const double still = score("shadows_fast", 0), slow = score("shadows_fast", 0.5),
                 whole = score("shadows_fast", 1);
    const double naive_still = score("fidelityfx", 0), naive_slow = score("fidelityfx", 0.5);
    figure("case 51, N_eff still", naive_still, still);
    figure("case 51, N_eff at one pixel a frame", NAN, whole);
    figure("case 51, N_eff at half a pixel a frame", naive_slow, slow);
    figure("case 51, N_eff at half a pixel over still", naive_slow / naive_still, slow / still);
    EXPECT_GT(slow, 0.7 * still);
    EXPECT_GT(whole, 100);
    EXPECT_LT(naive_slow, 100);
}

// ---- 55: a fence of a third of a pixel under jitter

TEST_F(HardCase, AFenceThinnerThanAPixelDoesNotFlicker) {
    std::vector<Placed> shapes = {{"floor", ground(8, 8, 4, 4)}};
    Shape fence;
    for (int i = -12; i <= 12; ++i)
        fence.append(box({i * 0.2 - 0.005, 0, -0.005}, {i * 0.2 + 0.005, 1.2, 0.005}));
    shapes.push_back({"fence", fence});
    Shot shot = scene_shot("fence", shapes, {192, 108});
    const auto flicker = [&](const char* pipeline, bool jitter, bool moves) {
        ShotRun run(pipeline, shot, {.captures = {"color"}, .facts = {{"moves", moves}}, .jitter = jitter});
        std::vector<float> last;
        double squares = 0;
        for (uint32_t frame = 0; frame < 48; ++frame) {
            run.frame(frame, frame == 0);
            const std::vector<float> color = run.plane("color");
            if (frame > 31) squares += rms(color, last) * rms(color, last) / 16;
            last = color;
        }
        return std::sqrt(squares);
    };
    // Where nothing moves, `taa` doubts no pixel's past for having shown a bar, or none; where it may, only
    // one that had no part of what is seen now on either side. (Rays' pasts are those of what may move under
    // jitter.)
    const double naive = flicker("fidelityfx", true, false), ours = flicker("hybrid_shadows", true, false);
    figure("case 55, flicker of the colour under jitter, still scene", naive, ours);
    const double naive_moves = flicker("fidelityfx", true, true),
                 ours_moves = flicker("shadows_fast", true, true);
    figure("case 55, the same, a scene that may move", naive_moves, ours_moves);
    figure("case 55, the same without jitter", flicker("fidelityfx", false, true),
           flicker("shadows_fast", false, true));
    EXPECT_LT(ours, 0.75 * naive);
    EXPECT_LT(ours_moves, 0.75 * naive_moves);
}

}  // namespace
}  // namespace penumbra::test
