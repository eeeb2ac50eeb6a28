// SPDX-License-Identifier: MIT
// Says what is wrong with a packing, by enumeration: every pass of every interval, every pair of intervals.
// Shares no code with graph/pack.h, whose results it judges.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace penumbra::test {

struct PlacedInterval {
    uint32_t first = 0, length = 0;  // passes on the circle
    uint64_t size = 0, alignment = 1, offset = 0;
};

struct PackingFault {
    enum class Kind { bytes_shared, misaligned, beyond_heap } kind;
    size_t a, b;    // intervals; b == a for faults of one alone
    uint32_t pass;  // the first pass where it shows
};

std::vector<PackingFault> packing_faults(const std::vector<PlacedInterval>& placed, uint32_t period,
                                         uint64_t heap);

// One line a fault, for test messages.
std::string describe(const std::vector<PackingFault>& faults);

}  // namespace penumbra::test
