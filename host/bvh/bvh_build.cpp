// SPDX-License-Identifier: MIT
// The builder: a binary tree by the surface area heuristic (Wald 2007, "On fast Construction of SAH-based
// Bounding Volume Hierarchies": binned; a full sweep over all splits where few primitives are left), made
// better by moving subtrees (bvh_reinsert.cpp), then the cheapest 4-wide tree that can be cut out of it
// (dynamic programming over "this subtree as at most n children", as in Ylitie et al. 2017).
#include <bit>
#include <numeric>
#include <stdexcept>
#include <string>

#include "host/bvh/bvh_internal.h"

namespace penumbra {
namespace {

using namespace bvh_detail;

constexpr uint32_t bins = 32;
constexpr uint32_t sweep_below = 64;  // a full sweep of so few costs less than clearing the bins
constexpr uint32_t width = 4;
// Grandchildren as children make half of it; see Collapse.
constexpr uint32_t max_binary_depth = 2 * max_bvh_depth;

struct Range {
    uint32_t node, begin, end, depth;
};

class BinaryTree {
  public:
    // `step` is called once per leaf.
    template <class Step>
    BinaryTree(std::vector<Box> primitives, const Step& step) : primitives_(std::move(primitives)) {
        order_.resize(primitives_.size());
        std::iota(order_.begin(), order_.end(), 0u);
        nodes.reserve(primitives_.size() * 2);
        nodes.emplace_back();
        std::vector<Range> work{{0, 0, uint32_t(order_.size()), 0}};
        while (!work.empty()) {
            const Range r = work.back();
            work.pop_back();
            for (uint32_t i = r.begin; i < r.end; ++i) nodes[r.node].box.add(primitives_[order_[i]]);
            if (r.end - r.begin == 1) {
                nodes[r.node].right = order_[r.begin];
                step();
                continue;
            }
            const uint32_t middle = split(r);
            const uint32_t left = uint32_t(nodes.size());
            nodes.resize(nodes.size() + 2);
            nodes[r.node].left = left;
            nodes[r.node].right = left + 1;
            work.push_back({left + 1, middle, r.end, r.depth + 1});
            work.push_back({left, r.begin, middle, r.depth + 1});
        }
    }

    std::vector<BinaryNode> nodes;

  private:
    uint32_t split(const Range& r) {
        const uint32_t count = r.end - r.begin;
        // Halving from here on still ends within the depth limit; anything else might not.
        const uint32_t levels_of_halving = uint32_t(std::bit_width(count - 1));
        if (r.depth + levels_of_halving + 1 >= max_binary_depth) return halve(r);
        return count <= sweep_below ? sweep(r) : binned(r);
    }

    auto by_centre(int axis) const {
        return [this, axis](uint32_t a, uint32_t b) {
            const float x = primitives_[a].centre2(axis), y = primitives_[b].centre2(axis);
            return x != y ? x < y : a < b;
        };
    }

    Box centres(const Range& r) const {
        Box box;
        for (uint32_t i = r.begin; i < r.end; ++i) {
            const Box& p = primitives_[order_[i]];
            const float c[3] = {p.centre2(0), p.centre2(1), p.centre2(2)};
            box.add(c);
        }
        return box;
    }

    uint32_t halve(const Range& r) {
        const Box c = centres(r);
        int axis = 0;
        for (int a = 1; a < 3; ++a)
            if (c.hi[a] - c.lo[a] > c.hi[axis] - c.lo[axis]) axis = a;
        const uint32_t middle = r.begin + (r.end - r.begin) / 2;
        std::nth_element(order_.begin() + r.begin, order_.begin() + middle, order_.begin() + r.end,
                         by_centre(axis));
        return middle;
    }

    uint32_t sweep(const Range& r) {
        const uint32_t count = r.end - r.begin;
        double best = std::numeric_limits<double>::infinity();
        int best_axis = 0;
        uint32_t best_left = count / 2;
        std::array<double, sweep_below> left_area;
        for (int axis = 0; axis < 3; ++axis) {
            std::sort(order_.begin() + r.begin, order_.begin() + r.end, by_centre(axis));
            Box box;
            for (uint32_t i = 0; i + 1 < count; ++i) {
                box.add(primitives_[order_[r.begin + i]]);
                left_area[i] = box.area();
            }
            box = Box{};
            for (uint32_t i = count - 1; i > 0; --i) {
                box.add(primitives_[order_[r.begin + i]]);
                const double cost = left_area[i - 1] * i + box.area() * (count - i);
                if (cost < best) {
                    best = cost;
                    best_axis = axis;
                    best_left = i;
                }
            }
        }
        if (best_axis != 2) std::sort(order_.begin() + r.begin, order_.begin() + r.end, by_centre(best_axis));
        return r.begin + best_left;
    }

    uint32_t binned(const Range& r) {
        const Box c = centres(r);
        float scale[3];
        for (int a = 0; a < 3; ++a) {
            const float extent = c.hi[a] - c.lo[a];
            scale[a] = extent > 0 ? float(bins) * 0.999999f / extent : 0.0f;
            if (!(scale[a] < std::numeric_limits<float>::infinity()))
                scale[a] = 0;  // extent below 1 / FLT_MAX
        }
        const auto bin_of = [&](uint32_t p, int a) {
            return std::min(uint32_t((primitives_[p].centre2(a) - c.lo[a]) * scale[a]), bins - 1);
        };
        std::array<std::array<Box, bins>, 3> boxes{};
        std::array<std::array<uint32_t, bins>, 3> counts{};
        for (uint32_t i = r.begin; i < r.end; ++i) {
            for (int a = 0; a < 3; ++a) {
                const uint32_t bin = bin_of(order_[i], a);
                boxes[a][bin].add(primitives_[order_[i]]);
                ++counts[a][bin];
            }
        }
        double best = std::numeric_limits<double>::infinity();
        int best_axis = 0;
        uint32_t best_bin = 0;
        for (int a = 0; a < 3; ++a) {
            std::array<double, bins> left_cost;
            Box box;
            uint32_t n = 0;
            for (uint32_t b = 0; b + 1 < bins; ++b) {
                box.add(boxes[a][b]);
                n += counts[a][b];
                left_cost[b] = box.area() * n;
            }
            box = Box{};
            n = 0;
            for (uint32_t b = bins - 1; b > 0; --b) {
                box.add(boxes[a][b]);
                n += counts[a][b];
                if (n == 0 || n == r.end - r.begin) continue;
                const double cost = left_cost[b - 1] + box.area() * n;
                if (cost < best) {
                    best = cost;
                    best_axis = a;
                    best_bin = b;
                }
            }
        }
        if (best_bin == 0) return halve(r);  // all centres in one bin
        const auto middle =
            std::stable_partition(order_.begin() + r.begin, order_.begin() + r.end,
                                  [&](uint32_t p) { return bin_of(p, best_axis) < best_bin; });
        return uint32_t(middle - order_.begin());
    }

    std::vector<Box> primitives_;
    std::vector<uint32_t> order_;
};

// The cheapest way to show a binary subtree to its wide parent as at most n children, n = 1..width. Cost is
// the sum of the wide nodes' areas: the leaves are the same whatever is chosen. The cheapest may be deep;
// where what is below would end beyond max_bvh_depth, a node takes its four grandchildren, which halves the
// binary levels.
class Collapse {
  public:
    explicit Collapse(const std::vector<BinaryNode>& nodes)
        : nodes_(nodes), plans_(nodes.size()), heights_(nodes.size()) {
        // Children come after their parent in the array: one pass backwards is bottom-up.
        for (size_t i = nodes.size(); i-- > 0;) {
            const BinaryNode& node = nodes[i];
            auto& best = plans_[i].as_children;
            if (node.left == 0) {
                best.fill({0, {}});
                continue;
            }
            heights_[i] = uint8_t(1 + std::max(heights_[node.left], heights_[node.right]));
            for (uint32_t n = 2; n <= width; ++n) best[n - 1] = cheapest(node, n);
            plans_[i].as_node = best[width - 1].split;
            best[0] = {best[width - 1].cost + node.box.area(), {}};
            for (uint32_t n = 1; n < width; ++n)
                if (!(best[n].cost < best[n - 1].cost)) best[n] = best[n - 1];
        }
    }

    // Binary nodes that become the children of the wide node made from `node` on a level, the root's being 1.
    std::vector<uint32_t> children(uint32_t node, uint32_t level) const {
        std::vector<uint32_t> out;
        if (nodes_[node].left == 0) {
            out.push_back(node);  // the root of a scene of one leaf
            return out;
        }
        open(node, plans_[node].as_node, out);
        const auto too_deep = [&](uint32_t child) {
            return level + levels_by_grandchildren(child) > max_bvh_depth;
        };
        if (std::any_of(out.begin(), out.end(), too_deep)) {
            out.clear();
            for (const uint32_t child : {nodes_[node].left, nodes_[node].right})
                if (nodes_[child].left == 0)
                    out.push_back(child);
                else
                    out.insert(out.end(), {nodes_[child].left, nodes_[child].right});
        }
        return out;
    }

  private:
    struct Split {
        uint8_t left = 0, right = 0;  // children from either side; 0 and 0: the subtree is one child
    };
    struct Choice {
        double cost = std::numeric_limits<double>::infinity();
        Split split;
    };
    struct Plan {
        std::array<Choice, width> as_children;
        Split as_node;
    };

    Choice cheapest(const BinaryNode& node, uint32_t n) const {
        Choice best;
        for (uint32_t k = 1; k < n; ++k) {
            const double cost =
                plans_[node.left].as_children[k - 1].cost + plans_[node.right].as_children[n - k - 1].cost;
            if (cost < best.cost) best = {cost, {uint8_t(k), uint8_t(n - k)}};
        }
        return best;
    }

    void open(uint32_t node, Split split, std::vector<uint32_t>& out) const {
        gather(nodes_[node].left, split.left, out);
        gather(nodes_[node].right, split.right, out);
    }

    void gather(uint32_t node, uint32_t n, std::vector<uint32_t>& out) const {
        const Split split = plans_[node].as_children[n - 1].split;
        if (split.left == 0)
            out.push_back(node);
        else
            open(node, split, out);
    }

    uint32_t levels_by_grandchildren(uint32_t node) const { return (heights_[node] + 1u) / 2u; }

    const std::vector<BinaryNode>& nodes_;
    std::vector<Plan> plans_;
    std::vector<uint8_t> heights_;  // of the binary subtree; 0: a leaf
};

uint32_t widest_axis(const std::vector<BinaryNode>& nodes, std::span<const uint32_t> children) {
    Box centres;
    for (uint32_t c : children) {
        const Box& b = nodes[c].box;
        const float p[3] = {b.centre2(0), b.centre2(1), b.centre2(2)};
        centres.add(p);
    }
    uint32_t axis = 0;
    for (uint32_t a = 1; a < 3; ++a)
        if (centres.hi[a] - centres.lo[a] > centres.hi[axis] - centres.lo[axis]) axis = a;
    return axis;
}

}  // namespace

Bvh build_bvh(std::span<const Triangle> triangles, std::span<const uint32_t> objects,
              const std::function<void(double)>& progress) {
    if (!objects.empty() && objects.size() != triangles.size())
        throw std::invalid_argument("build_bvh: " + std::to_string(objects.size()) + " objects of " +
                                    std::to_string(triangles.size()) + " triangles");
    Bvh bvh;
    bvh.triangle_count = uint32_t(triangles.size());
    const std::vector<Corners> pairs = pair_triangles(triangles, objects, bvh.skipped);
    if (pairs.empty()) {
        bvh.nodes.resize(3);
        bvh.leaves.resize(3);
        bvh.child_counts.resize(1);
        bvh.bounds.resize(1);
        put_node(bvh, 0, WideNode{});
        return bvh;
    }

    // Of the time that terrains of 0.2 and 2 million triangles take: what is spent when the pairs are known,
    // when the binary tree is, and when it is better.
    constexpr double paired = 0.16, binary = 0.4, better = 0.94;
    double from = paired, share = binary - paired;
    size_t leaves = 0;
    const auto step = [&] {
        constexpr size_t stride = 1024;
        if (progress && ++leaves % stride == 0)
            progress(from + share * double(leaves) / double(pairs.size()));
    };
    if (progress) progress(paired);

    std::vector<Box> boxes;
    boxes.reserve(pairs.size());
    for (const Corners& c : pairs) {
        Texel leaf[3];
        encode_leaf(triangles, c, leaf);
        boxes.push_back(leaf_box(leaf));
    }
    BinaryTree tree(std::move(boxes), step);
    const auto moved = [&](double of_moves) {
        if (progress) progress(binary + (better - binary) * of_moves);
    };
    if (progress) progress(binary);
    reinsert(tree.nodes, max_binary_depth - 1, moved);
    const Collapse collapse(tree.nodes);
    from = better, share = 1 - better, leaves = 0;

    bvh.corners.reserve(pairs.size());
    bvh.leaves.resize(pairs.size() * 3);
    bvh.nodes.resize(3);
    bvh.child_counts.resize(1);
    bvh.bounds.resize(1);
    struct Work {
        uint32_t binary, wide, level;
    };
    std::vector<Work> work{{0, 0, 1}};
    while (!work.empty()) {
        const Work w = work.back();
        work.pop_back();
        std::vector<uint32_t> children = collapse.children(w.binary, w.level);
        const auto leaf = std::stable_partition(children.begin(), children.end(),
                                                [&](uint32_t c) { return tree.nodes[c].left != 0; });
        WideNode node;
        node.nodes = uint32_t(leaf - children.begin());
        node.leaves = uint32_t(children.end() - leaf);
        node.axis = widest_axis(tree.nodes, {children.data(), node.nodes});
        std::sort(children.begin(), leaf, [&](uint32_t a, uint32_t b) {
            const float x = tree.nodes[a].box.centre2(int(node.axis)),
                        y = tree.nodes[b].box.centre2(int(node.axis));
            return x != y ? x < y : a < b;
        });
        node.first_node = uint32_t(bvh.nodes.size() / 3);
        node.first_leaf = uint32_t(bvh.corners.size());
        bvh.nodes.resize(bvh.nodes.size() + size_t(node.nodes) * 3);
        bvh.child_counts.resize(bvh.child_counts.size() + node.nodes);
        bvh.bounds.resize(bvh.child_counts.size());
        bvh.child_counts[w.wide] = {uint8_t(node.nodes), uint8_t(node.leaves)};
        for (uint32_t k = 0; k < children.size(); ++k) {
            node.box[k] = tree.nodes[children[k]].box;
            if (k < node.nodes) {
                work.push_back({children[k], node.first_node + k, w.level + 1});
            } else {
                const Corners& c = pairs[tree.nodes[children[k]].right];
                encode_leaf(triangles, c, &bvh.leaves[bvh.corners.size() * 3]);
                bvh.corners.push_back(c);
                step();
            }
        }
        put_node(bvh, w.wide, node);
    }
    return bvh;
}

}  // namespace penumbra
