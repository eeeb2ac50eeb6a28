// SPDX-License-Identifier: MIT
// The hierarchy by itself: nothing leaks between triangles, boxes never hide a triangle, special values do no
// harm.
#include "host/bvh/bvh.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "tests/bvh_oracle.h"
#include "tests/bvh_scenes.h"

namespace penumbra {
namespace {

using namespace test;

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

Ray ray_to(Vec origin, Vec target) {
    const Vec d = target - origin;
    return {{origin.x, origin.y, origin.z}, {d.x, d.y, d.z}, 0, infinity};
}

Vec vertex(const Triangle& t, int k) {
    return {t.v[k][0], t.v[k][1], t.v[k][2]};
}

// Levels of the tree; also checks that every leaf and every node is reached exactly once.
uint32_t depth_of(const Bvh& bvh) {
    std::vector<int> nodes(bvh.nodes.size() / 3), leaves(bvh.corners.size());
    uint32_t deepest = 0;
    std::vector<std::pair<uint32_t, uint32_t>> work{{0, 1}};
    while (!work.empty()) {
        const auto [node, depth] = work.back();
        work.pop_back();
        ++nodes.at(node);
        deepest = std::max(deepest, depth);
        const Texel* t = &bvh.nodes[size_t(node) * 3];
        for (uint32_t k = 0; k < 4; ++k) {
            if (t[0][3] >> (24 + k) & 1) work.push_back({(t[1][0] >> 2) + k, depth + 1});
            if (t[0][3] >> (28 + k) & 1) ++leaves.at(t[1][1] + k);
        }
    }
    EXPECT_EQ(std::count(nodes.begin(), nodes.end(), 1), std::ssize(nodes));
    EXPECT_EQ(std::count(leaves.begin(), leaves.end(), 1), std::ssize(leaves));
    return deepest;
}

// Möller and Trumbore 1997 in single precision: the form that leaks, to show that a test's rays are hard
// enough.
bool moller_trumbore(const Triangle& t, const Ray& ray) {
    float e1[3], e2[3], s[3];
    for (int a = 0; a < 3; ++a) {
        e1[a] = t.v[1][a] - t.v[0][a];
        e2[a] = t.v[2][a] - t.v[0][a];
        s[a] = ray.origin[a] - t.v[0][a];
    }
    const auto cross = [](const float* a, const float* b, float* out) {
        for (int k = 0; k < 3; ++k)
            out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    };
    const auto dot = [](const float* a, const float* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
    float p[3], q[3];
    cross(ray.direction, e2, p);
    cross(s, e1, q);
    const float inverse = 1 / dot(e1, p), u = dot(s, p) * inverse, v = dot(ray.direction, q) * inverse;
    return u >= 0 && v >= 0 && u + v <= 1 && dot(e2, q) * inverse > ray.t_min;
}

TEST(Bvh, EmptySceneBlocksNothing) {
    const Bvh bvh = build_bvh({});
    EXPECT_EQ(bvh.nodes.size(), 3u);
    EXPECT_EQ(bvh.leaves.size(), 3u);
    EXPECT_FALSE(occluded(bvh, ray_to({0, 0, 0}, {1, 2, 3})));
    EXPECT_FALSE(occluded(bvh, ray_to({-1, -1, -1}, {0, 0, 0})));
    EXPECT_FALSE(occluded(Bvh{}, ray_to({0, 0, 0}, {1, 2, 3}))) << "nor does one that was never built";
}

TEST(Bvh, OneTriangleBlocksOnBothSidesAndOnlyWithinTheInterval) {
    const Triangle t = triangle({0, 0, 1}, {1, 0, 1}, {0, 1, 1});
    const Bvh bvh = build_bvh({&t, 1});
    EXPECT_EQ(bvh.corners.size(), 1u);
    Ray ray{{0.25f, 0.25f, 0}, {0, 0, 1}, 0, infinity};
    EXPECT_TRUE(occluded(bvh, ray));
    EXPECT_TRUE(occluded(bvh, {{0.25f, 0.25f, 2}, {0, 0, -1}, 0, infinity}));
    EXPECT_FALSE(occluded(bvh, {{0.75f, 0.75f, 0}, {0, 0, 1}, 0, infinity}));
    ray.t_max = 0.999f;
    EXPECT_FALSE(occluded(bvh, ray));
    ray.t_max = 1.001f;
    EXPECT_TRUE(occluded(bvh, ray));
    ray.t_min = 1.0005f;
    EXPECT_FALSE(occluded(bvh, ray));
    ray = {{0.25f, 0.25f, 2}, {0, 0, 1}, 0, infinity};  // behind the origin
    EXPECT_FALSE(occluded(bvh, ray));
}

TEST(Bvh, PairsShareOneLeafAndRespectObjects) {
    std::vector<Triangle> quads;
    add_quad(quads, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
    EXPECT_EQ(build_bvh(quads).corners.size(), 1u);
    const uint32_t objects[] = {0, 1};
    EXPECT_EQ(build_bvh(quads, objects).corners.size(), 2u);
    const uint32_t more[] = {0, 1, 2};
    EXPECT_THROW(build_bvh(quads, more), std::invalid_argument);
    EXPECT_THROW(build_bvh(quads, {objects, 1}), std::invalid_argument);
}

TEST(Bvh, ReachesEveryLeafOnceWithinTheDepthLimit) {
    for (const TriangleScene& scene : made_scenes()) {
        const Bvh bvh = build_bvh(scene.triangles);
        EXPECT_LE(depth_of(bvh), max_bvh_depth) << scene.name;
    }
    EXPECT_EQ(depth_of(build_bvh(geometric_series(6))), max_bvh_depth);
    // All centres equal.
    std::vector<Triangle> nested;
    for (int i = 1; i < 1000; ++i) {
        const float s = float(i);
        nested.push_back(triangle({-s, -s, 0}, {s, -s, 0}, {0, s, 0}));
    }
    EXPECT_LE(depth_of(build_bvh(nested)), max_bvh_depth);
}

TEST(Bvh, TellsHowFarItHasCome) {
    std::vector<double> shares;
    const std::vector<Triangle> triangles = soup(60000, 3);
    const Bvh told = build_bvh(triangles, {}, [&](double share) { shares.push_back(share); });
    EXPECT_EQ(told.nodes, build_bvh(triangles).nodes);
    EXPECT_GT(shares.size(), 30u);
    EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
    EXPECT_GT(shares.front(), 0);
    EXPECT_GT(shares.back(), 0.95);
    EXPECT_LE(shares.back(), 1);
}

TEST(Bvh, IsDeterministic) {
    const std::vector<Triangle> triangles = soup(5000, 3);
    const Bvh a = build_bvh(triangles), b = build_bvh(triangles);
    EXPECT_EQ(a.nodes, b.nodes);
    EXPECT_EQ(a.leaves, b.leaves);
}

// What the slab test's rounding is allowed to eat: every triangle stays 1/64 of a grid step, and 2^-20 of its
// own size, away from the planes of the box that stands for it.
TEST(Bvh, QuantisedBoxesKeepTheirDistance) {
    for (const TriangleScene& scene : made_scenes()) {
        const Bvh bvh = build_bvh(scene.triangles);
        for (size_t n = 0; n < bvh.nodes.size(); n += 3) {
            const Texel* t = &bvh.nodes[n];
            for (uint32_t k = 0; k < 4; ++k) {
                if (!(t[0][3] >> (28 + k) & 1)) continue;
                const auto& corners = bvh.corners[t[1][1] + k];
                double lo[3], hi[3], longest = 0;
                for (int a = 0; a < 3; ++a) {
                    lo[a] = infinity;
                    hi[a] = -infinity;
                    for (uint32_t c : corners) {
                        lo[a] = std::min(lo[a], double(scene.triangles[c / 3].v[c % 3][a]));
                        hi[a] = std::max(hi[a], double(scene.triangles[c / 3].v[c % 3][a]));
                    }
                    longest = std::max(longest, hi[a] - lo[a]);
                }
                const uint32_t planes[3][2] = {{t[1][2], t[1][3]}, {t[2][0], t[2][1]}, {t[2][2], t[2][3]}};
                for (int a = 0; a < 3; ++a) {
                    const double origin = std::bit_cast<float>(t[0][a]);
                    const double step = std::ldexp(1.0, int(t[0][3] >> (8 * a) & 255) - 127);
                    const double distance = 0.99 * (step / 64 + longest * 0x1p-20);
                    ASSERT_LE(origin + (planes[a][0] >> (8 * k) & 255) * step, lo[a] - distance)
                        << scene.name;
                    ASSERT_GE(origin + (planes[a][1] >> (8 * k) & 255) * step, hi[a] + distance)
                        << scene.name;
                }
            }
        }
    }
}

// A triangle alone in a tree answers by its own test alone; all together must answer the same, so no box may
// turn away a ray that a triangle would have stopped. Rays go through edges and vertices, along planes, from
// near and far.
TEST(Bvh, BoxesNeverHideATriangle) {
    for (const float scale : {1e-3f, 1.0f, 1e3f}) {
        std::vector<Triangle> triangles = soup(150, 4);
        for (const Triangle& t : thin_bars(60, 5)) triangles.push_back(t);
        for (const Triangle& t : closed_ball(2, {3, 2, 1}, 4)) triangles.push_back(t);
        add_box(triangles, {-9, -9, -9}, {9, -8.999f, 9});
        triangles = scaled(triangles, scale);
        const Bvh all = build_bvh(triangles);
        std::vector<Bvh> alone;
        for (const Triangle& t : triangles) alone.push_back(build_bvh({&t, 1}));

        Random random(6);
        int hits = 0;
        for (int i = 0; i < 12000; ++i) {
            const Triangle& t = triangles[random.bits() % triangles.size()];
            const int k = int(random.bits() % 3);
            const float along = i % 3 == 0 ? 0.0f : random.unit();
            const Vec target = vertex(t, k) + (vertex(t, (k + 1) % 3) - vertex(t, k)) * along;
            Vec origin = target + random_direction(random) * (scale * std::exp2(random.in(-8, 12)));
            if (i % 5 == 0) (i % 2 ? origin.y : origin.x) = i % 2 ? target.y : target.x;  // d.y or d.x = 0
            if (i % 7 == 0) origin.z = target.z;
            const Ray ray = ray_to(origin, target);
            bool any = false;
            for (const Bvh& one : alone) any = any || occluded(one, ray);
            ASSERT_EQ(occluded(all, ray), any) << "ray " << i << " at scale " << scale;
            hits += any;
        }
        EXPECT_GT(hits, 6000);
    }
}

TEST(Bvh, ClosedMeshesDoNotLeakAtEdgesAndVertices) {
    Random random(8);
    int leaks = 0, naive_leaks = 0;
    for (const float scale : {1e-3f, 1.0f, 1e3f}) {
        const std::vector<Triangle> ball = scaled(closed_ball(4, {1.5f, -2.25f, 30}, 5), scale);
        const Bvh bvh = build_bvh(ball);
        for (int i = 0; i < 350000; ++i) {
            // From inside, aimed at a vertex or a point on an edge: something must be in the way.
            const Triangle& t = ball[random.bits() % ball.size()];
            const int k = int(random.bits() % 3);
            const Vec a = vertex(t, k), b = vertex(t, (k + 1) % 3);
            const Vec target = i % 3 == 0 ? a : i % 3 == 1 ? (a + b) * 0.5f : a + (b - a) * random.unit();
            const Vec centre = Vec{1.5f, -2.25f, 30} * scale;
            const Vec origin =
                i % 16 ? centre + random_direction(random) * (scale * random.in(0, 4)) : centre;
            leaks += !occluded(bvh, ray_to(origin, target));
            if (i % 500 == 0) {
                bool any = false;
                for (const Triangle& one : ball) any = any || moller_trumbore(one, ray_to(origin, target));
                naive_leaks += !any;
            }
        }
    }
    EXPECT_EQ(leaks, 0);
    EXPECT_GT(naive_leaks, 0) << "the rays are too easy to prove anything";
}

// Small integers: origin, target and edges are exact, so rays meet edges and vertices exactly.
TEST(Bvh, ExactlyHitEdgesAndVerticesCount) {
    std::vector<Triangle> cube;  // every face of the cube as 8 x 8 x 2 triangles on the integer lattice
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-4.0f, 4.0f})
            for (int i = -4; i < 4; ++i)
                for (int j = -4; j < 4; ++j) {
                    const auto at = [&](int u, int v) {
                        float p[3];
                        p[axis] = side;
                        p[(axis + 1) % 3] = float(u);
                        p[(axis + 2) % 3] = float(v);
                        return Vec{p[0], p[1], p[2]};
                    };
                    add_quad(cube, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                }
    const Bvh bvh = build_bvh(cube);
    int leaks = 0, rays = 0;
    for (int ox = -3; ox <= 3; ++ox)
        for (int oy = -3; oy <= 3; ++oy)
            for (int oz = -3; oz <= 3; oz += 3)
                for (int dx = -8; dx <= 8; ++dx)
                    for (int dy = -8; dy <= 8; ++dy)
                        for (int dz = -8; dz <= 8; ++dz) {
                            if (dx == 0 && dy == 0 && dz == 0) continue;
                            const Ray ray{{float(ox), float(oy), float(oz)},
                                          {float(dx) / 2, dy == 0 ? -0.0f : float(dy) / 2, float(dz) / 2},
                                          0,
                                          infinity};
                            leaks += !occluded(bvh, ray);
                            ++rays;
                        }
    EXPECT_GT(rays, 700000);
    EXPECT_EQ(leaks, 0);
}

// Flat boxes and rays in their planes' directions: all directions with components -1, -0, +0, 1, origins on,
// beside and between the boxes' planes, against the oracle in double precision.
TEST(Bvh, AxisParallelRaysAgreeWithDoublePrecision) {
    std::vector<Triangle> flat;
    for (int i = 0; i < 5; ++i) {
        const float o = float(i) * 2;
        add_quad(flat, {o, 0, 0}, {o, 1, 0}, {o, 1, 1}, {o, 0, 1});
        add_quad(flat, {0, o, 3}, {1, o, 3}, {1, o, 4}, {0, o, 4});
        add_quad(flat, {3, 3, o}, {4, 3, o}, {4, 4, o}, {3, 4, o});
    }
    for (const float scale : {1e-3f, 1.0f, 1e3f}) {
        const std::vector<Triangle> triangles = scaled(flat, scale);
        const Bvh bvh = build_bvh(triangles);
        const float values[] = {-1, -0.0f, 0, 1}, places[] = {-1, 0, 0.25f, 1, 2, 3, 3.5f, 5};
        int decided = 0;
        for (float dx : values)
            for (float dy : values)
                for (float dz : values) {
                    if (dx == 0 && dy == 0 && dz == 0) continue;
                    for (float ox : places)
                        for (float oy : places)
                            for (float oz : places) {
                                const Ray ray{
                                    {ox * scale, oy * scale, oz * scale}, {dx, dy, dz}, 0, infinity};
                                const Truth t = truth(triangles, ray);
                                if (t == Truth::either) continue;
                                ++decided;
                                ASSERT_EQ(occluded(bvh, ray), t == Truth::blocked)
                                    << ox << ' ' << oy << ' ' << oz << " towards " << dx << ' ' << dy << ' '
                                    << dz;
                            }
                }
        EXPECT_GT(decided, 15000);
    }
}

TEST(Bvh, UnusableTrianglesChangeNothing) {
    const std::vector<Triangle> good = soup(2000, 9);
    std::vector<Triangle> mixed;
    uint32_t added = 0;
    for (size_t i = 0; i < good.size(); ++i) {
        if (i % 100 == 0) {
            const Vec a = vertex(good[i], 0), b = vertex(good[i], 1);
            mixed.push_back(triangle(a, b, {nan, 0, 0}));
            mixed.push_back(triangle({0, infinity, 0}, a, b));
            mixed.push_back(triangle(a, {0, 0, -1e38f}, b));
            mixed.push_back(triangle(a, a, b));
            mixed.push_back(triangle({0, 0, 0}, {1, 1, 1}, {3, 3, 3}));
            mixed.push_back(triangle(b, b, b));
            added += 6;
        }
        mixed.push_back(good[i]);
    }
    const Bvh clean = build_bvh(good), dirty = build_bvh(mixed);
    EXPECT_EQ(dirty.skipped.size(), added);
    EXPECT_TRUE(clean.skipped.empty());
    for (const Ray& ray : shadow_rays(good, 50000, 10)) ASSERT_EQ(occluded(clean, ray), occluded(dirty, ray));
}

}  // namespace
}  // namespace penumbra
