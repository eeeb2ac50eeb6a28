// SPDX-License-Identifier: MIT
// Which triangles share an edge, for queries that walk from a triangle to the ones around it. Read from the
// leaves alone, so it holds for the positions that are traced now, whatever moved since the build. Edges are
// matched by position; of more than two triangles at one edge, those are joined whose windings run opposite
// ways along it, as they do within a closed surface.
#include <algorithm>
#include <bit>
#include <stdexcept>

#include "host/bvh/bvh.h"
#include "host/bvh/bvh_internal.h"

namespace penumbra {
namespace {

using namespace bvh_detail;

struct Side {
    uint64_t edge;      // both ends' numbers, the smaller first
    uint32_t backward;  // whether the winding runs from the larger to the smaller
    uint32_t triangle;  // leaf << 1 | which
    uint32_t corner;    // of the triangle, opposite to the edge
    friend auto operator<=>(const Side&, const Side&) = default;
};

// Corners of a leaf's triangles, as numbers of its vertices.
constexpr uint32_t corner_vertex[2][3] = {{0, 1, 2}, {2, 1, 3}};

std::array<float, 3> vertex(const Bvh& bvh, uint32_t leaf, uint32_t i) {
    std::array<float, 3> p;
    for (uint32_t a = 0; a < 3; ++a)
        p[a] = std::bit_cast<float>(bvh.leaves[size_t(leaf) * 3 + (i * 3 + a) / 4][(i * 3 + a) % 4]);
    return p;
}

uint32_t word_of(const Side& side, bool same_way) {
    return side.triangle >> 1 << 4 | uint32_t(same_way) << 3 | (side.triangle & 1) << 2 | side.corner;
}

// Where a leaf's texel keeps what lies across the edge opposite to a corner; the edge that two triangles of a
// leaf share needs no word.
uint32_t slot_of(const Side& side, bool pair) {
    if ((side.triangle & 1) == 0) return side.corner == 0 ? (pair ? ~0u : 2) : 2 - side.corner;
    return side.corner == 2 ? ~0u : side.corner + 2;
}

// The edge that a word of `leaf` belongs to: which of the leaf's triangles, and the corner opposite to it.
struct LeafEdge {
    uint32_t leaf, which, corner;

    size_t slot(bool pair) const { return slot_of({0, 0, leaf << 1 | which, corner}, pair); }
};

LeafEdge edge_of(uint32_t leaf, uint32_t slot, bool pair) {
    if (slot < 2) return {leaf, 0, 2 - slot};
    return pair ? LeafEdge{leaf, 1, slot - 2} : LeafEdge{leaf, 0, 0};
}

std::array<std::array<float, 3>, 2> ends(const Bvh& bvh, const LeafEdge& edge) {
    const auto end = [&](uint32_t k) {
        return vertex(bvh, edge.leaf, corner_vertex[edge.which][(edge.corner + k) % 3]);
    };
    return {end(1), end(2)};
}

}  // namespace

std::vector<Texel> leaf_neighbours(const Bvh& bvh) {
    const uint32_t leaves = uint32_t(bvh.leaves.size() / 3);
    std::vector<std::array<float, 3>> positions(size_t(leaves) * 4);
    for (size_t i = 0; i < positions.size(); ++i)
        positions[i] = vertex(bvh, uint32_t(i / 4), uint32_t(i % 4));
    const std::vector<uint32_t> number = position_numbers(positions);
    const auto is_pair = [&](uint32_t leaf) { return number[leaf * 4 + 2] != number[leaf * 4 + 3]; };

    std::vector<Side> sides;
    sides.reserve(size_t(leaves) * 4);
    for (uint32_t triangle = 0; triangle < leaves * 2; ++triangle) {
        const uint32_t leaf = triangle >> 1;
        if ((triangle & 1) != 0 && !is_pair(leaf)) continue;
        for (uint32_t corner = 0; corner < 3; ++corner) {
            const auto end = [&](uint32_t k) {
                return number[leaf * 4 + corner_vertex[triangle & 1][(corner + k) % 3]];
            };
            const uint32_t a = end(1), b = end(2);
            if (a == b || slot_of({0, 0, triangle, corner}, is_pair(leaf)) == ~0u) continue;
            sides.push_back(
                {uint64_t(std::min(a, b)) << 32 | std::max(a, b), uint32_t(a > b), triangle, corner});
        }
    }
    std::sort(sides.begin(), sides.end());

    std::vector<Texel> out(leaves, Texel{no_neighbour, no_neighbour, no_neighbour, no_neighbour});
    const auto join = [&](const Side& from, const Side& to) {
        const uint32_t leaf = from.triangle >> 1;
        out[leaf][slot_of(from, is_pair(leaf))] = word_of(to, from.backward == to.backward);
    };
    for (size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
        while (end < sides.size() && sides[end].edge == sides[begin].edge) ++end;
        size_t backward = begin;
        while (backward < end && !sides[backward].backward) ++backward;
        // Opposite windings first, in the order of the triangles; what is left over is joined among itself.
        const size_t both = std::min(backward - begin, end - backward);
        for (size_t i = 0; i < both; ++i) {
            join(sides[begin + i], sides[backward + i]);
            join(sides[backward + i], sides[begin + i]);
        }
        size_t rest = backward - begin > both ? begin + both : backward + both;
        const size_t rest_end = backward - begin > both ? backward : end;
        for (; rest + 1 < rest_end; rest += 2) {
            join(sides[rest], sides[rest + 1]);
            join(sides[rest + 1], sides[rest]);
        }
    }
    return out;
}

bool refit_neighbours(const Bvh& bvh, std::span<const uint32_t> leaves, std::span<const Texel> built,
                      std::span<Texel> neighbours) {
    const auto was_pair = [&](uint32_t leaf) { return bvh.corners[leaf][2] != bvh.corners[leaf][3]; };
    // A pair of which one half is left has other edges than its words tell of.
    const auto is_whole = [&](uint32_t leaf) {
        return !was_pair(leaf) || vertex(bvh, leaf, 2) != vertex(bvh, leaf, 3);
    };
    struct Join {
        LeafEdge theirs;
        size_t back;  // their word for our edge
    };
    const auto across = [&](uint32_t word) {
        const LeafEdge theirs{word >> 4, word >> 2 & 1, word & 3};
        return Join{theirs, theirs.leaf < bvh.corners.size() ? theirs.slot(was_pair(theirs.leaf)) : 4};
    };
    // Nothing is written before all of it is known to be of this tree.
    const size_t count = bvh.leaves.size() / 3;
    bool fits = built.size() == count && neighbours.size() == count;
    for (size_t i = 0; fits && i < leaves.size(); ++i) {
        fits = leaves[i] < bvh.corners.size();
        for (uint32_t slot = 0; fits && slot < 4; ++slot) {
            const uint32_t word = built[leaves[i]][slot];
            fits = word == no_neighbour || across(word).back < 4;
        }
    }
    if (!fits) throw std::invalid_argument("refit_neighbours: the lists are of another tree");
    bool changed = false;
    const auto put = [&](uint32_t& word, uint32_t now) {
        changed = changed || word != now;
        word = now;
    };
    for (const uint32_t leaf : leaves)
        for (uint32_t slot = 0; slot < 4; ++slot) {
            const uint32_t word = built[leaf][slot];
            if (word == no_neighbour) continue;
            const LeafEdge ours = edge_of(leaf, slot, was_pair(leaf));
            const auto [theirs, back] = across(word);
            auto here = ends(bvh, ours);
            if ((word >> 3 & 1) == 0) std::swap(here[0], here[1]);
            const bool joins =
                is_whole(leaf) && is_whole(theirs.leaf) && here[0] != here[1] && here == ends(bvh, theirs);
            put(neighbours[leaf][slot], joins ? word : no_neighbour);
            put(neighbours[theirs.leaf][back], joins ? built[theirs.leaf][back] : no_neighbour);
        }
    return changed;
}

}  // namespace penumbra
