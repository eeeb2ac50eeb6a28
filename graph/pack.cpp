// SPDX-License-Identifier: MIT
// Greedy packing, then reinsertion. Placing each interval at its lowest feasible offset is first fit for
// dynamic storage allocation (Knuth, TAOCP 1, 2.5); the order decides how good it is and no one order is
// best, so several are tried (by size and by lifetime as in Sekiyama, Imai, Negishi 2018, "Profile-guided
// memory optimization for deep neural networks"). Reinsertion moves intervals within the best order found.
// Small sets end with a short exact search.
#include "graph/pack.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "graph/pack_scan.h"
#include "graph/pack_search.h"

namespace penumbra {

namespace {

// Orders are tried, and a table of who meets whom is kept, for as many intervals; beyond it one order has to
// do.
constexpr size_t most_compared = 2048;

// splitmix64 (Steele, Lea, Flood 2014): the same sequence on every platform, which <random>'s distributions
// are not.
class Sequence {
  public:
    uint32_t below(size_t bound) {
        state_ += 0x9e3779b97f4a7c15u;
        uint64_t z = state_;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return static_cast<uint32_t>((z ^ (z >> 31)) % bound);
    }

  private:
    uint64_t state_ = 0;
};

enum class Gap { lowest, tightest };

// Places intervals in a given order. Holds what all orders share: which pairs are live at the same time.
class Placer {
  public:
    Placer(std::span<const Interval> intervals, uint32_t period)
        : intervals_(intervals), count_(intervals.size()), conflicts_(count_ * count_) {
        for (size_t i = 0; i < count_; ++i)
            for (size_t j = i; j < count_; ++j)
                conflicts_[i * count_ + j] = conflicts_[j * count_ + i] =
                    overlap_in_time(intervals[i], intervals[j], period);
        placed_.reserve(count_);
    }

    // `order` names each interval that has bytes once; the others stay at offset 0.
    Packing place(std::span<const uint32_t> order, Gap gap) {
        Packing packing{std::vector<uint64_t>(count_, 0), 0};
        placed_.clear();
        for (uint32_t i : order) {
            const uint64_t offset = gap_for(i, gap);
            const uint64_t end = offset + intervals_[i].size;
            packing.offsets[i] = offset;
            packing.heap = std::max(packing.heap, end);
            const auto after =
                std::upper_bound(placed_.begin(), placed_.end(), offset,
                                 [](uint64_t value, const Placed& p) { return value < p.offset; });
            placed_.insert(after, {offset, end, i});
        }
        return packing;
    }

  private:
    struct Placed {
        uint64_t offset, end;
        uint32_t index;
    };

    // The lowest gap that fits, or the one that leaves the fewest bytes over; where none fits, above
    // everything.
    uint64_t gap_for(uint32_t i, Gap gap) const {
        const Interval& interval = intervals_[i];
        const uint8_t* conflicts = &conflicts_[i * count_];
        uint64_t offset = 0, best = 0, fewest_left_over = UINT64_MAX;
        for (const Placed& placed : placed_) {
            if (!conflicts[placed.index]) continue;
            const uint64_t end = offset + interval.size;
            if (placed.offset >= end) {
                if (gap == Gap::lowest) return offset;
                if (placed.offset - end < fewest_left_over) {
                    best = offset;
                    fewest_left_over = placed.offset - end;
                }
            }
            offset = std::max(offset, align_up(placed.end, interval.alignment));
        }
        return fewest_left_over == UINT64_MAX ? offset : best;
    }

    std::span<const Interval> intervals_;
    size_t count_;
    std::vector<uint8_t> conflicts_;  // count x count
    std::vector<Placed> placed_;      // by offset
};

// An order's result, less is better: the heap, then the passes of all intervals that reach its top, which
// leads the search across plateaus of equal heaps.
using Score = std::pair<uint64_t, uint64_t>;

Score score(const Packing& packing, std::span<const Interval> intervals) {
    uint64_t passes = 0;
    for (size_t i = 0; i < intervals.size(); ++i)
        if (packing.offsets[i] + intervals[i].size == packing.heap) passes += intervals[i].length;
    return {packing.heap, passes};
}

// Every key sorts its largest value first.
std::vector<std::vector<uint32_t>> greedy_orders(std::span<const Interval> intervals, uint32_t period) {
    std::vector<uint32_t> with_bytes;
    for (uint32_t i = 0; i < intervals.size(); ++i)
        if (intervals[i].size > 0) with_bytes.push_back(i);

    std::vector<std::vector<uint32_t>> orders;
    const auto add = [&](auto key) {
        orders.push_back(with_bytes);
        std::stable_sort(orders.back().begin(), orders.back().end(),
                         [&](uint32_t a, uint32_t b) { return key(intervals[a]) > key(intervals[b]); });
    };
    using Key = std::pair<uint64_t, uint64_t>;
    // By alignment is the order that keeps the heap within the sum of the aligned sizes, whatever the set.
    add([](const Interval& i) { return std::tuple(i.alignment, i.size, i.length); });
    add([](const Interval& i) { return Key(i.size, i.length); });
    add([](const Interval& i) { return Key(i.size * i.length, i.size); });
    add([](const Interval& i) { return Key(i.length, i.size); });
    // By birth and by death: what the classic linear scan does. Backwards too, which is the same set seen in
    // a mirror.
    add([&](const Interval& i) { return Key(period - i.first, i.length); });
    add([&](const Interval& i) { return Key(period - i.first, i.size); });
    add([](const Interval& i) { return Key(i.first + i.length, i.length); });
    add([](const Interval& i) { return Key(i.first + i.length, i.size); });
    // What wraps first: on the rest of the circle the remaining intervals are plain ones.
    add([&](const Interval& i) { return std::tuple(i.first + i.length > period, i.size, i.length); });
    add([&](const Interval& i) {
        return std::tuple(i.first + i.length > period, period - i.first, i.length);
    });
    return orders;
}

}  // namespace

bool overlap_in_time(const Interval& a, const Interval& b, uint32_t period) {
    const uint32_t from_a_to_b = (b.first + period - a.first) % period;
    const uint32_t from_b_to_a = (a.first + period - b.first) % period;
    return from_a_to_b < a.length || from_b_to_a < b.length;
}

uint64_t live_bound(std::span<const Interval> intervals, uint32_t period) {
    std::vector<uint64_t> change(period, 0);  // of what is live, from each time to the next, modulo 2^64
    uint64_t live = 0, largest = 0;           // at time 0 at first
    for (const Interval& interval : intervals) {
        if (interval.length == 0) continue;
        live += interval.length / period * interval.size;  // the laps that it makes whole
        const uint32_t rest = interval.length % period, end = (interval.first + rest) % period;
        if (rest == 0) continue;
        change[interval.first % period] += interval.size;
        change[end] -= interval.size;
        if (interval.first % period + rest >= period)
            live += interval.size;  // wraps: it is live before time 0 comes
    }
    for (uint32_t t = 0; t < period; ++t) {
        live += change[t];
        largest = std::max(largest, live);
    }
    return largest;
}

uint64_t lower_bound(std::span<const Interval> intervals, uint32_t period) {
    uint64_t longer_than_half = 0;
    for (const Interval& interval : intervals)
        if (2 * uint64_t{interval.length} > period) longer_than_half += interval.size;
    return std::max(live_bound(intervals, period), longer_than_half);
}

Packing pack(std::span<const Interval> intervals, uint32_t period) {
    const uint64_t bound = lower_bound(intervals, period);
    if (bound == 0) return {std::vector<uint64_t>(intervals.size(), 0), 0};
    // What no search is worth: less than one step of the offsets, or half a percent.
    uint64_t least = bound / 200;
    for (const Interval& interval : intervals) least = std::max(least, interval.alignment);
    const auto good = [&](const Packing& packing) { return packing.heap - bound < least; };

    if (intervals.size() > most_compared) return scan_packing(intervals, period);
    Placer placer(intervals, period);
    Packing best;
    struct Start {
        Score score;
        std::vector<uint32_t> order;
    };
    std::vector<Start> starts;  // by their scores
    for (const std::vector<uint32_t>& candidate : greedy_orders(intervals, period))
        for (Gap gap : {Gap::lowest, Gap::tightest}) {
            Packing packing = placer.place(candidate, gap);
            const Score found = score(packing, intervals);
            if (starts.empty() || found < starts.front().score) best = std::move(packing);
            starts.insert(std::ranges::upper_bound(starts, found, {}, &Start::score), {found, candidate});
            if (good(best)) return best;
        }

    // One step costs about n^2 operations, hence the count. Intervals at the top of the heap move to an
    // earlier place in the order; every fourth step moves any interval anywhere, to leave local minima. What
    // is still far off then starts from other orders as well.
    const uint64_t n = intervals.size();
    const uint64_t steps = std::min<uint64_t>(1000, 400'000'000 / (n * n));
    constexpr size_t most_starts = 4;
    Sequence random;
    for (size_t s = 0; s < most_starts && (s == 0 || best.heap - bound > bound / 50); ++s) {
        std::vector<uint32_t> order = std::move(starts[s].order);
        Packing current = placer.place(order, Gap::lowest);
        Score current_score = score(current, intervals);
        std::vector<uint32_t> at_top;
        for (uint64_t step = 0; step < steps && !good(best); ++step) {
            at_top.clear();
            for (uint32_t place = 0; place < order.size(); ++place)
                if (current.offsets[order[place]] + intervals[order[place]].size == current.heap)
                    at_top.push_back(place);
            const bool anywhere = step % 4 == 3;
            const uint32_t from = anywhere ? random.below(order.size()) : at_top[random.below(at_top.size())];
            const uint32_t to = random.below(anywhere ? order.size() : from + 1);

            std::vector<uint32_t> candidate = order;
            candidate.erase(candidate.begin() + from);
            candidate.insert(candidate.begin() + to, order[from]);
            Packing packing = placer.place(candidate, Gap::lowest);
            const Score candidate_score = score(packing, intervals);
            if (candidate_score > current_score) continue;
            order = std::move(candidate);
            current = std::move(packing);
            current_score = candidate_score;
            if (current.heap < best.heap) best = current;
        }
        if (s == 0 && !good(best))
            best = search_packing(intervals, period, std::move(best), small_search_nodes).best;
    }
    return best;
}

}  // namespace penumbra
