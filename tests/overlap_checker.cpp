// SPDX-License-Identifier: MIT
// As plain as it can be, since it is what the packer is judged by.
#include "tests/overlap_checker.h"

#include <sstream>

namespace penumbra::test {

namespace {

// live[pass] for one interval, by walking its passes one by one.
std::vector<bool> live_passes(const PlacedInterval& p, uint32_t period) {
    std::vector<bool> live(period, false);
    uint32_t pass = p.first;
    for (uint32_t step = 0; step < p.length; ++step) {
        live[pass] = true;
        ++pass;
        if (pass == period) pass = 0;
    }
    return live;
}

// Half-open byte ranges; an empty one shares nothing.
bool share_bytes(const PlacedInterval& a, const PlacedInterval& b) {
    if (a.size == 0 || b.size == 0) return false;
    const uint64_t begin = a.offset > b.offset ? a.offset : b.offset;
    const uint64_t end_a = a.offset + a.size, end_b = b.offset + b.size;
    return begin < (end_a < end_b ? end_a : end_b);
}

}  // namespace

std::vector<PackingFault> packing_faults(const std::vector<PlacedInterval>& placed, uint32_t period,
                                         uint64_t heap) {
    std::vector<PackingFault> faults;
    std::vector<std::vector<bool>> live;
    live.reserve(placed.size());
    for (const PlacedInterval& p : placed) live.push_back(live_passes(p, period));
    for (size_t a = 0; a < placed.size(); ++a) {
        if (placed[a].offset % placed[a].alignment != 0)
            faults.push_back({PackingFault::Kind::misaligned, a, a, placed[a].first});
        if (placed[a].offset + placed[a].size > heap)
            faults.push_back({PackingFault::Kind::beyond_heap, a, a, placed[a].first});
        for (size_t b = a + 1; b < placed.size(); ++b) {
            if (!share_bytes(placed[a], placed[b])) continue;
            for (uint32_t pass = 0; pass < period; ++pass)
                if (live[a][pass] && live[b][pass]) {
                    faults.push_back({PackingFault::Kind::bytes_shared, a, b, pass});
                    break;
                }
        }
    }
    return faults;
}

std::string describe(const std::vector<PackingFault>& faults) {
    std::ostringstream text;
    for (const PackingFault& fault : faults) {
        switch (fault.kind) {
            case PackingFault::Kind::bytes_shared:
                text << "intervals " << fault.a << " and " << fault.b << " share bytes in pass " << fault.pass
                     << '\n';
                break;
            case PackingFault::Kind::misaligned:
                text << "interval " << fault.a << " is not aligned\n";
                break;
            case PackingFault::Kind::beyond_heap:
                text << "interval " << fault.a << " ends beyond the heap\n";
                break;
        }
    }
    return text.str();
}

}  // namespace penumbra::test
