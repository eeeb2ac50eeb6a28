// SPDX-License-Identifier: MIT
#include "host/metrics/bias_map.h"

#include <algorithm>
#include <cmath>

namespace penumbra {
namespace {

constexpr int reach = 4;           // 9x9
constexpr double fewest = 81 / 2;  // counted pixels of a box

struct Cell {
    double error = 0, count = 0;
};

// Sums over [x - reach, x + reach] along a line of cells `stride` apart.
void box_sum(std::vector<Cell>& cells, size_t first, size_t stride, uint32_t length) {
    std::vector<Cell> before(length + 1);  // prefix sums
    for (uint32_t i = 0; i < length; ++i) {
        const Cell& c = cells[first + i * stride];
        before[i + 1] = {before[i].error + c.error, before[i].count + c.count};
    }
    for (uint32_t i = 0; i < length; ++i) {
        const uint32_t low = i > reach ? i - reach : 0, high = std::min(length, i + reach + 1);
        cells[first + i * stride] = {before[high].error - before[low].error,
                                     before[high].count - before[low].count};
    }
}

}  // namespace

std::optional<double> largest_bias_9x9(const ComparedFrame& frame) {
    check_sizes(frame, "largest_bias_9x9");
    std::vector<Cell> cells(frame.pixels());
    const auto seeds = static_cast<double>(frame.seeds.size());
    for (size_t p = 0; p < cells.size(); ++p) {
        if (!frame.counted[p]) continue;
        cells[p].count = 1;
        for (const std::span<const float> seed : frame.seeds) {
            const double value = static_cast<double>(seed[p]), truth = static_cast<double>(frame.truth[p]);
            cells[p].error += (std::isfinite(value) ? value - truth
                               : truth > 0.5        ? -truth
                                                    : 1 - truth) /
                              seeds;
        }
    }
    for (uint32_t y = 0; y < frame.height; ++y) box_sum(cells, size_t{y} * frame.width, 1, frame.width);
    for (uint32_t x = 0; x < frame.width; ++x) box_sum(cells, x, frame.width, frame.height);

    std::optional<double> largest;
    for (const Cell& cell : cells)
        if (cell.count > fewest) largest = std::max(largest.value_or(0), std::abs(cell.error / cell.count));
    return largest;
}

}  // namespace penumbra
