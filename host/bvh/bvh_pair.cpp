// SPDX-License-Identifier: MIT
// Which triangles become one leaf. Every edge shared by two triangles is a candidate pair; candidates are
// taken greedily, the ones whose common box saves most first. Edges are matched by position, so indexed
// meshes and soups alike find their neighbours; ties fall to the lower triangle number, so the result depends
// on the input alone.
#include <bit>
#include <cmath>

#include "host/bvh/bvh_internal.h"

namespace penumbra {

bool usable(const Triangle& t) {
    for (const auto& v : t.v)
        for (float x : v)
            if (!(std::abs(x) <= max_coordinate)) return false;  // false for NaN too
    // In double the differences are exact enough that only true lines and points vanish.
    double e[3], f[3];
    for (int a = 0; a < 3; ++a) {
        e[a] = double(t.v[1][a]) - t.v[0][a];
        f[a] = double(t.v[2][a]) - t.v[0][a];
    }
    const double x = e[1] * f[2] - e[2] * f[1], y = e[2] * f[0] - e[0] * f[2], z = e[0] * f[1] - e[1] * f[0];
    return x != 0 || y != 0 || z != 0;
}

namespace bvh_detail {

Box leaf_box(const Texel leaf[3]) {
    if (std::all_of(leaf, leaf + 3, [](const Texel& texel) { return texel == Texel{}; })) return {};
    Box box;
    for (size_t i = 0; i < 4; ++i) {
        float p[3];
        for (size_t a = 0; a < 3; ++a) p[a] = std::bit_cast<float>(leaf[(3 * i + a) / 4][(3 * i + a) % 4]);
        box.add(p);
    }
    float longest = 0;
    for (int a = 0; a < 3; ++a) longest = std::max(longest, box.hi[a] - box.lo[a]);
    const float pad = longest * 0x1p-20f;
    for (int a = 0; a < 3; ++a) {
        box.lo[a] = std::nextafter(box.lo[a] - pad, -std::numeric_limits<float>::infinity());
        box.hi[a] = std::nextafter(box.hi[a] + pad, std::numeric_limits<float>::infinity());
    }
    return box;
}

namespace {

using Bits = std::array<uint32_t, 3>;

Bits bits_of(const std::array<float, 3>& v) {
    Bits p;
    for (size_t a = 0; a < 3; ++a) p[a] = std::bit_cast<uint32_t>(v[a] + 0.0f);  // -0 becomes +0
    return p;
}

}  // namespace

std::vector<uint32_t> position_numbers(std::span<const std::array<float, 3>> positions) {
    const size_t count = positions.size();
    const size_t mask = std::bit_ceil(count * 2 + 1) - 1;
    constexpr uint32_t none = ~0u;
    std::vector<uint32_t> table(mask + 1, none), number(count);
    for (uint32_t c = 0; c < count; ++c) {
        const Bits p = bits_of(positions[c]);
        uint64_t h = (uint64_t(p[0]) * 0x9E3779B97F4A7C15u) ^ (uint64_t(p[1]) * 0xC2B2AE3D27D4EB4Fu) ^
                     (uint64_t(p[2]) * 0x165667B19E3779F9u);
        h ^= h >> 29;
        for (size_t slot = h & mask;; slot = (slot + 1) & mask) {
            if (table[slot] == none) table[slot] = c;
            if (bits_of(positions[table[slot]]) == p) {
                number[c] = table[slot];
                break;
            }
        }
    }
    return number;
}

namespace {

struct TriangleSide {
    uint64_t key;
    uint32_t opposite;  // triangle * 3 + the corner opposite to the edge
    friend auto operator<=>(const TriangleSide&, const TriangleSide&) = default;
};

struct Candidate {
    float cost;  // area of the common box over the sum of both
    uint32_t a, b;
    friend auto operator<=>(const Candidate&, const Candidate&) = default;
};

uint32_t next(uint32_t c) {
    return c % 3 == 2 ? c - 2 : c + 1;
}

}  // namespace

std::vector<Corners> pair_triangles(std::span<const Triangle> triangles, std::span<const uint32_t> objects,
                                    std::vector<uint32_t>& skipped) {
    const uint32_t count = uint32_t(triangles.size());
    std::vector<bool> done(count, false);
    std::vector<Box> boxes(count);
    for (uint32_t t = 0; t < count; ++t) {
        if (!usable(triangles[t])) {
            skipped.push_back(t);
            done[t] = true;
        } else {
            for (const auto& v : triangles[t].v) boxes[t].add(v);
        }
    }

    const std::vector<uint32_t> number = position_numbers(
        {reinterpret_cast<const std::array<float, 3>*>(triangles.data()), count * size_t{3}});
    std::vector<TriangleSide> edges;
    edges.reserve(size_t(count) * 3);
    for (uint32_t c = 0; c < count * 3; ++c) {
        if (done[c / 3]) continue;
        const uint32_t a = number[next(c)], b = number[next(next(c))];
        edges.push_back({uint64_t(std::min(a, b)) << 32 | std::max(a, b), c});
    }
    std::sort(edges.begin(), edges.end());

    std::vector<Candidate> candidates;
    for (size_t i = 0; i + 1 < edges.size(); ++i) {
        if (edges[i].key != edges[i + 1].key) continue;
        const uint32_t a = edges[i].opposite, b = edges[i + 1].opposite;
        if (a / 3 == b / 3 || (!objects.empty() && objects[a / 3] != objects[b / 3])) continue;
        Box both = boxes[a / 3];
        both.add(boxes[b / 3]);
        const float cost = float(both.area() / (boxes[a / 3].area() + boxes[b / 3].area()));
        if (cost < 1) candidates.push_back({cost, a, b});
    }
    std::sort(candidates.begin(), candidates.end());

    std::vector<Corners> leaves;
    leaves.reserve(count / 2 + 1);
    for (const Candidate& c : candidates) {
        if (done[c.a / 3] || done[c.b / 3]) continue;
        done[c.a / 3] = done[c.b / 3] = true;
        leaves.push_back({c.a, next(c.a), next(next(c.a)), c.b});
    }
    for (uint32_t t = 0; t < count; ++t)
        if (!done[t]) leaves.push_back({t * 3, t * 3 + 1, t * 3 + 2, t * 3 + 2});
    return leaves;
}

}  // namespace bvh_detail
}  // namespace penumbra
