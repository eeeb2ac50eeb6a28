// SPDX-License-Identifier: MIT
// Ulichney 1993, "The void-and-cluster method for dither array generation": start from a few evenly spread
// points, rank them by taking away the one in the tightest cluster, then rank all other places by filling the
// largest void. Clusters and voids are the extremes of the points' Gaussian-blurred picture, kept as a
// running sum on a torus.
#include "nodes/tables/blue_noise.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace penumbra {
namespace {

// Ulichney's choice: narrower lets low frequencies in, wider loses the separation of neighbours.
constexpr double sigma = 1.5;
constexpr int reach = 8;  // the Gaussian's fixed-point value is below 1 beyond

class Torus {
  public:
    explicit Torus(uint32_t size) : size_(int(size)), set_(size * size, false), energy_(size * size, 0) {
        for (int y = -reach; y <= reach; ++y)
            for (int x = -reach; x <= reach; ++x)
                gauss_[y + reach][x + reach] =
                    int32_t(std::lround(std::ldexp(std::exp(-(x * x + y * y) / (2 * sigma * sigma)), 18)));
    }

    bool has(uint32_t at) const { return set_[at]; }

    void flip(uint32_t at) {
        set_[at] = !set_[at];
        const int sign = set_[at] ? 1 : -1, cx = int(at) % size_, cy = int(at) / size_;
        for (int y = -reach; y <= reach; ++y)
            for (int x = -reach; x <= reach; ++x)
                energy_[size_t((cy + y + size_) % size_ * size_ + (cx + x + size_) % size_)] +=
                    sign * gauss_[y + reach][x + reach];
    }

    uint32_t tightest_cluster() const {
        uint32_t best = 0;
        int32_t most = std::numeric_limits<int32_t>::min();
        for (uint32_t i = 0; i < energy_.size(); ++i)
            if (set_[i] && energy_[i] > most) {
                most = energy_[i];
                best = i;
            }
        return best;
    }

    uint32_t largest_void() const {
        uint32_t best = 0;
        int32_t least = std::numeric_limits<int32_t>::max();
        for (uint32_t i = 0; i < energy_.size(); ++i)
            if (!set_[i] && energy_[i] < least) {
                least = energy_[i];
                best = i;
            }
        return best;
    }

  private:
    int size_;
    std::vector<char> set_;
    std::vector<int32_t> energy_;
    int32_t gauss_[2 * reach + 1][2 * reach + 1];
};

}  // namespace

std::vector<uint32_t> void_and_cluster(uint32_t size, uint32_t seed) {
    const uint32_t texels = size * size, initial = std::max(texels / 10, 1u);
    Torus torus(size);
    uint32_t state = seed * 2654435761u + 12345u;
    for (uint32_t placed = 0; placed < initial;) {
        state = state * 1664525u +
                1013904223u;  // Numerical Recipes' LCG; its high bits are good enough to scatter
        const uint32_t at = uint32_t((uint64_t(state) * texels) >> 32);
        if (torus.has(at)) continue;
        torus.flip(at);
        ++placed;
    }
    // Even them out: move the most crowded point into the largest void until that is where it came from.
    for (;;) {
        const uint32_t from = torus.tightest_cluster();
        torus.flip(from);
        const uint32_t to = torus.largest_void();
        torus.flip(to);
        if (to == from) break;
    }

    std::vector<uint32_t> rank(texels);
    Torus thinned = torus;
    for (uint32_t r = initial; r-- > 0;) {
        const uint32_t at = thinned.tightest_cluster();
        thinned.flip(at);
        rank[at] = r;
    }
    // Ulichney changes to clusters of the minority beyond one half; with a blur that sums to a constant, the
    // tightest cluster of what is empty is the largest void of what is full, so one rule serves to the end.
    for (uint32_t r = initial; r < texels; ++r) {
        const uint32_t at = torus.largest_void();
        torus.flip(at);
        rank[at] = r;
    }
    return rank;
}

std::vector<uint32_t> blue_noise_table() {
    const std::vector<uint32_t> first = void_and_cluster(blue_noise_size, 1),
                                second = void_and_cluster(blue_noise_size, 2);
    constexpr uint32_t step = 65536 / (blue_noise_size * blue_noise_size);
    std::vector<uint32_t> table(first.size());
    for (size_t i = 0; i < table.size(); ++i)
        table[i] = (first[i] * step + step / 2) | (second[i] * step + step / 2) << 16;
    return table;
}

}  // namespace penumbra
