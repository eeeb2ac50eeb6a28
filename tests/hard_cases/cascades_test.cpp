// SPDX-License-Identifier: MIT
// Hard cases 23, 30 to 35 and 38: what a classifier may not lose. The naive form is the published classifier
// (Poisson taps of the same maps) or a few lines here; the measure is the rays that
// every pixel would have cast with the same noise, and the converged visibility.
#include <bit>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <utility>

#include "host/cascades/cascade_fit.h"
#include "tests/cascade_run.h"

namespace penumbra::test {
namespace {

// ---- scenes

Shot wires_from_close() {
    Shot shot = wires();
    shot.size = {320, 180};
    shot.camera = {{0, {-0.2, 0.9, 1.2}, {-0.4, 0, 0}, {0, 1, 0}}};
    return shot;
}

// A row of posts that runs through every slice of the view; the camera steps by a millimetre.
Shot posts() {
    std::vector<Placed> shapes{{"floor", ground(60, 60, 8, 8)}};
    for (int i = 0; i < 24; ++i)
        shapes.push_back({"post", box({-1.5 + 0.2 * (i % 3), 0, 2.0 - 1.8 * i},
                                      {-1.48 + 0.2 * (i % 3), 1.4, 2.02 - 1.8 * i})});
    Shot shot = shadow_shot("cascade_posts", shapes, {160, 90});
    shot.camera = {{0, {0.5, 1.6, 4}, {0, 1.0, 0}, {0, 1, 0}},
                   {5, {0.505, 1.6, 4}, {0.01, 1.0, 0}, {0, 1, 0}}};
    return shot;
}

// Half of the plate's shadow lies in view; the plate is 80 m up, behind the camera.
Shot overhead(bool plate) {
    const glm::dvec3 to_sun = glm::normalize(glm::dvec3(0.5, 0.8, 0.3)), under(-0.5, 0, 0);
    const glm::dvec3 at = under + to_sun * (80 / to_sun.y);
    std::vector<Placed> shapes{{"floor", ground(8, 8, 4, 4)}};
    if (plate)
        shapes.push_back({"plate", box(at - glm::dvec3(1.5, 0.1, 1.5), at + glm::dvec3(1.5, 0.1, 1.5))});
    return shadow_shot(plate ? "cascade_plate" : "cascade_no_plate", shapes, {160, 90});
}

// ---- what a classifier loses

struct Words {
    std::vector<uint32_t> undecided, hits, receivers;
    uint32_t tiles_x = 0, width = 0;

    bool has(const std::vector<uint32_t>& words, size_t pixel) const {
        const size_t x = pixel % width, y = pixel / width;
        return (words[y / 4 * tiles_x + x / 8] >> (y % 4 * 8 + x % 8) & 1u) != 0;
    }
};

Words words_of(const std::string& pipeline, const Shot& shot, RunOptions options) {
    options.captures = {"undecided_words", "preloaded_hits", "receiver_words"};
    ShotRun run(pipeline, shot, options);
    run.frame(0, true);
    const View& view = run.session().view();
    return {captured<uint32_t>(view, "undecided_words"), captured<uint32_t>(view, "preloaded_hits"),
            captured<uint32_t>(view, "receiver_words"), (shot.size[0] + 7) / 8, shot.size[0]};
}

struct Loss {
    double recall = 0;         // share of the penumbra that gets rays
    double misclassified = 0;  // MR(.05): share of the receivers whose verdict is wrong by more than that
};

Loss loss_of(const Words& words, const std::vector<float>& truth) {
    size_t penumbra = 0, traced = 0, wrong = 0, receivers = 0;
    for (size_t i = 0; i < truth.size(); ++i) {
        if (!words.has(words.receivers, i)) continue;
        ++receivers;
        const bool open = words.has(words.undecided, i);
        if (truth[i] > 0 && truth[i] < 1) {
            ++penumbra;
            traced += open;
        }
        const float verdict = words.has(words.hits, i) ? 0.0f : 1.0f;
        wrong += !open && std::abs(verdict - truth[i]) > 0.05f;
    }
    EXPECT_GT(penumbra, 100u);
    return {double(traced) / double(penumbra), double(wrong) / double(receivers)};
}

// ---- 23: a ray's interval, from its tile's blockers

TEST_F(HardCase, ATilesIntervalChangesNoRaysAnswer) {
    const std::string taps = "nodes.taps.params.use_interval=false",
                      ours_whole = "nodes.cascades.params.use_interval=false";
    size_t pixels = 0, naive = 0, ours = 0;
    for (const Shot& shot : {wires_from_close(), posts(), overhead(true)}) {
        const Frames published = frames_of(taps_raw, shot, maps_of(64), 2);
        for (const std::vector<float>& frame : published.visibility) pixels += frame.size();
        naive += differing(published, frames_of(taps_raw, shot, maps_of(64, {taps}), 2));
        ours += differing(frames_of(cascades_raw, shot, maps_of(64), 2),
                          frames_of(cascades_raw, shot, maps_of(64, {ours_whole}), 2));
    }
    const auto share = [&](size_t part) { return double(part) / double(pixels); };
    figure("case 23, share of pixels whose answer an interval changes", share(naive), share(ours));
    EXPECT_EQ(ours, 0u);
    EXPECT_GT(share(naive), 1e-4);
}

// ---- 30: a wire in a wide search disc; 31: a caster that no slice of the view holds

TEST_F(HardCase, AWireThinnerThanATexelGetsItsRays) {
    for (const auto& [size, radius_deg] : {std::pair{256u, 0.27}, {256u, 2.0}, {64u, 2.0}}) {
        Shot shot = wires_from_close();
        shot.sun_angular_radius_deg = radius_deg;
        const std::vector<float> truth = truth_of(shot, 0, 64).visibility;
        const Loss naive = loss_of(words_of(taps_raw, shot, maps_of(size)), truth),
                   ours = loss_of(words_of(cascades_raw, shot, maps_of(size)), truth);
        const std::string at =
            " of wires, maps of " + std::to_string(size) + ", sun's radius " + std::to_string(radius_deg);
        figure(("case 30, recall" + at).c_str(), naive.recall, ours.recall);
        figure(("case 30, MR(.05)" + at).c_str(), naive.misclassified, ours.misclassified);
        EXPECT_EQ(ours.recall, 1);
        EXPECT_EQ(ours.misclassified, 0);
        EXPECT_LT(naive.recall, 0.98);
        EXPECT_GT(naive.misclassified, 1e-4);
    }
}

TEST_F(HardCase, ACasterFarAboveAndBehindTheViewKeepsItsShadow) {
    const Shot shot = overhead(true);
    const std::vector<float> truth = truth_of(shot, 0, 64).visibility,
                             clipped = truth_of(overhead(false), 0, 64).visibility;
    const Words words = words_of(cascades_raw, shot, maps_of(256));
    const Loss ours = loss_of(words, truth);
    // A near plane before what the camera sees drops the plate, and with it every verdict in its shadow.
    size_t lost = 0, receivers = 0;
    for (size_t i = 0; i < truth.size(); ++i) {
        if (!words.has(words.receivers, i)) continue;
        ++receivers;
        lost += std::abs(truth[i] - clipped[i]) > 0.05f;
    }
    const double naive = double(lost) / double(receivers);
    figure("case 31, MR(.05) with a caster 80 m up", naive, ours.misclassified);
    EXPECT_LE(ours.misclassified, 1e-4);
    EXPECT_GE(ours.recall, 0.999);
    EXPECT_GT(naive, 0.05);
    EXPECT_EQ(differing(frames_of("raw", shot, {}, 1), frames_of(cascades_raw, shot, maps_of(256), 1)), 0u);
}

// ---- 32: borders between cascades, while the camera steps by a millimetre

TEST_F(HardCase, CascadeBordersAreNotSeenWhileTheCameraSteps) {
    const Shot shot = posts();
    const Frames rays = frames_of("raw", shot, {}, 6), proved = frames_of(cascades_raw, shot, maps_of(64), 6);
    const size_t naive = differing(rays, frames_of(taps_raw, shot, maps_of(64), 6)),
                 ours = differing(rays, proved);
    figure("case 32, pixels of 6 frames that differ from the rays'", double(naive), double(ours));
    EXPECT_EQ(ours, 0u);
    EXPECT_GT(naive, 20u);
    EXPECT_LT(proved.rays, rays.rays / 2) << "who proves nothing changes nothing";
}

// ---- 34, 35: where the maps lie

CascadeRequest request(const glm::dvec3& camera, double yaw) {
    CascadeRequest r;
    r.camera = camera_at({camera.x, camera.y, camera.z}, yaw, {160, 90});
    r.to_sun = glm::normalize(glm::dvec3(0.3, 0.8, 0.5));
    r.angular_radius = glm::radians(0.27);
    r.low = {-200, 0, -200};
    r.high = {200, 30, 200};
    return r;
}

TEST_F(HardCase, ASceneWithoutExtentHasFiniteMapsOrNone) {
    struct Box {
        glm::dvec3 low, high, to_sun;
    };
    const glm::dvec3 p(3, 1, -2), up(0, 1, 0), aside(1, 0, 0), none(INFINITY);
    const std::vector<Box> boxes = {
        {p, p, up},                              // a point
        {p, p + glm::dvec3(0, 7, 0), up},        // a line towards the sun, and across
        {p, p + glm::dvec3(0, 7, 0), aside},     //
        {p, p + glm::dvec3(9, 0, 9), up},        // a plane face on, and on edge
        {p, p + glm::dvec3(9, 0, 9), aside},     //
        {none, -none, up},                       // empty
        {glm::dvec3(NAN), glm::dvec3(NAN), up},  //
        {p, p + 1.0, glm::dvec3(0)},             // no sun
        {p, p + 1.0, glm::dvec3(NAN)},           //
        {p * 1e9, p * 1e9, up},                  // a point far away
    };
    size_t naive = 0, ours = 0;
    for (const Box& box : boxes) {
        // An orthographic matrix as it is usually written, about the box in the light's axes (case 26 is
        // theirs).
        const LightFrame light = light_frame(box.to_sun);
        const glm::dvec3 a = light.of(box.low), b = light.of(box.high);
        const glm::dvec3 scale = 1.0 / glm::abs(b - a), shift = -a * scale;
        bool good = true;
        for (int i = 0; i < 3; ++i) good = good && std::isfinite(scale[i]) && std::isfinite(shift[i]);
        naive += !good;

        CascadeRequest r = request({3, 1.7, 8}, 0.3);
        r.low = box.low;
        r.high = box.high;
        r.to_sun = box.to_sun;
        const CascadeFit fit = fit_cascades(r);
        const blocks::Cascades block = cascade_block(fit, {3, 1.7, 8});
        good = true;
        for (uint32_t i = 0; i < block.count; ++i)
            for (const auto& row : block.c[i].map.columns)
                for (const float value : row) good = good && std::isfinite(value);
        ours += !good;
    }
    figure("case 34, degenerate scenes of 10 whose map is not finite", double(naive), double(ours));
    EXPECT_EQ(ours, 0u);
    EXPECT_EQ(naive, boxes.size());
}

TEST_F(HardCase, TexelsStayInPlaceUnderAMovingCamera) {
    const glm::dvec3 start(3, 1.7, 8), point(1.2345, 0.4321, -7.3);
    const CascadeFit still = fit_cascades(request(start, 0.3));
    double naive = 0, ours = 0;
    for (int step = 1; step <= 200; ++step) {
        const glm::dvec3 moved = start + 0.001 * step * glm::dvec3(1, 0, -0.7);
        const CascadeFit fit = fit_cascades(request(moved, 0.3 + 0.002 * step));
        ASSERT_EQ(fit.count, still.count);
        for (uint32_t i = 0; i < fit.count; ++i) {
            ASSERT_EQ(fit.areas[i].texel_m, still.areas[i].texel_m);
            const glm::dvec3 change = texels_from_metres(fit, i, {}) * glm::dvec4(point, 1) -
                                      texels_from_metres(still, i, {}) * glm::dvec4(point, 1);
            // A map centred on the camera.
            const glm::dvec3 centred = (fit.light.of(moved) - fit.light.of(start)) / fit.areas[i].texel_m;
            for (int axis = 0; axis < 2; ++axis) {
                ours = std::max(ours, std::abs(change[axis] - std::round(change[axis])));
                naive = std::max(naive, std::abs(centred[axis] - std::round(centred[axis])));
            }
        }
    }
    figure("case 35, a fixed point moves within its texel, texels", naive, ours);
    EXPECT_LE(ours, 1e-6);
    EXPECT_GT(naive, 0.4);
}

// ---- 38: tiles with few rays

TEST_F(HardCase, TilesWithFewRaysKeepThem) {
    const Shot shot = wires_from_close();
    const std::vector<float> truth = truth_of(shot, 0, 64).visibility;
    ShotRun run(cascades_raw, shot, maps_of(512));
    run.frame(0, true);
    const uint32_t rays = counters_of(run.session().view(), "trace").at("rays");
    Words words = words_of(cascades_raw, shot, maps_of(512));
    const Loss ours = loss_of(words, truth);
    uint32_t open = 0;
    for (uint32_t& word : words.undecided) {
        open += static_cast<uint32_t>(std::popcount(word));
        if (std::popcount(word) <= 4) word = 0;
    }
    const Loss naive = loss_of(words, truth);
    figure("case 38, MR(.05) without tiles of at most 4 rays", naive.misclassified, ours.misclassified);
    EXPECT_EQ(rays, open) << "every undecided pixel casts its ray";
    EXPECT_LE(ours.misclassified, 1e-4);
    EXPECT_GE(ours.recall, 0.999);
    EXPECT_GT(naive.misclassified, 1e-4);
}

}  // namespace
}  // namespace penumbra::test
