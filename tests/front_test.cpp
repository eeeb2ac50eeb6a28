// SPDX-License-Identifier: MIT
// Lines of worth against cost, on made-up points whose answers are known.
#include "host/metrics/front.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace penumbra {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = INFINITY;

void expect(const std::optional<Front::Reading>& reading, double value, bool extrapolated) {
    ASSERT_TRUE(reading);
    if (std::isinf(value))
        EXPECT_EQ(reading->value, value);
    else
        EXPECT_NEAR(reading->value / value, 1, 1e-12);
    EXPECT_EQ(reading->extrapolated, extrapolated);
}

// worth = 3 cost^1.6 is a straight line between logarithms: it is met at, between and beyond the points.
TEST(Front, APowerLawIsMetExactlyEverywhere) {
    const auto law = [](double cost) { return 3 * std::pow(cost, 1.6); };
    const Front front({{16, law(16)}, {1, law(1)}, {4, law(4)}, {50, law(50)}});
    ASSERT_EQ(front.points().size(), 4u);
    for (const double cost : {1.0, 1.7, 4.0, 8.0, 30.0, 50.0}) {
        expect(front.worth_at(cost), law(cost), false);
        expect(front.cost_of(law(cost)), cost, false);
    }
    for (const double cost : {0.01, 0.5, 51.0, 1000.0}) {
        expect(front.worth_at(cost), law(cost), true);
        expect(front.cost_of(law(cost)), cost, true);
    }
}

TEST(Front, EachEndGoesOnWithItsOwnSlope) {
    const Front front({{1, 1}, {2, 4}, {8, 8}});  // slopes 2 and 1/2
    expect(front.worth_at(0.5), 0.25, true);
    expect(front.worth_at(1.5), 2.25, false);
    expect(front.worth_at(4), std::sqrt(32), false);
    expect(front.worth_at(32), 16, true);
    expect(front.cost_of(16), 32, true);
}

TEST(Front, WhatAnotherBeatsDoesNotBendIt) {
    const Front front({{1, 1}, {4, 16}});
    // Dearer and worse, as dear and worse, dearer and no better; and the same once more.
    const Front with({{1, 1}, {2, 0.5}, {4, 9}, {4, 16}, {5, 16}, {9, 2}, {1, 1}, {1, 0.1}});
    ASSERT_EQ(with.points().size(), 2u);
    for (const double cost : {0.3, 1.0, 2.0, 4.0, 20.0})
        expect(with.worth_at(cost), front.worth_at(cost)->value, cost < 1 || cost > 4);
    // One that is beaten by the line alone, not by a point, stays: it may be chosen, the line between may
    // not.
    EXPECT_EQ(Front({{1, 1}, {2, 1.5}, {4, 16}}).points().size(), 3u);
}

TEST(Front, APointAloneKnowsItselfAndNothingElse) {
    const Front front({{10, 5}});
    expect(front.worth_at(10), 5, false);
    expect(front.cost_of(5), 10, false);
    EXPECT_FALSE(front.worth_at(10.5));
    EXPECT_FALSE(front.cost_of(4));
    EXPECT_FALSE(Front({}).worth_at(1));
    EXPECT_FALSE(Front({}).cost_of(1));
}

TEST(Front, WhatIsNoNumberIsNoPoint) {
    const Front front({{1, 1}, {nan, 5}, {2, nan}, {0, 7}, {-1, 7}, {inf, 9}, {3, 0}, {3, -2}, {4, 4}});
    ASSERT_EQ(front.points().size(), 2u);
    expect(front.worth_at(2), 2, false);
    for (const double bad : {nan, 0.0, -1.0, inf}) EXPECT_FALSE(front.worth_at(bad)) << bad;
    for (const double bad : {nan, 0.0, -1.0, inf}) EXPECT_FALSE(front.cost_of(bad)) << bad;
}

TEST(Front, WithoutErrorItIsInfinitelyGoodFromThatCostOn) {
    const Front front({{1, 1}, {2, 2}, {10, inf}, {20, inf}, {15, 100}});
    ASSERT_EQ(front.points().size(), 2u);  // the one at 15 is beaten
    expect(front.worth_at(9), 9, true);
    expect(front.worth_at(10), inf, false);
    expect(front.worth_at(1000), inf, false);
    expect(front.cost_of(9), 9, true);
    expect(front.cost_of(50), 10, false);  // the line would ask for 50
    expect(front.cost_of(inf), 10, false);
    expect(Front({{3, inf}}).cost_of(7), 3, false);
    EXPECT_FALSE(Front({{3, inf}}).worth_at(2));
}

TEST(Front, BeatingNeedsOneThingBetterAndNoneWorse) {
    EXPECT_TRUE(beats({1, 2}, {2, 2}));
    EXPECT_TRUE(beats({1, 3}, {1, 2}));
    EXPECT_TRUE(beats({1, inf}, {1, 2}));
    EXPECT_FALSE(beats({1, 2}, {1, 2}));
    EXPECT_FALSE(beats({1, 2}, {2, 3}));
    EXPECT_FALSE(beats({2, 3}, {1, 2}));
}

}  // namespace
}  // namespace penumbra
