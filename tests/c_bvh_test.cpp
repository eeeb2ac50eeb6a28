// SPDX-License-Identifier: MIT
// penumbra_bvh.h gives what bvh.h gives, word for word; errors are values. That it is C is
// tests/install_test.sh's to show.
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "host/bvh/bvh.h"
#include "host/bvh/penumbra_bvh.h"

namespace penumbra::test {
namespace {

template <class T>
T sized() {
    T t{};
    t.struct_size = sizeof t;
    return t;
}

class CBvh : public ::testing::Test {
  protected:
    // Two squares in one plane, of an object each, whose edges meet; and a triangle without a surface.
    CBvh() {
        for (const float x : {0.0f, 1.0f}) {
            triangles_.push_back({{{x, 0, 0}, {x + 1, 0, 0}, {x + 1, 0, 1}}});
            triangles_.push_back({{{x, 0, 0}, {x + 1, 0, 1}, {x, 0, 1}}});
        }
        triangles_.push_back({{{5, 5, 5}, {5, 5, 5}, {6, 5, 5}}});
        request_.triangles = triangles_[0].v[0];
        request_.triangle_count = uint32_t(triangles_.size());
        request_.objects = objects_;
        request_.neighbours = 1;
    }
    ~CBvh() override { penumbra_bvh_destroy(bvh_); }

    void make() { ASSERT_EQ(penumbra_bvh_create(&request_, &bvh_, &error_), PENUMBRA_OK) << error_.text; }
    penumbra_bvh_info info() {
        auto info = sized<penumbra_bvh_info>();
        EXPECT_EQ(penumbra_bvh_read(bvh_, &info, &error_), PENUMBRA_OK) << error_.text;
        return info;
    }
    penumbra_bvh_refitted refit_to(const std::vector<Triangle>& triangles) {
        auto refitted = sized<penumbra_bvh_refitted>();
        EXPECT_EQ(penumbra_bvh_refit(bvh_, triangles[0].v[0], uint32_t(triangles.size()), &refitted, &error_),
                  PENUMBRA_OK)
            << error_.text;
        return refitted;
    }

    std::vector<Triangle> triangles_;
    const uint32_t objects_[5] = {0, 0, 1, 1, 1};
    penumbra_bvh_request request_ = sized<penumbra_bvh_request>();
    penumbra_bvh_error error_ = sized<penumbra_bvh_error>();
    penumbra_bvh* bvh_ = nullptr;
};

void expect_words(const uint32_t* words, const std::vector<std::array<uint32_t, 4>>& list) {
    ASSERT_NE(words, nullptr);
    EXPECT_EQ(std::memcmp(words, list.data(), list.size() * sizeof list[0]), 0);
}

void expect_tree(const penumbra_bvh_info& info, const Bvh& own, const std::vector<Texel>& neighbours) {
    ASSERT_EQ(info.node_count * size_t{3}, own.nodes.size());
    ASSERT_EQ(info.leaf_count * size_t{3}, own.leaves.size());
    expect_words(info.nodes, own.nodes);
    expect_words(info.leaves, own.leaves);
    expect_words(info.neighbours, neighbours);
    expect_words(info.corners, own.corners);
    EXPECT_EQ((std::vector<uint32_t>{info.skipped, info.skipped + info.skipped_count}), own.skipped);
}

TEST_F(CBvh, ATreeIsMadeAndFollowsWhatMoves) {
    make();
    Bvh own = build_bvh(triangles_, objects_);
    const std::vector<Texel> built = leaf_neighbours(own);
    expect_tree(info(), own, built);
    EXPECT_EQ(info().skipped_count, 1u);

    // One square goes away, and comes back.
    const uint32_t* const nodes = info().nodes;
    std::vector<Triangle> moved = triangles_;
    for (size_t t = 2; t < 4; ++t)
        for (auto& v : moved[t].v) v[1] += 2;
    std::vector<Texel> neighbours = built;
    for (const auto* to : {&moved, &triangles_}) {
        const penumbra_bvh_refitted refitted = refit_to(*to);
        Refitted written;
        ASSERT_TRUE(refit(own, *to, &written));
        EXPECT_TRUE(refit_neighbours(own, written.leaves, built, neighbours));
        EXPECT_EQ(refitted.fits, 1u);
        EXPECT_EQ(refitted.neighbours_changed, 1u);
        EXPECT_EQ((std::vector<uint32_t>{refitted.nodes, refitted.nodes + refitted.node_count}),
                  written.nodes);
        EXPECT_EQ((std::vector<uint32_t>{refitted.leaves, refitted.leaves + refitted.leaf_count}),
                  written.leaves);
        EXPECT_EQ(refitted.leaf_count, 1u);
        expect_tree(info(), own, neighbours);
        EXPECT_EQ(info().nodes, nodes) << "in the same memory";
    }
    EXPECT_EQ(neighbours, built);
    const penumbra_bvh_refitted none = refit_to(triangles_);
    EXPECT_EQ(none.fits, 1u);
    EXPECT_EQ(none.node_count + none.leaf_count + none.neighbours_changed, 0u) << "nothing moved";

    // A shape that this tree cannot hold.
    moved = triangles_;
    moved[4].v[0][1] = 4;
    const penumbra_bvh_refitted other = refit_to(moved);
    EXPECT_EQ(other.fits, 0u);
    EXPECT_EQ(other.node_count + other.leaf_count, 0u);
    expect_tree(info(), own, built);
}

TEST_F(CBvh, NeighboursAreThereWhereTheyAreAskedFor) {
    request_.neighbours = 0;
    request_.objects = nullptr;
    make();
    expect_words(info().leaves, build_bvh(triangles_).leaves);
    EXPECT_EQ(info().neighbours, nullptr);
    triangles_[0].v[0][1] = triangles_[1].v[0][1] = 1;
    EXPECT_EQ(refit_to(triangles_).neighbours_changed, 0u);
}

TEST_F(CBvh, OfNothingThereIsATreeThatNoRayMeets) {
    request_ = sized<penumbra_bvh_request>();
    request_.neighbours = 1;
    make();
    const penumbra_bvh_info empty = info();
    EXPECT_EQ(empty.node_count, 1u);
    EXPECT_EQ(empty.leaf_count, 1u);
    EXPECT_EQ(empty.corners, nullptr);
    ASSERT_NE(empty.neighbours, nullptr);
    EXPECT_EQ(empty.neighbours[3], no_neighbour);
    auto refitted = sized<penumbra_bvh_refitted>();
    EXPECT_EQ(penumbra_bvh_refit(bvh_, nullptr, 0, &refitted, &error_), PENUMBRA_OK) << error_.text;
    EXPECT_EQ(refitted.fits, 1u);
}

// Of a newer header all is used that is known here, and nothing is written behind it.
TEST_F(CBvh, ANewerCallersStructsAreLonger) {
    const auto newer = []<class T>(const T& t) {
        struct Newer {
            T own;
            uint64_t more;
        } longer{t, 7};
        longer.own.struct_size = sizeof longer;
        return longer;
    };
    const auto request = newer(request_);
    auto error = newer(error_);
    auto info = newer(penumbra_bvh_info{});
    auto refitted = newer(penumbra_bvh_refitted{});
    ASSERT_EQ(penumbra_bvh_create(&request.own, &bvh_, &error.own), PENUMBRA_OK) << error.own.text;
    EXPECT_EQ(penumbra_bvh_read(bvh_, &info.own, &error.own), PENUMBRA_OK) << error.own.text;
    expect_words(info.own.leaves, build_bvh(triangles_, objects_).leaves);
    EXPECT_EQ(info.own.struct_size, sizeof info);
    EXPECT_EQ(info.more, 7u);
    EXPECT_EQ(penumbra_bvh_refit(bvh_, request_.triangles, 5, &refitted.own, &error.own), PENUMBRA_OK);
    EXPECT_EQ(refitted.own.fits, 1u);
    EXPECT_EQ(refitted.own.struct_size, sizeof refitted);
    EXPECT_EQ(refitted.more, 7u);
    EXPECT_EQ(penumbra_bvh_read(bvh_, nullptr, &error.own), PENUMBRA_USAGE);
    EXPECT_STREQ(error.own.text, "info is null");
    EXPECT_EQ(error.own.struct_size, sizeof error);
    EXPECT_EQ(error.more, 7u);
}

// Shorter than the first header had them they cannot be: nothing is read of them or written to them. To the
// last member is enough, without what a compiler may put behind it.
TEST_F(CBvh, NoStructIsShorterThanTheFirst) {
    const auto until = []<class T, class M>(T& t, M T::*last, bool with_it) {
        const auto* end = reinterpret_cast<const char*>(&(t.*last)) + (with_it ? sizeof(M) : 0);
        t.struct_size = static_cast<uint32_t>(end - reinterpret_cast<const char*>(&t));
    };
    make();
    for (const bool whole : {false, true}) {
        const penumbra_code code = whole ? PENUMBRA_OK : PENUMBRA_USAGE;
        penumbra_bvh* other = nullptr;
        until(request_, &penumbra_bvh_request::neighbours, whole);
        EXPECT_EQ(penumbra_bvh_create(&request_, &other, &error_), code);
        EXPECT_EQ(other != nullptr, whole);
        penumbra_bvh_destroy(other);
        penumbra_bvh_info info{};
        until(info, &penumbra_bvh_info::skipped, whole);
        EXPECT_EQ(penumbra_bvh_read(bvh_, &info, &error_), code);
        EXPECT_EQ(info.nodes != nullptr, whole);
        penumbra_bvh_refitted refitted{};
        until(refitted, &penumbra_bvh_refitted::neighbours_changed, whole);
        EXPECT_EQ(penumbra_bvh_refit(bvh_, request_.triangles, 5, &refitted, &error_), code);
        EXPECT_EQ(refitted.fits, whole);
        std::strcpy(error_.text, "before");
        until(error_, &penumbra_bvh_error::text, whole);
        EXPECT_EQ(penumbra_bvh_read(bvh_, nullptr, &error_), PENUMBRA_USAGE);
        EXPECT_STREQ(error_.text, whole ? "info is null" : "before");
    }
}

TEST_F(CBvh, ACallersMistakesAreSaid) {
    EXPECT_EQ(penumbra_bvh_create(nullptr, nullptr, nullptr), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_bvh_create(nullptr, &bvh_, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.text, "request is null");
    penumbra_bvh_request wrong = request_;
    wrong.struct_size = 0;
    EXPECT_EQ(penumbra_bvh_create(&wrong, &bvh_, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.text, "request.struct_size is no size of this struct; is it set?");
    wrong = request_;
    wrong.triangles = nullptr;
    EXPECT_EQ(penumbra_bvh_create(&wrong, &bvh_, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.text, "triangles is null");
    wrong = request_;
    wrong.triangle_count = (1u << 30) + 1;
    EXPECT_EQ(penumbra_bvh_create(&wrong, &bvh_, &error_), PENUMBRA_USAGE);
    EXPECT_STREQ(error_.text, "triangle_count is beyond 2^30");
    EXPECT_EQ(bvh_, nullptr);
    EXPECT_EQ(penumbra_bvh_read(nullptr, nullptr, &error_), PENUMBRA_USAGE);
    EXPECT_EQ(penumbra_bvh_refit(nullptr, nullptr, 0, nullptr, &error_), PENUMBRA_USAGE);
    penumbra_bvh_destroy(nullptr);

    make();
    EXPECT_EQ(error_.code, PENUMBRA_OK);
    EXPECT_STREQ(error_.text, "");
    auto refitted = sized<penumbra_bvh_refitted>();
    EXPECT_EQ(penumbra_bvh_refit(bvh_, request_.triangles, 4, &refitted, &error_), PENUMBRA_USAGE);
    EXPECT_NE(std::strstr(error_.text, "4 triangles, the tree was built of 5"), nullptr) << error_.text;
    std::vector<Triangle> moved = triangles_;
    moved[0].v[0][1] = moved[1].v[0][1] = 1;
    refitted.struct_size = 0;
    EXPECT_EQ(penumbra_bvh_refit(bvh_, moved[0].v[0], 5, &refitted, &error_), PENUMBRA_USAGE);
    expect_words(info().leaves, build_bvh(triangles_, objects_).leaves);
    auto unset = penumbra_bvh_info{};
    EXPECT_EQ(penumbra_bvh_read(bvh_, &unset, &error_), PENUMBRA_USAGE);
    EXPECT_EQ(unset.nodes, nullptr);
}

}  // namespace
}  // namespace penumbra::test
