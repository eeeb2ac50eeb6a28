// SPDX-License-Identifier: MIT
// A tree whose triangles move: it answers as one that is built where they are, and says what it has written.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "host/bvh/bvh.h"
#include "tests/bvh_oracle.h"
#include "tests/bvh_scenes.h"

namespace penumbra {
namespace {

using namespace test;

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

TEST(BvhRefit, AnswersLikeARebuild) {
    const std::vector<Triangle> start = closed_ball(4, {0, 0, 0}, 3);
    Bvh bvh = build_bvh(start);
    std::vector<Triangle> moved = start;
    for (Triangle& t : moved)
        for (auto& v : t.v) {
            const float x = v[0];
            v[0] = 1.5f * x + 0.4f * std::sin(v[1] * 2) + 20;
            v[1] = v[1] + 0.3f * x;
            v[2] = -v[2];
        }
    ASSERT_TRUE(refit(bvh, moved));
    const Bvh rebuilt = build_bvh(moved);
    int hits = 0;
    for (const Ray& ray : shadow_rays(moved, 100000, 11)) {
        const bool answer = occluded(rebuilt, ray);
        ASSERT_EQ(occluded(bvh, ray), answer);
        hits += answer;
    }
    EXPECT_GT(hits, 10000);
    ASSERT_TRUE(refit(bvh, start));  // and back again
    const Bvh fresh = build_bvh(start);
    for (const Ray& ray : shadow_rays(start, 20000, 12)) ASSERT_EQ(occluded(bvh, ray), occluded(fresh, ray));
}

TEST(BvhRefit, LeavesOutWhatBecameUnusableUntilItIsUsableAgain) {
    const std::vector<Triangle> start = terrain(12);
    Bvh bvh = build_bvh(start);
    std::vector<Triangle> broken = start, without;
    for (size_t i = 0; i < broken.size(); ++i) {
        if (i % 3 == 0 || (i > 40 && i < 120))
            broken[i].v[1][1] = nan;
        else
            without.push_back(broken[i]);
    }
    ASSERT_TRUE(refit(bvh, broken));
    const Bvh clean = build_bvh(without);
    for (const Ray& ray : shadow_rays(start, 50000, 13)) ASSERT_EQ(occluded(bvh, ray), occluded(clean, ray));
    ASSERT_TRUE(refit(bvh, start));
    const Bvh fresh = build_bvh(start);
    EXPECT_EQ(bvh.nodes, fresh.nodes);
    EXPECT_EQ(bvh.leaves, fresh.leaves);
}

// In steps of which each moves a few objects, or breaks triangles, it comes to the same tree as in one; what
// it does not say that it has written is as it was.
TEST(BvhRefit, WritesWhatMovedAndSaysWhat) {
    std::vector<Triangle> start;
    std::vector<uint32_t> objects;
    for (uint32_t i = 0; i < 6; ++i)
        for (const Triangle& t : closed_ball(2, {5 * float(i), 0, 0}, 1)) {
            start.push_back(t);
            objects.push_back(i);
        }
    Bvh steps = build_bvh(start, objects);
    const Bvh built = steps;
    std::vector<Triangle> now = start;
    Random random(29);
    for (int step = 0; step < 40; ++step) {
        const uint32_t object = random.bits() % 6, other = random.bits() % 6;
        const float by = step % 5 == 4 ? 0 : random.in(-1, 1);
        for (size_t i = 0; i < now.size(); ++i) {
            if (objects[i] != object && objects[i] != other) continue;
            now[i] = start[i];
            for (auto& v : now[i].v) v[1] += by * (1 + v[0]);
            if (step % 3 == 0 && i % 4 == 0) now[i].v[2][0] = nan;
        }
        const Bvh before = steps;
        Refitted written;
        ASSERT_TRUE(refit(steps, now, &written));
        Bvh at_once = built;
        ASSERT_TRUE(refit(at_once, now));
        ASSERT_EQ(steps.nodes, at_once.nodes);
        ASSERT_EQ(steps.leaves, at_once.leaves);
        ASSERT_EQ(steps.bounds, at_once.bounds);
        const auto expect_said = [](const std::vector<Texel>& a, const std::vector<Texel>& b,
                                    const std::vector<uint32_t>& said) {
            EXPECT_TRUE(std::is_sorted(said.begin(), said.end()));
            EXPECT_LT(said.size(), a.size() / 3);
            for (uint32_t i = 0; i < a.size() / 3; ++i)
                if (!std::equal(&a[i * 3], &a[i * 3] + 3, &b[i * 3])) {
                    ASSERT_TRUE(std::binary_search(said.begin(), said.end(), i)) << i;
                }
        };
        expect_said(before.nodes, steps.nodes, written.nodes);
        expect_said(before.leaves, steps.leaves, written.leaves);
    }
    ASSERT_TRUE(refit(steps, start));
    Refitted nothing;
    ASSERT_TRUE(refit(steps, start, &nothing));
    EXPECT_TRUE(nothing.leaves.empty());
    EXPECT_TRUE(nothing.nodes.empty());
}

TEST(BvhRefit, RefusesWhatTheOldTreeCannotHold) {
    std::vector<Triangle> quads;
    add_quad(quads, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
    quads.push_back(triangle({5, 5, 5}, {5, 5, 5}, {6, 6, 6}));
    Bvh bvh = build_bvh(quads);
    const Bvh before = bvh;
    std::vector<Triangle> apart = quads;
    for (auto& v : apart[1].v) v[2] += 1;
    EXPECT_FALSE(refit(bvh, apart));
    // Of the second triangle a leaf holds one corner; the other two are the first's.
    std::vector<Triangle> torn = quads;
    torn[1].v[0][2] += 1;
    torn[1].v[1][2] += 1;
    EXPECT_FALSE(refit(bvh, torn));
    std::vector<Triangle> appeared = quads;
    appeared[2].v[0][0] = 4;
    EXPECT_FALSE(refit(bvh, appeared));
    EXPECT_EQ(bvh.nodes, before.nodes);
    EXPECT_EQ(bvh.leaves, before.leaves);
    const uint32_t objects[] = {0, 1, 2};
    Bvh separate = build_bvh(quads, objects);
    EXPECT_TRUE(refit(separate, apart));
    EXPECT_TRUE(occluded(separate, {{0.3f, 0.6f, 0.5f}, {0, 0, 1}, 0, infinity}));
}

TEST(BvhRefit, RefusesAnotherNumberOfTriangles) {
    const std::vector<Triangle> start = terrain(4);
    Bvh bvh = build_bvh(start);
    const Bvh before = bvh;
    std::vector<Triangle> fewer(start.begin(), start.end() - 1), more = start;
    more.push_back(start[0]);
    EXPECT_THROW(refit(bvh, fewer), std::invalid_argument);
    EXPECT_THROW(refit(bvh, more), std::invalid_argument);
    EXPECT_EQ(bvh.nodes, before.nodes);
    EXPECT_EQ(bvh.leaves, before.leaves);
}

}  // namespace
}  // namespace penumbra
