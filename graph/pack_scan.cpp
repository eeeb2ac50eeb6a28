// SPDX-License-Identifier: MIT
// Linear scan: intervals in the order of their births, each at the lowest gap among those that are live then
// (as registers are allotted: Poletto and Sarkar 1999). On a circle, what wraps is stacked first; the rest is
// a line from the seam on.
#include "graph/pack_scan.h"

#include <algorithm>
#include <tuple>

namespace penumbra {

namespace {

struct Placed {
    uint64_t offset, end;  // bytes
    uint32_t from, until;  // passes of this turn of the circle
};

class Scan {
  public:
    Scan(std::span<const Interval> intervals, uint32_t period)
        : intervals_(intervals), period_(period), packing_{std::vector<uint64_t>(intervals.size(), 0), 0} {}

    Packing run() {
        std::vector<uint32_t> seam, line;
        uint64_t apart = 0;
        for (uint32_t i = 0; i < intervals_.size(); ++i) {
            const Interval& v = intervals_[i];
            if (v.size == 0) continue;
            apart += align_up(v.size, v.alignment);
            (v.first + v.length > period_ ? seam : line).push_back(i);
        }
        stack(seam);
        for (const uint32_t i : seam) {
            const uint64_t offset = packing_.offsets[i], end = offset + intervals_[i].size;
            const uint32_t until = intervals_[i].first + intervals_[i].length - period_;
            live_.push_back({offset, end, 0, until});
            heads_.push_back({offset, end, intervals_[i].first, period_});
        }
        std::ranges::sort(line, {}, [&](uint32_t i) {
            return std::tuple(intervals_[i].first, period_ - intervals_[i].length, i);
        });
        uint32_t now = 0;
        for (const uint32_t i : line) {
            if (intervals_[i].first != now) {
                now = intervals_[i].first;
                std::erase_if(live_, [&](const Placed& p) { return p.until <= now; });
            }
            place(i);
        }
        if (packing_.heap <= apart) return std::move(packing_);
        line.insert(line.end(), seam.begin(), seam.end());  // gaps of alignment cost more than sharing saved
        packing_.heap = 0;
        stack(line);
        return std::move(packing_);
    }

  private:
    // One above the other, the largest alignment first, which wastes nothing beyond the sizes rounded up.
    void stack(std::vector<uint32_t>& those) {
        std::ranges::sort(those, {}, [&](uint32_t i) { return std::tuple(~intervals_[i].alignment, i); });
        for (const uint32_t i : those) {
            packing_.offsets[i] = align_up(packing_.heap, intervals_[i].alignment);
            packing_.heap = packing_.offsets[i] + intervals_[i].size;
        }
    }

    void place(uint32_t i) {
        const Interval& v = intervals_[i];
        const uint32_t until = v.first + v.length;
        uint64_t offset = 0;
        auto live = live_.begin();
        auto head = heads_.begin();  // both by offset
        while (live != live_.end() || head != heads_.end()) {
            const bool take_live =
                head == heads_.end() || (live != live_.end() && live->offset < head->offset);
            const Placed& other = take_live ? *live++ : *head++;
            if (!take_live && other.from >= until) continue;  // comes after this one has gone
            if (other.offset >= offset + v.size) break;
            offset = std::max(offset, align_up(other.end, v.alignment));
        }
        packing_.offsets[i] = offset;
        packing_.heap = std::max(packing_.heap, offset + v.size);
        const auto after = std::ranges::upper_bound(live_, offset, {}, &Placed::offset);
        live_.insert(after, {offset, offset + v.size, v.first, until});
    }

    std::span<const Interval> intervals_;
    uint32_t period_;
    Packing packing_;
    std::vector<Placed> live_, heads_;  // by offset: what is live now; what will be, up to the seam
};

}  // namespace

Packing scan_packing(std::span<const Interval> intervals, uint32_t period) {
    return Scan(intervals, period).run();
}

}  // namespace penumbra
