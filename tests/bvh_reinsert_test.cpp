// SPDX-License-Identifier: MIT
// Subtrees that move: the tree keeps its leaves and its form, gets no deeper than it may, and cheaper where
// it was bad.
#include <gtest/gtest.h>

#include <numeric>

#include "host/bvh/bvh_internal.h"
#include "tests/bvh_scenes.h"

namespace penumbra {
namespace {

using namespace bvh_detail;
using test::Random;

std::vector<Box> small_boxes(uint32_t count, uint32_t seed) {
    Random random(seed);
    std::vector<Box> boxes(count);
    for (Box& box : boxes) {
        const float at[3] = {random.in(-10, 10), random.in(-10, 10), random.in(-10, 10)};
        const float to[3] = {at[0] + random.unit(), at[1] + random.unit(), at[2] + random.unit()};
        box.add(at);
        box.add(to);
    }
    return boxes;
}

// Groups of 16 boxes that lie together, side by side in rows, layers and a cube: halved, a tree is good over
// the groups and has each in no order. (Boxes that are large in the whole stay where they are.)
std::vector<Box> groups_of_boxes(uint32_t groups, uint32_t seed) {
    std::vector<Box> boxes;
    for (uint32_t group = 0; group < groups; ++group)
        for (Box box : small_boxes(16, seed + group)) {
            for (int a = 0; a < 3; ++a) {
                const float at = 40.0f * float(group >> 4 * a & 15);
                box.lo[a] += at;
                box.hi[a] += at;
            }
            boxes.push_back(box);
        }
    return boxes;
}

// Over leaves in the order in which they come, so that none has to do with the next: `split` says where a
// range is cut.
template <class Split>
std::vector<BinaryNode> tree_over(const std::vector<Box>& boxes, const Split& split) {
    struct Range {
        uint32_t node, begin, end;
    };
    std::vector<BinaryNode> nodes(1);
    std::vector<Range> work{{0, 0, uint32_t(boxes.size())}};
    while (!work.empty()) {
        const Range r = work.back();
        work.pop_back();
        for (uint32_t i = r.begin; i < r.end; ++i) nodes[r.node].box.add(boxes[i]);
        if (r.end - r.begin == 1) {
            nodes[r.node].right = r.begin;
            continue;
        }
        const uint32_t left = uint32_t(nodes.size()), middle = split(r.begin, r.end);
        nodes.resize(nodes.size() + 2);
        nodes[r.node].left = left;
        nodes[r.node].right = left + 1;
        work.push_back({left, r.begin, middle});
        work.push_back({left + 1, middle, r.end});
    }
    return nodes;
}

uint32_t halves(uint32_t begin, uint32_t end) {
    return begin + (end - begin) / 2;
}

double cost(const std::vector<BinaryNode>& nodes) {
    double sum = 0;
    for (const BinaryNode& node : nodes) sum += node.left ? node.box.area() : 0.0;
    return sum;
}

// Levels below the root. Each leaf is there once with its box, each node's box is that of its children, and
// children come after their parents.
uint32_t levels_of(const std::vector<BinaryNode>& nodes, const std::vector<Box>& boxes) {
    std::vector<int> leaves(boxes.size());
    std::vector<uint32_t> depth(nodes.size());
    for (uint32_t i = 0; i < nodes.size(); ++i) {
        const BinaryNode& node = nodes[i];
        if (node.left == 0) {
            ++leaves.at(node.right);
            EXPECT_EQ(node.box, boxes.at(node.right));
            continue;
        }
        EXPECT_LT(i, std::min(node.left, node.right));
        depth.at(node.left) = depth.at(node.right) = depth[i] + 1;
        Box box = nodes[node.left].box;
        box.add(nodes[node.right].box);
        EXPECT_EQ(node.box, box);
    }
    EXPECT_EQ(std::count(leaves.begin(), leaves.end(), 1), std::ssize(leaves));
    return *std::max_element(depth.begin(), depth.end());
}

TEST(BvhReinsert, ABadTreeBecomesAGoodOneOfTheSameLeaves) {
    const std::vector<Box> boxes = groups_of_boxes(4096, 0);
    std::vector<BinaryNode> nodes = tree_over(boxes, halves);
    const double before = cost(nodes);
    double told = 0;
    reinsert(nodes, 31, [&](double share) {
        EXPECT_GE(share, told);
        told = share;
    });
    EXPECT_LE(levels_of(nodes, boxes), 31u);
    EXPECT_LT(cost(nodes), 0.97 * before);
    EXPECT_GT(told, 0.9);
    EXPECT_LE(told, 1);
}

TEST(BvhReinsert, WhatIsInItsPlaceStays) {
    std::vector<Box> boxes(256);
    for (size_t i = 0; i < boxes.size(); ++i) {
        const float lo[3] = {float(i), 0, 0}, hi[3] = {float(i) + 1, 1, 1};
        boxes[i].add(lo);
        boxes[i].add(hi);
    }
    std::vector<BinaryNode> nodes = tree_over(boxes, halves);
    const double before = cost(nodes);
    reinsert(nodes, 31, [](double) {});
    EXPECT_EQ(levels_of(nodes, boxes), 8u);
    EXPECT_EQ(cost(nodes), before);
}

// As deep as it may be before: every move that adds a level below the deepest leaf is one too many.
TEST(BvhReinsert, NoTreeGetsDeeperThanItMay) {
    for (const uint32_t most : {13u, 16u, 31u}) {
        const std::vector<Box> boxes = groups_of_boxes(256, most);
        const uint32_t chain = most - 12;  // one leaf split off, so many times; the rest is halved
        uint32_t cut = 0;
        const auto split = [&](uint32_t begin, uint32_t end) {
            return end == boxes.size() && cut < chain ? ++cut, begin + 1 : halves(begin, end);
        };
        std::vector<BinaryNode> nodes = tree_over(boxes, split);
        ASSERT_LE(levels_of(nodes, boxes), most);
        const double before = cost(nodes);
        reinsert(nodes, most, [](double) {});
        EXPECT_LE(levels_of(nodes, boxes), most);
        EXPECT_LT(cost(nodes), before);
    }
}

TEST(BvhReinsert, ATreeOfAFewLeavesIsLeft) {
    for (const uint32_t count : {1u, 2u, 3u}) {
        const std::vector<Box> boxes = small_boxes(count, count);
        std::vector<BinaryNode> nodes = tree_over(boxes, halves);
        const double before = cost(nodes);
        reinsert(nodes, 31, [](double) {});
        levels_of(nodes, boxes);
        EXPECT_LE(cost(nodes), before);
    }
}

}  // namespace
}  // namespace penumbra
