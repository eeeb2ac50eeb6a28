// SPDX-License-Identifier: MIT
// The words of leaf_neighbours(): mutual, and each names a triangle that has the same edge, on a closed
// surface for every edge; made anew, and refitted, after a refit that moves parts apart.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <set>
#include <stdexcept>

#include "host/bvh/bvh.h"

namespace penumbra {
namespace {

using Point = std::array<float, 3>;

constexpr uint32_t corner_vertex[2][3] = {{0, 1, 2}, {2, 1, 3}};

Point vertex(const Bvh& bvh, uint32_t leaf, uint32_t i) {
    Point p;
    for (uint32_t a = 0; a < 3; ++a)
        p[a] = std::bit_cast<float>(bvh.leaves[leaf * 3 + (i * 3 + a) / 4][(i * 3 + a) % 4]);
    return p;
}

bool is_pair(const Bvh& bvh, uint32_t leaf) {
    return vertex(bvh, leaf, 2) != vertex(bvh, leaf, 3);
}

// The ends of the edge opposite to a corner, in the order of the winding.
std::array<Point, 2> edge(const Bvh& bvh, uint32_t leaf, uint32_t which, uint32_t corner) {
    return {vertex(bvh, leaf, corner_vertex[which][(corner + 1) % 3]),
            vertex(bvh, leaf, corner_vertex[which][(corner + 2) % 3])};
}

struct Link {
    uint32_t leaf, which, corner, word;
};

// All words that belong to an edge of a triangle; see host/bvh/bvh.h.
std::vector<Link> links(const Bvh& bvh, const std::vector<Texel>& words) {
    std::vector<Link> out;
    for (uint32_t leaf = 0; leaf < words.size(); ++leaf) {
        out.push_back({leaf, 0, 2, words[leaf][0]});
        out.push_back({leaf, 0, 1, words[leaf][1]});
        if (is_pair(bvh, leaf)) {
            out.push_back({leaf, 1, 0, words[leaf][2]});
            out.push_back({leaf, 1, 1, words[leaf][3]});
        } else {
            out.push_back({leaf, 0, 0, words[leaf][2]});
            EXPECT_EQ(words[leaf][3], no_neighbour);
        }
    }
    return out;
}

void expect_consistent(const Bvh& bvh, const std::vector<Texel>& words) {
    const std::vector<Link> all = links(bvh, words);
    for (const Link& link : all) {
        if (link.word == no_neighbour) continue;
        const uint32_t leaf = link.word >> 4, which = link.word >> 2 & 1, corner = link.word & 3;
        ASSERT_LT(leaf, words.size());
        auto ours = edge(bvh, link.leaf, link.which, link.corner), theirs = edge(bvh, leaf, which, corner);
        EXPECT_EQ(ours == theirs, (link.word >> 3 & 1) != 0) << "the winding's bit";
        std::sort(ours.begin(), ours.end());
        std::sort(theirs.begin(), theirs.end());
        EXPECT_EQ(ours, theirs);
        const auto back = std::find_if(all.begin(), all.end(), [&](const Link& l) {
            return l.leaf == leaf && l.which == which && l.corner == corner;
        });
        ASSERT_NE(back, all.end());
        EXPECT_EQ(back->word >> 4, link.leaf);
        EXPECT_EQ(back->word >> 2 & 1, link.which);
        EXPECT_EQ(back->word & 3, link.corner);
    }
}

// A sphere of latitudes and longitudes: pairs, single triangles at the poles, one closed surface.
std::vector<Triangle> sphere(int rings, int sectors, bool mixed_windings) {
    std::vector<Triangle> out;
    const auto point = [&](int i, int j) {
        const double t = M_PI * i / rings, p = 2 * M_PI * (j % sectors) / sectors;
        if (i == 0 || i == rings) return Point{0, i == 0 ? 1.0f : -1.0f, 0};
        return Point{float(std::sin(t) * std::cos(p)), float(std::cos(t)), float(std::sin(t) * std::sin(p))};
    };
    const auto add = [&](Point a, Point b, Point c) {
        if (mixed_windings && out.size() % 3 == 0) std::swap(b, c);
        Triangle t;
        for (int k = 0; k < 3; ++k) t.v[0][k] = a[k], t.v[1][k] = b[k], t.v[2][k] = c[k];
        out.push_back(t);
    };
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < sectors; ++j) {
            if (i > 0) add(point(i, j), point(i, j + 1), point(i + 1, j));
            if (i + 1 < rings) add(point(i, j + 1), point(i + 1, j + 1), point(i + 1, j));
        }
    return out;
}

TEST(LeafNeighbours, JoinEveryEdgeOfAClosedSurface) {
    for (const bool mixed : {false, true}) {
        const Bvh bvh = build_bvh(sphere(9, 14, mixed));
        const std::vector<Texel> words = leaf_neighbours(bvh);
        ASSERT_EQ(words.size() * 3, bvh.leaves.size());
        expect_consistent(bvh, words);
        for (const Link& link : links(bvh, words)) {
            EXPECT_NE(link.word, no_neighbour);
            if (!mixed) {
                EXPECT_EQ(link.word >> 3 & 1, 0u);
            }
        }
    }
}

// A sheet with a front and a back: four triangles at its inner edges. Front belongs to front.
TEST(LeafNeighbours, KeepTheSidesOfADoubleSheetApart) {
    std::vector<Triangle> sheet;
    for (int x = 0; x < 6; ++x)
        for (const bool back : {false, true}) {
            const float a = float(x), b = float(x + 1);
            Triangle lower{{{a, 0, 0}, {b, 0, 0}, {a, 0, 1}}}, upper{{{b, 0, 0}, {b, 0, 1}, {a, 0, 1}}};
            if (back) {
                std::swap(lower.v[1], lower.v[2]);
                std::swap(upper.v[1], upper.v[2]);
            }
            sheet.push_back(lower);
            sheet.push_back(upper);
        }
    const Bvh bvh = build_bvh(sheet);
    const std::vector<Texel> words = leaf_neighbours(bvh);
    expect_consistent(bvh, words);
    size_t joined = 0;
    for (const Link& link : links(bvh, words))
        if (link.word != no_neighbour) {
            ++joined;
            EXPECT_EQ(link.word >> 3 & 1, 0u) << "joined across its own back";
        }
    EXPECT_GT(joined, 0u);
}

// Side by side, two triangles each.
std::vector<Triangle> four_squares() {
    std::vector<Triangle> strip;
    for (int x = 0; x < 4; ++x) {
        const float a = float(x), b = float(x + 1);
        strip.push_back({{{a, 0, 0}, {b, 0, 0}, {a, 0, 1}}});
        strip.push_back({{{b, 0, 0}, {b, 0, 1}, {a, 0, 1}}});
    }
    return strip;
}

TEST(LeafNeighbours, FollowARefitThatTakesPartsApart) {
    const std::vector<uint32_t> objects{0, 0, 1, 1, 2, 2, 3, 3};
    std::vector<Triangle> strip = four_squares();
    Bvh bvh = build_bvh(strip, objects);
    const auto joined = [&] {
        const std::vector<Texel> words = leaf_neighbours(bvh);
        expect_consistent(bvh, words);
        const std::vector<Link> all = links(bvh, words);
        return std::count_if(all.begin(), all.end(), [](const Link& l) { return l.word != no_neighbour; });
    };
    EXPECT_EQ(joined(), 6);
    for (size_t i = 4; i < strip.size(); ++i)
        for (auto& v : strip[i].v) v[1] += 1;
    ASSERT_TRUE(refit(bvh, strip));
    EXPECT_EQ(joined(), 4);
}

// Balls of which some move, shrink or lose triangles in each step.
TEST(LeafNeighbours, AreRefittedToWhatMakingThemAnewGives) {
    const std::vector<Triangle> ball = sphere(7, 10, false);
    std::vector<Triangle> start;
    std::vector<uint32_t> objects;
    for (uint32_t i = 0; i < 5; ++i)
        for (const Triangle& t : ball) {
            Triangle& turned = start.emplace_back();  // whose corners begin anywhere
            for (size_t k = 0; k < 3; ++k) {
                std::copy_n(t.v[(k + start.size()) % 3], 3, turned.v[k]);
                turned.v[k][0] += 3 * float(i);
            }
            objects.push_back(i);
        }
    Bvh bvh = build_bvh(start, objects);
    const std::vector<Texel> built = leaf_neighbours(bvh);
    std::vector<Texel> words = built;
    const auto moved_by = [&](uint32_t which, float by, size_t broken) {
        std::vector<Triangle> out = start;
        for (size_t i = 0; i < out.size(); ++i) {
            if (!(which >> objects[i] & 1)) continue;
            for (auto& v : out[i].v) v[1] = v[1] * (1 - 0.1f * by) + by;
            if (broken && i % broken == 0) out[i].v[i % 3][2] = std::numeric_limits<float>::quiet_NaN();
        }
        return out;
    };
    size_t changes = 0;
    const struct {
        uint32_t which;
        float by;
        size_t broken;
    } steps[] = {{2, 1, 0}, {6, 2, 0},     {8, 1, 3},     {24, 1.5f, 2},
                 {0, 0, 0}, {31, 0.5f, 5}, {31, 0.5f, 0}, {0, 0, 0}};
    for (const auto& step : steps) {
        Refitted written;
        ASSERT_TRUE(refit(bvh, moved_by(step.which, step.by, step.broken), &written));
        const std::vector<Texel> before = words;
        const bool changed = refit_neighbours(bvh, written.leaves, built, words);
        EXPECT_EQ(changed, words != before);
        changes += changed;
        expect_consistent(bvh, words);
        // A half of a pair joins nobody where words are refitted.
        if (!step.broken) {
            EXPECT_EQ(words, leaf_neighbours(bvh));
        }
    }
    EXPECT_EQ(changes, 5u);
    EXPECT_EQ(words, built);
}

TEST(LeafNeighbours, AreLostWhereEdgesComeApartAndBackWhereTheyMeetAgain) {
    const std::vector<Triangle> strip = four_squares();
    const std::vector<uint32_t> objects{0, 0, 1, 1, 2, 2, 3, 3};
    Bvh bvh = build_bvh(strip, objects);
    const std::vector<Texel> built = leaf_neighbours(bvh);
    std::vector<Texel> words = built, apart;
    for (const bool away : {true, false}) {
        std::vector<Triangle> now = strip;
        for (size_t i = 4; away && i < now.size(); ++i)
            for (auto& v : now[i].v) v[1] += 1;
        Refitted written;
        ASSERT_TRUE(refit(bvh, now, &written));
        EXPECT_EQ(written.leaves.size(), 2u) << "the other two stand still";
        EXPECT_TRUE(refit_neighbours(bvh, written.leaves, built, words));
        EXPECT_EQ(words, leaf_neighbours(bvh));
        if (away) apart = words;
    }
    EXPECT_NE(apart, built);
    EXPECT_EQ(words, built);
}

TEST(LeafNeighbours, OfAnEmptySceneAreNone) {
    const Bvh bvh = build_bvh({});
    std::vector<Texel> words = leaf_neighbours(bvh);
    ASSERT_EQ(words.size(), 1u);
    EXPECT_EQ(words[0], (Texel{no_neighbour, no_neighbour, no_neighbour, no_neighbour}));
    EXPECT_FALSE(refit_neighbours(bvh, {}, words, words));
}

TEST(LeafNeighbours, OfAnotherTreeAreRefused) {
    const std::vector<Triangle> strip = four_squares();
    const Bvh pairs = build_bvh(strip), larger = build_bvh(sphere(9, 14, false));
    const std::vector<uint32_t> objects{0, 1, 2, 3}, first{0};
    const std::vector<Triangle> half(strip.begin(), strip.begin() + 4);
    const Bvh singles = build_bvh(half, objects);  // as many leaves as `pairs` has
    ASSERT_EQ(singles.corners.size(), pairs.corners.size());
    std::vector<Texel> own = leaf_neighbours(pairs), theirs = leaf_neighbours(larger),
                       alike = leaf_neighbours(singles);
    const std::vector<Texel> before = own;
    const std::vector<uint32_t> all{0, 1, 2, 3}, beyond{4};
    EXPECT_THROW(refit_neighbours(pairs, first, theirs, own), std::invalid_argument);
    EXPECT_THROW(refit_neighbours(pairs, first, own, theirs), std::invalid_argument);
    EXPECT_THROW(refit_neighbours(pairs, beyond, own, own), std::invalid_argument);
    EXPECT_THROW(refit_neighbours(pairs, all, alike, own), std::invalid_argument);
    EXPECT_EQ(own, before);
}

}  // namespace
}  // namespace penumbra
