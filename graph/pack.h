// SPDX-License-Identifier: MIT
// Offsets for resources that live in intervals on a circle: dynamic storage allocation with wrap-around
// lifetimes. Pure functions. Intervals are {first, length} on a circle of `period` passes, since a begin/end
// pair could not tell a full circle from an empty interval.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "graph/align_up.h"

namespace penumbra {

struct Interval {
    uint32_t first = 0;      // in [0, period)
    uint32_t length = 1;     // in [1, period]; first + length may exceed the period (wraps)
    uint64_t size = 0;       // bytes; 0 is legal and takes offset 0
    uint64_t alignment = 1;  // power of two
};

struct Packing {
    std::vector<uint64_t> offsets;  // one per interval
    uint64_t heap = 0;              // max(offset + size)
};

// Whether two intervals are live at the same time.
bool overlap_in_time(const Interval& a, const Interval& b, uint32_t period);

// The largest sum of sizes live at one time: no packing can be smaller.
uint64_t live_bound(std::span<const Interval> intervals, uint32_t period);

// What no packing can be smaller than: that, and the sum of what lives for more than half the circle, of
// which any two meet somewhere (a history that its own pass reads, in both parities).
uint64_t lower_bound(std::span<const Interval> intervals, uint32_t period);

// A packing: several greedy orders, then reinsertion, on small sets then a short exact search; all
// deterministic and bounded by counted steps, never by time; each ends where less than one alignment or half
// a percent is left above the lower bound. Never larger than the sum of the aligned sizes.
Packing pack(std::span<const Interval> intervals, uint32_t period);

using SearchProgress = std::function<void(uint64_t nodes)>;

// The smallest possible heap by exhaustive search, or nothing where `max_nodes` search nodes do not suffice
// (a node takes one to two microseconds; a tenth of a second at most where less than an alignment is at
// stake) or where there are more than 64 intervals with bytes or 64 passes.
// `progress` is called with the nodes visited, every 65 536 of them.
std::optional<uint64_t> optimum(std::span<const Interval> intervals, uint32_t period,
                                uint64_t max_nodes = 2'000'000, const SearchProgress& progress = {});

}  // namespace penumbra
