// SPDX-License-Identifier: MIT
// What splitting from the top cannot see: a subtree that would lie better elsewhere is taken out and put in
// where the areas of all boxes grow least (Bittner, Hapala, Havran 2013, "Fast Insertion-Based Optimization
// of Bounding Volume Hierarchies"), found best first from the root, the largest subtrees in their turn first.
#include "host/bvh/bvh_internal.h"

namespace penumbra::bvh_detail {
namespace {

// Of the nodes those with the largest boxes. All of them, and a third time, take five times as long for a
// tenth more.
constexpr size_t one_in = 3;
constexpr int passes = 2;
// Of the root's area. What is larger stays: among rows of columns a ray that is blocked had a fifth more
// nodes to look at where beams and floors had been moved near the root.
constexpr double most_area = 0.01;
// Where boxes lie in each other, bounds cut nothing off, and a search would look at the whole tree.
constexpr int most_looked_at = 64;

class Reinsertion {
  public:
    Reinsertion(std::vector<BinaryNode>& nodes, uint32_t most_levels)
        : nodes_(nodes), most_levels_(most_levels), parents_(nodes.size()), levels_(nodes.size()) {
        for (size_t i = nodes.size(); i-- > 0;) {
            const BinaryNode& node = nodes[i];
            if (node.left == 0) continue;
            parents_[node.left] = parents_[node.right] = uint32_t(i);
            levels_[i] = levels_below(node);
        }
    }

    // Whether any subtree moved. `progress` is told which share has been tried.
    template <class Progress>
    bool pass(const Progress& progress) {
        std::vector<std::pair<double, uint32_t>> largest;
        largest.reserve(nodes_.size());
        for (uint32_t i = 1; i < nodes_.size(); ++i) {
            const double area = nodes_[i].box.area();
            if (area <= most_area * nodes_[0].box.area()) largest.emplace_back(-area, i);
        }
        const size_t count = (largest.size() + one_in - 1) / one_in;
        std::partial_sort(largest.begin(), largest.begin() + ptrdiff_t(count), largest.end());
        bool moved = false;
        for (size_t k = 0; k < count; ++k) {
            if (parents_[largest[k].second] != 0 && move(largest[k].second)) moved = true;
            if (k % 1024 == 1023) progress(double(k) / double(count));
        }
        return moved;
    }

  private:
    // Above a node its subtree could go. Growth: of the boxes above it.
    struct Place {
        double growth;
        uint32_t node, depth;
        friend auto operator<=>(const Place&, const Place&) = default;
    };

    uint8_t levels_below(const BinaryNode& node) const {
        return uint8_t(1 + std::max(levels_[node.left], levels_[node.right]));
    }

    static double area_of_both(Box a, const Box& b) {
        a.add(b);
        return a.area();
    }

    void replace_child(uint32_t parent, uint32_t child, uint32_t by) {
        BinaryNode& node = nodes_[parent];
        (node.left == child ? node.left : node.right) = by;
        parents_[by] = parent;
    }

    // Whether that changes anything.
    bool fit(uint32_t i) {
        BinaryNode& node = nodes_[i];
        Box box = nodes_[node.left].box;
        box.add(nodes_[node.right].box);
        const uint8_t levels = levels_below(node);
        if (box == node.box && levels == levels_[i]) return false;
        node.box = box;
        levels_[i] = levels;
        return true;
    }

    void fit_from(uint32_t i) {
        while (fit(i) && i != 0) i = parents_[i];
    }

    // `place` is made the sibling of `subtree` by the free node `joint`.
    void put(uint32_t joint, uint32_t place, uint32_t subtree) {
        replace_child(parents_[place], place, joint);
        nodes_[joint].left = place;
        nodes_[joint].right = subtree;
        parents_[place] = parents_[subtree] = joint;
        fit(joint);
        fit_from(parents_[joint]);
    }

    bool move(uint32_t subtree) {
        const uint32_t joint = parents_[subtree];
        const uint32_t sibling = nodes_[joint].left == subtree ? nodes_[joint].right : nodes_[joint].left;
        replace_child(parents_[joint], joint, sibling);
        fit_from(parents_[sibling]);
        const uint32_t place = cheapest_place(subtree, sibling);
        put(joint, place, subtree);
        return place != sibling;
    }

    // Where it was, unless another place is cheaper for sure.
    uint32_t cheapest_place(uint32_t subtree, uint32_t was) {
        const Box& box = nodes_[subtree].box;
        double least = area_of_both(nodes_[was].box, box);
        for (uint32_t i = was; i != 0;) {
            i = parents_[i];
            least += area_of_both(nodes_[i].box, box) - nodes_[i].box.area();
        }
        least *= 1 - 1e-6;
        uint32_t place = was;
        const double own_area = box.area();
        const auto later = [](const Place& a, const Place& b) { return b < a; };
        pending_.assign(1, {0.0, 0, 0});
        for (int looked_at = 0; !pending_.empty() && looked_at < most_looked_at; ++looked_at) {
            std::pop_heap(pending_.begin(), pending_.end(), later);
            const Place here = pending_.back();
            pending_.pop_back();
            if (here.growth + own_area >= least) break;
            const BinaryNode& node = nodes_[here.node];
            const double both = area_of_both(node.box, box);
            const uint32_t levels = here.depth + 1 + std::max(levels_[here.node], levels_[subtree]);
            if (here.node != 0 && levels <= most_levels_ && here.growth + both < least) {
                least = here.growth + both;
                place = here.node;
            }
            const double growth = here.growth + both - node.box.area();
            if (node.left == 0 || growth + own_area >= least) continue;
            for (const uint32_t child : {node.left, node.right}) {
                pending_.push_back({growth, child, here.depth + 1});
                std::push_heap(pending_.begin(), pending_.end(), later);
            }
        }
        return place;
    }

    std::vector<BinaryNode>& nodes_;
    const uint32_t most_levels_;
    std::vector<uint32_t> parents_;
    std::vector<uint8_t> levels_;  // below each node; 0: a leaf
    std::vector<Place> pending_;   // a heap, the least growth first
};

// Children after their parents.
std::vector<BinaryNode> in_order(const std::vector<BinaryNode>& nodes) {
    std::vector<BinaryNode> out{nodes[0]};
    out.reserve(nodes.size());
    for (uint32_t i = 0; i < out.size(); ++i) {
        if (out[i].left == 0) continue;
        const uint32_t left = uint32_t(out.size());
        out.push_back(nodes[out[i].left]);
        out.push_back(nodes[out[i].right]);
        out[i].left = left;
        out[i].right = left + 1;
    }
    return out;
}

}  // namespace

void reinsert(std::vector<BinaryNode>& nodes, uint32_t most_levels,
              const std::function<void(double)>& progress) {
    Reinsertion reinsertion(nodes, most_levels);
    for (int i = 0; i < passes; ++i)
        if (!reinsertion.pass([&](double share) { progress((i + share) / passes); })) break;
    nodes = in_order(nodes);
}

}  // namespace penumbra::bvh_detail
