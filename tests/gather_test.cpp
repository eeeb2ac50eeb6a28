// SPDX-License-Identifier: MIT
// The estimator of node gather alone: how many rays its answers are worth, and where they are exact.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <random>

#include "tests/gather_run.h"

namespace penumbra::test {
namespace {

class Gather : public GpuTest {
  protected:
    Result gather(const Setting& setting) {
        const auto [run, made] = runs_.try_emplace(setting.radius);
        if (made) run->second = std::make_unique<ViewRun>(run_with(setting.radius));
        return test::gather(*run->second, setting);
    }
    double n_eff(Setting setting, uint32_t seeds = 4) {
        Share share;
        for (setting.seed = 1; setting.seed <= seeds; ++setting.seed) add(share, gather(setting));
        return share.n_eff();
    }

  private:
    std::map<int, std::unique_ptr<ViewRun>> runs_;  // by the radius of the taps
};

// White noise: the shipped tracer's blue noise does better (docs/denoiser.md).
TEST_F(Gather, CountsItsNeighboursRaysAtEveryAngle) {
    for (const double angle : {0.0, 17.0, 45.0, 70.0, 90.0, 110.0, 135.0, 160.0}) {
        SCOPED_TRACE(angle);
        EXPECT_GT(n_eff({.edges = {{distance_for(8), angle}}}), 35);
        EXPECT_GT(n_eff({.edges = {{distance_for(16), angle}}}), 60);
    }
}

// Which invocation works on which cell depends on the workgroup's shape and on the order of its list.
TEST_F(Gather, SaysTheSameInEveryWorkgroup) {
    ViewRun narrow = run_with(4), square = run_with(4, false);
    Setting setting{.edges = {{distance_for(12), 17}},
                    .averted = [](int x, int y) { return (x / 5 + y / 3) % 4 == 0; }};
    for (setting.frame = 0; setting.frame < 2; ++setting.frame)
        EXPECT_EQ(penumbra::test::gather(narrow, setting).now, penumbra::test::gather(square, setting).now);

    const auto of = [](ViewRun& run) { return captured<std::array<uint32_t, 8>>(run.view(), "cells"); };
    const auto cells = of(narrow), in_squares = of(square);
    const auto idle = captured<uint32_t>(narrow.view(), "idle_cells");
    size_t working = 0;
    for (size_t i = 0; i < cells.size(); ++i) {
        if (idle[i] != 0) continue;  // there is nothing in the others
        ++working;
        EXPECT_EQ(cells[i], in_squares[i]) << i;
    }
    EXPECT_GT(working, 50u);
}

// Both tiles of a block of 8x8 pixels say what their rays have hit.
TEST_F(Gather, IsToldOfEveryBlocker) {
    ViewRun run = run_with(4);
    const Result r = penumbra::test::gather(run, {.edges = {{distance_for(12), 17}}});
    const std::vector<float> hits = captured_planes(run.view(), "block_blockers").at(0);
    EXPECT_EQ(std::accumulate(hits.begin(), hits.end(), 0.0), std::ranges::count(r.bit, false));
}

TEST_F(Gather, AsksMoreNeighboursWhereItIsToldTo) {
    const auto at = [&](int radius) {
        return n_eff({.edges = {{distance_for(16), 17}}, .radius = radius}, 6);
    };
    const double few = at(3), usual = at(4), many = at(5);
    EXPECT_GT(usual, 1.1 * few);
    EXPECT_GT(many, 1.1 * usual);
}

// A sun whose axis is mirrored between tracer and denoiser: every neighbour's ray is taken to test another
// place than it does: 19 to 32 instead of 52 to 61 (90 degrees is not among these: such an edge does not
// depend on the mirrored axis).
TEST_F(Gather, FailsThatWithAMirroredSun) {
    for (const double angle : {0.0, 17.0, 45.0, 135.0, 160.0}) {
        SCOPED_TRACE(angle);
        const std::vector<HungEdge> edge = {{distance_for(8), angle}};
        EXPECT_LT(n_eff({.edges = edge, .mirrored = true}), 0.65 * n_eff({.edges = edge}));
    }
}

// The mean over many seeds is the truth: what is left of the squared error of the mean is what the deviation
// between seeds explains.
TEST_F(Gather, IsUnbiasedInAStraightPenumbra) {
    for (const double width : {4.0, 8.0, 24.0}) {
        SCOPED_TRACE(width);
        Setting setting{.edges = {{distance_for(width), 17}}};
        constexpr int seeds = 24;
        std::vector<double> sum, squares, truth;
        for (setting.seed = 1; setting.seed <= seeds; ++setting.seed) {
            const Result r = gather(setting);
            sum.resize(r.now.size());
            squares.resize(r.now.size());
            truth = r.truth;
            for (size_t i = 0; i < r.now.size(); ++i) {
                sum[i] += r.now[i];
                squares[i] += r.now[i] * r.now[i];
            }
        }
        double signal = 0, bias2 = 0, mean_error = 0;
        size_t n = 0;
        for (size_t i = 0; i < truth.size(); ++i) {
            if (!in_penumbra(truth[i])) continue;
            const double mean = sum[i] / seeds, variance = (squares[i] - sum[i] * mean) / (seeds - 1);
            bias2 += (mean - truth[i]) * (mean - truth[i]) - variance / seeds;
            mean_error += mean - truth[i];
            signal += truth[i] * (1 - truth[i]);
            ++n;
        }
        EXPECT_GT(signal / std::max(bias2, 1e-9), width < 8 ? 150 : 400);  // as effective samples
        EXPECT_LT(std::abs(mean_error / double(n)), 0.01);
    }
}

TEST_F(Gather, IsTheRayItselfBelowAPixel) {
    const Result r = gather({.edges = {{distance_for(0.9), 17}}});
    for (size_t i = 0; i < r.now.size(); ++i) ASSERT_EQ(r.now[i], r.bit[i] ? 1 : 0) << i;
}

// No halo: beyond the penumbra by more than the distance's fixed point (half of 1/64 octave) everything is
// exact.
TEST_F(Gather, IsExactBesideThePenumbra) {
    for (const double width : {2.0, 8.0, 32.0}) {
        const Result r = gather({.edges = {{distance_for(width), 17}}});
        const Result wider = gather({.edges = {{1.03 * distance_for(width), 17}}});
        for (size_t i = 0; i < r.now.size(); ++i) {
            if (wider.truth[i] > 0 && wider.truth[i] < 1) continue;
            ASSERT_EQ(r.now[i], wider.truth[i]) << width << ", " << i;
        }
    }
}

// All rays say "lit" of a sudden: where a cell's own rays have said so before, that is all there is, and
// where they have not, drift has to judge between them. Most of the dark cells had no work in the first
// frame.
TEST_F(Gather, KeepsAPastThatItsRaysContradict) {
    ViewRun run = run_with(4);
    const Result before = test::gather(run, {.edges = {{distance_for(2), 20}}});
    const Result after = test::gather(run, {.edges = {}, .frame = 1});
    const auto cell_of = [](size_t i) { return std::pair(i % extent.width / 4, i / extent.width / 4); };
    std::set<std::pair<size_t, size_t>> dark_cells;
    for (size_t i = 0; i < before.bit.size(); ++i)
        if (!before.bit[i]) dark_cells.insert(cell_of(i));
    ASSERT_GT(dark_cells.size(), before.bit.size() / 16 / 4);
    for (size_t i = 0; i < before.bit.size(); ++i) {
        ASSERT_EQ(after.now[i], 1) << "pixel " << i;
        if (!dark_cells.contains(cell_of(i))) continue;
        ASSERT_NEAR(after.past[i], before.now[i], 1.0 / 1023) << "pixel " << i;
    }
}

TEST_F(Gather, HoldsAtGrazingViews) {
    for (const double tilt : {60.0, 75.0, 85.0})
        for (const double angle : {0.0, 17.0, 45.0, 90.0, 135.0}) {
            SCOPED_TRACE(testing::Message() << tilt << " degrees, edge at " << angle);
            EXPECT_GT(n_eff({.tilt_deg = tilt, .edges = {{distance_for(8), angle}}}), tilt < 80 ? 8 : 1.5);
            EXPECT_GT(n_eff({.tilt_deg = tilt, .edges = {{distance_for(24), angle}}}), tilt < 80 ? 40 : 12);
        }
}

// Pixels that a low sun sees along their diagonal are as good as those that it sees along a side: who is
// within reach lies in an ellipse, whose axes need not be the image's.
TEST_F(Gather, AsksAsManyInEveryDirectionOfTheSun) {
    const auto from = [&](double azimuth) {
        double sum = 0;
        for (const double angle : {0.0, 45.0, 90.0, 135.0})
            sum += n_eff(
                {.edges = {{distance_for(3.5), angle}}, .sun_elevation_deg = 25, .sun_azimuth_deg = azimuth});
        return sum;
    };
    const double along_x = from(0);
    for (const double azimuth : {45.0, 135.0}) EXPECT_GT(from(azimuth), 0.85 * along_x) << azimuth;
}

// A step in the receiver: rays of the other side are somebody else's, unless they lie on the same plane.
TEST_F(Gather, KeepsTwoReceiversApart) {
    Setting flat{.edges = {{distance_for(12), 17}}}, step = flat;
    step.step_m = [](int x, int) { return x < 44 ? 0.3 : 0.0; };
    const auto near_step = [](int x, int) { return x >= 38 && x < 50; };
    Share without, with;
    for (flat.seed = step.seed = 1; flat.seed <= 6; ++flat.seed, ++step.seed) {
        add(without, gather(flat), near_step);
        add(with, gather(step), near_step);
    }
    EXPECT_GT(with.n_eff(), 0.3 * without.n_eff());
    EXPECT_GT(with.n_eff(), 15);
}

// A ledge over a floor: what hides the floor from the sun lies below the ledge. The sun stands straight
// above, so that both see it through the same place.
TEST_F(Gather, AsksNobodyOnAnotherPlane) {
    Setting setting{.edges = {{distance_for(12), 90}}, .sun_elevation_deg = 90};
    setting.above = [](int x, int) { return x < 44; };
    setting.step_m = [&](int x, int y) { return setting.above(x, y) ? 0.3 : 0.0; };
    for (setting.seed = 1; setting.seed <= 3; ++setting.seed) {
        const Result r = gather(setting);
        for (int y = 0; y < int(extent.height); ++y)
            for (int x = 36; x < 44; ++x)
                ASSERT_GT(r.now[size_t(y) * extent.width + x], 0.99) << x << ", " << y;
    }
}

// Surfaces that look away from the sun are dark for a reason of their own.
TEST_F(Gather, DoesNotTakeDarkFacesForBlockers) {
    Setting setting{.edges = {{distance_for(12), 0, 1.0}}};  // the edge lies outside of the image
    setting.averted = [](int x, int y) { return (x + y) % 7 == 0; };
    const Result r = gather(setting);
    for (size_t i = 0; i < r.now.size(); ++i) ASSERT_EQ(r.now[i], r.counted[i] ? 1 : 0) << i;
}

TEST_F(Gather, IsAsGoodAtTheBorder) {
    Share border, inside;
    for (uint32_t seed = 1; seed <= 6; ++seed) {
        const Result r = gather({.edges = {{distance_for(24), 0}}, .seed = seed});
        const auto at_border = [](int, int y) { return y < 4 || y >= int(extent.height) - 4; };
        add(border, r, at_border);
        add(inside, r, [&](int x, int y) { return !at_border(x, y); });
    }
    EXPECT_GT(border.n_eff(), 0.3 * inside.n_eff());
}

// A sun that has half set behind the receiver's own plane, beside an edge: rays to its lower half meet the
// receiver, whatever the blockers do. They are no samples of the edge, and their share of the disc is known:
// sheared as if a blocker had stopped them, they leave 67 to 72 effective samples instead of 95 to 138.
TEST_F(Gather, KnowsWhatTheReceiversOwnPlaneHides) {
    for (const double elevation : {-0.8, 0.0, 0.8}) {
        SCOPED_TRACE(elevation);
        Setting setting{.sun_radius_deg = 2, .sun_elevation_deg = elevation};
        const glm::dmat3 axes = light_axes(receiver_of(setting).sun);
        const glm::dvec2 sideways(axes[0].y, axes[1].y);  // the image's vertical, across the light
        setting.edges = {{distance_for(12, 2), glm::degrees(std::atan2(sideways.y, sideways.x))}};
        // Where blockers are near: on the lit side there is nothing to shear by, and the own ray is all.
        const auto beside_the_edge = [](int, int y) { return y >= 28 && y < 36; };
        Share share;
        for (setting.seed = 1; setting.seed <= 4; ++setting.seed)
            add(share, gather(setting), beside_the_edge);
        EXPECT_GT(share.n_eff(), 83);
    }
}

// Two edges at distances of 1 : 4 whose penumbrae lie side by side: no single distance is right.
TEST_F(Gather, SurvivesSeveralBlockers) {
    const double far = distance_for(24), near = distance_for(6), px = pixel_m(narrow_camera());
    EXPECT_GT(n_eff({.edges = {{far, 0, 14 * px}, {near, 180, 2 * px}}}), 8);
}

}  // namespace
}  // namespace penumbra::test
