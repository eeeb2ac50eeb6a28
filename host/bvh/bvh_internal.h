// SPDX-License-Identifier: MIT
// What the builder, the encoder and refit share: boxes and the description of one wide node before it is
// encoded.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "host/bvh/bvh.h"

namespace penumbra::bvh_detail {

struct Box {
    float lo[3] = {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
                   std::numeric_limits<float>::infinity()};
    float hi[3] = {-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
                   -std::numeric_limits<float>::infinity()};

    bool empty() const { return !(lo[0] <= hi[0]); }

    void add(const float p[3]) {
        for (int a = 0; a < 3; ++a) {
            lo[a] = std::min(lo[a], p[a]);
            hi[a] = std::max(hi[a], p[a]);
        }
    }

    void add(const Box& b) {
        for (int a = 0; a < 3; ++a) {
            lo[a] = std::min(lo[a], b.lo[a]);
            hi[a] = std::max(hi[a], b.hi[a]);
        }
    }

    // Half the surface. In double: squares of max_coordinate are no trouble for a float, sums of many would
    // be.
    double area() const {
        if (empty()) return 0;
        const double x = double(hi[0]) - lo[0], y = double(hi[1]) - lo[1], z = double(hi[2]) - lo[2];
        return x * y + y * z + z * x;
    }

    // Twice the centre: the factor is the same everywhere and only comparisons matter.
    float centre2(int axis) const { return lo[axis] + hi[axis]; }

    friend bool operator==(const Box&, const Box&) = default;
};

struct BinaryNode {
    Box box;
    uint32_t left = 0;   // node; 0 (the root is nobody's child): a leaf
    uint32_t right = 0;  // node, or the leaf's number
};

// Makes a tree better by moving subtrees, to no more than so many levels below the root. Children come after
// their parents, before and after. `progress` is told now and then which share of the work is done.
void reinsert(std::vector<BinaryNode>& nodes, uint32_t most_levels,
              const std::function<void(double)>& progress);

using Corners = std::array<uint32_t, 4>;

inline const float* corner(std::span<const Triangle> triangles, uint32_t c) {
    return triangles[c / 3].v[c % 3];
}

// A leaf's box, widened by 2^-20 of its longest side. The triangle test rounds the sheared vertices by a few
// units in the last place of their distance from the ray's origin; the part of it that grows with the
// distance is covered by the slab test's factor, the part that grows with the triangle by this. Without it a
// ray along a shared edge can be turned away by the box of the one triangle whose rounded form it meets.
// Empty where the texels are zeros: nothing is left of such a leaf.
Box leaf_box(const Texel leaf[3]);

// Numbers equal positions equally, by their first occurrence: an open-addressing table.
std::vector<uint32_t> position_numbers(std::span<const std::array<float, 3>> positions);

// Pairs of triangles that share an edge, where one box around both costs less than two.
std::vector<Corners> pair_triangles(std::span<const Triangle> triangles, std::span<const uint32_t> objects,
                                    std::vector<uint32_t>& skipped);

// One 4-wide node: the children's boxes in slot order, nodes first. Empty boxes are masked out.
struct WideNode {
    Box box[4];
    uint32_t nodes = 0, leaves = 0;  // how many of each
    uint32_t first_node = 0, first_leaf = 0;
    uint32_t axis = 0;
};

// Into the texels and bounds of the tree's node `i`.
void put_node(Bvh& bvh, uint32_t i, const WideNode& node);
void encode_leaf(std::span<const Triangle> triangles, const Corners& corners, Texel out[3]);

}  // namespace penumbra::bvh_detail
