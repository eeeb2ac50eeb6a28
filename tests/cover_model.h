// SPDX-License-Identifier: MIT
// The masks of the node `cover` in double precision: the same table, noise and formulas as
// shaders/visibility/light_mask.glsl, no tree, and no rounding but that to a whole number of samples.
#pragma once

#include <bit>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "penumbra/node_set.h"
#include "shaders/common/blocks.h"

namespace penumbra::test {

struct CoverMask {
    std::array<uint32_t, 8> words{};
    uint32_t count() const {
        uint32_t n = 0;
        for (const uint32_t w : words) n += uint32_t(std::popcount(w));
        return n;
    }
    bool has(uint32_t i) const { return (words[i / 32] >> i % 32 & 1) != 0; }
    CoverMask& operator|=(const CoverMask& b) {
        for (size_t i = 0; i < 8; ++i) words[i] |= b.words[i];
        return *this;
    }
    CoverMask& operator&=(const CoverMask& b) {
        for (size_t i = 0; i < 8; ++i) words[i] &= b.words[i];
        return *this;
    }
    friend bool operator==(const CoverMask&, const CoverMask&) = default;
};

class CoverModel {
  public:
    struct Line {
        uint32_t k = 0, bin = 0;
        bool flip = false;
        friend bool operator==(const Line&, const Line&) = default;
    };

    // `table`: as half_plane_table() makes it.
    CoverModel(uint32_t count, double angular_radius, std::vector<uint32_t> table)
        : count_(count),
          bulge_(0.25 * angular_radius * angular_radius),
          radius_(std::tan(angular_radius)),
          table_(std::move(table)) {}

    // With what the node was built with.
    CoverModel(uint32_t count, double angular_radius, const NodeSet& nodes)
        : CoverModel(count, angular_radius, words_of(nodes, "half_planes_" + std::to_string(count))) {}

    static std::vector<uint32_t> words_of(const NodeSet& nodes, const std::string& name) {
        for (const TableData& table : nodes.find("cover")->tables) {
            if (table.name != name) continue;
            std::vector<uint32_t> words(table.texels.size() / 4);
            std::memcpy(words.data(), table.texels.data(), words.size() * 4);
            return words;
        }
        return {};
    }

    uint32_t count() const { return count_; }
    double radius() const { return radius_; }
    double bulge() const { return bulge_; }

    // sun_disc() and the polynomial of light_line(): the light's share where x >= -c.
    double share(double c) const {
        const double k[5] = {0.6345046 + 0.6659715 * bulge_, -0.0742046 - 1.1252572 * bulge_,
                             -0.1463876 + 0.4592857 * bulge_, 0.1943180, -0.1082343};
        const double c2 = c * c;
        return 0.5 + c * (k[0] + c2 * (k[1] + c2 * (k[2] + c2 * (k[3] + c2 * k[4]))));
    }

    // light_line(): of the line e . (x, y, 1) >= 0 across the plane at distance 1.
    Line line(glm::dvec3 e, double dither) const {
        Line out;
        out.flip = (e.y != 0 ? e.y : e.x) < 0;
        if (out.flip) e = -e;
        const double inverse = 1 / std::max(std::abs(e.x) + e.y, 1e-37), p = e.x * inverse;
        const double size = std::abs(p), m = size - size * size;
        const double per_length =
            1.0000891 + m * (0.9840561 + m * (1.9511038 + m * (m * 18.8985459 - 1.7756891)));
        const double c = std::clamp(e.z * inverse / std::max(radius_, 1e-30) * per_length, -1.0, 1.0);
        out.k = uint32_t(std::floor(count_ * share(c) + dither));
        out.bin = uint32_t(
            std::floor(0.5 * (0.9999 * blocks::HALF_PLANE_DIRECTIONS * p + blocks::HALF_PLANE_DIRECTIONS)));
        return out;
    }

    CoverMask positive(const Line& line) const {
        CoverMask mask;
        const uint32_t words = count_ / 32;
        const uint32_t* entry = &table_[(size_t{line.bin} * (count_ + 1) + line.k) * words];
        for (uint32_t w = 0; w < words; ++w) mask.words[w] = line.flip ? ~entry[w] : entry[w];
        return mask;
    }
    CoverMask positive(const glm::dvec3& e, double dither) const { return positive(line(e, dither)); }

    // What a triangle hides; corners relative to the start, along the light's axes. `det`: the sign of the
    // start's height over its plane.
    CoverMask triangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double det,
                       double dither) const {
        if (det == 0) return {};
        // An edge's corners in the same order from either side, or rounding would tell them apart.
        const double sign = det < 0 ? -1 : 1;
        CoverMask mask = positive(sign * glm::cross(a, b), dither);
        mask &= positive(sign * glm::cross(b, c), dither);
        return mask &= positive(sign * glm::cross(c, a), dither);
    }

  private:
    uint32_t count_;
    double bulge_, radius_;
    std::vector<uint32_t> table_;
};

}  // namespace penumbra::test
