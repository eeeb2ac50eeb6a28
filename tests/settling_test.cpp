// SPDX-License-Identifier: MIT
// After how many frames that are alike a plan's outputs get no better.
#include "graph/settling.h"

#include <gtest/gtest.h>

namespace penumbra {
namespace {

constexpr Use read{0, 0, false}, write{0, 0, true};

// Resource 0 has a past, which the first pass reads for resource 1; the second makes resource 0 of `other`.
Plan plan_of(uint32_t other) {
    Plan plan;
    plan.resources.resize(3);
    plan.resources[0].history = true;
    plan.passes.resize(2);
    plan.passes[0].uses = {{0, true, read}, {1, false, write}};
    plan.passes[1].uses = {{other, false, read}, {0, false, write}};
    return plan;
}

TEST(Settling, WhatHasNoPastIsSettledAtOnce) {
    Plan plan = plan_of(2);
    plan.resources[0].history = false;
    EXPECT_EQ(frames_to_settle(plan), 0u);
}

TEST(Settling, APastThatDoesNotFeedItselfIsAFrameBehind) {
    EXPECT_EQ(frames_to_settle(plan_of(2)), 1u);
}

// What the host has changed in a frame is in the next one's previous value.
TEST(Settling, ThePastThatTheHostBringsIsAFrameBehind) {
    Plan plan = plan_of(2);
    plan.slots.push_back({.name = "given@-1", .previous = true});
    EXPECT_EQ(frames_to_settle(plan), 2u) << "and what is made of it a frame more";
    plan.resources[0].history = false;
    EXPECT_EQ(frames_to_settle(plan), 1u);
}

TEST(Settling, OneThatFeedsItselfSettlesAsDeclared) {
    Plan plan = plan_of(1);
    EXPECT_EQ(frames_to_settle(plan), std::nullopt);
    plan.resources[0].settles = 7;
    EXPECT_EQ(frames_to_settle(plan), 7u);
    plan.resources[0].settles = 0;
    plan.resources[0].memo = true;  // spares work, and is seen nowhere
    EXPECT_EQ(frames_to_settle(plan), 0u);
}

// Each is made of the other's last value.
TEST(Settling, TwoPastsThatFeedEachOtherFeedThemselves) {
    Plan plan = plan_of(2);
    plan.resources[1].history = true;
    plan.passes[1].uses = {{1, true, read}, {0, false, write}};
    EXPECT_EQ(frames_to_settle(plan), std::nullopt);
    plan.resources[0].settles = 7;
    EXPECT_EQ(frames_to_settle(plan), std::nullopt);
    plan.resources[1].settles = 5;
    EXPECT_EQ(frames_to_settle(plan), 12u);
}

TEST(Settling, IsLateRatherThanEarlyWhereTheSumIsTooLarge) {
    Plan plan = plan_of(1);
    plan.resources[0].settles = plan.resources[2].settles = 0xC0000000;
    plan.resources[2].history = true;
    EXPECT_EQ(frames_to_settle(plan), 0xFFFFFFFFu);
}

TEST(Settling, PastsSettleOneBehindTheOther) {
    Plan plan = plan_of(1);
    plan.resources[0].settles = 7;
    plan.resources[2] = {.settles = 5, .history = true};
    plan.passes.push_back({.uses = {{0, false, read}, {2, true, read}, {2, false, write}}});
    EXPECT_EQ(frames_to_settle(plan), 12u);
}

TEST(Settling, WhatIsKeptFeedsItself) {
    Plan plan = plan_of(2);
    plan.resources[0].history = false;
    plan.resources[0].kept = true;
    EXPECT_EQ(frames_to_settle(plan), std::nullopt);
    plan.resources[0].settles = 3;
    EXPECT_EQ(frames_to_settle(plan), 3u);
}

}  // namespace
}  // namespace penumbra
