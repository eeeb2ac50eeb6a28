// SPDX-License-Identifier: MIT
// Exhaustive branch and bound for small sets. An optimal packing can be chosen so that no interval can move
// lower; its intervals, sorted by the height of what supports them, then each rest on the skyline of those
// before. So the search fills the skyline's lowest level pass by pass: some interval starts there, or nothing
// does and the pass is closed up to the level of its neighbours. (Skyline branching as in exact strip
// packing: Martello, Monaci, Vigo 2003.) Pruned by each pass's remaining bytes, by intervals that would fit
// into space given up, by equal intervals, and by a table of failed states in which a state and its copy half
// a period later are one.
#include "graph/pack_search.h"

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <optional>
#include <tuple>

namespace penumbra {

namespace {

constexpr uint32_t max_items = 64, max_slots = 64;
constexpr uint64_t walled = UINT64_MAX;  // the height of a pass that nothing remaining lives in

uint64_t mix(uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

using Kind = std::tuple<uint64_t, uint64_t, uint64_t>;  // slots, size, alignment

struct Item {
    uint64_t slots;   // one bit per slot
    uint64_t size;    // bytes
    uint64_t padded;  // size rounded up to the least alignment, which every offset is a multiple of
    uint64_t alignment;
    uint32_t kind;      // equal for items that are interchangeable
    uint32_t interval;  // index in the caller's set
};

// A node of the search: what is placed, as far as it matters for what is left.
struct State {
    std::array<uint64_t, max_slots> height;
    std::array<uint64_t, max_slots> left;  // padded bytes still to be placed, per slot
    uint64_t remaining;                    // items
    uint64_t closed;                       // slots in which nothing starts at the lowest level
};

class Search {
  public:
    // `nodes` of `max_nodes` were visited before.
    Search(std::span<const Interval> intervals, uint32_t period, Packing packing, uint64_t nodes,
           uint64_t max_nodes, const SearchProgress& progress)
        : best_(std::move(packing)),
          offsets_(best_.offsets),
          budget_(max_nodes),
          nodes_(nodes),
          progress_(progress),
          failed_(1u << 18) {
        prepare(intervals, period);
    }

    // Limits from the lower bound up, each search showing what the next limit has to be, in the manner of
    // iterative deepening (Korf 1985): tight limits prune best, and the first packing found is near the
    // optimum. Limits grow by at least an eighth of what is open, so that many different sizes do not mean
    // many searches.
    SearchResult run(uint64_t bound) {
        State state{};
        state.remaining = items_.size() == 64 ? ~0ull : (1ull << items_.size()) - 1;
        for (uint32_t t = 0; t < slots_; ++t)
            for (const Item& item : items_)
                if (item.slots >> t & 1) state.left[t] += item.padded;
        const uint64_t heap = best_.heap;
        limit_ = bound;
        while (limit_ < best_.heap && nodes_ <= budget_) {
            next_limit_ = best_.heap;
            ++round_;
            if (fits(state)) visit(state);
            // A packing that was found lowered the limit until nothing was left below it.
            if (best_.heap < heap) break;
            limit_ = std::max(next_limit_, limit_ + (best_.heap - limit_) / 8);
        }
        return {std::move(best_), nodes_ <= budget_, nodes_};
    }

  private:
    struct Failed {
        uint64_t low = 0, high = 0;
    };

    // Passes whose live set is part of another's add nothing: the intervals stay arcs without them, and every
    // two that conflicted still do.
    void prepare(std::span<const Interval> intervals, uint32_t period) {
        std::vector<uint32_t> chosen;
        for (uint32_t i = 0; i < intervals.size(); ++i)
            if (intervals[i].size > 0) chosen.push_back(i);

        std::vector<uint64_t> live(period, 0);
        for (uint32_t k = 0; k < chosen.size(); ++k)
            for (uint32_t t = 0; t < intervals[chosen[k]].length; ++t)
                live[(intervals[chosen[k]].first + t) % period] |= 1ull << k;
        std::vector<uint64_t> kept;
        for (uint32_t t = 0; t < period; ++t) {
            bool dominated = live[t] == 0;
            for (uint32_t u = 0; u < period && !dominated; ++u)
                dominated = (live[t] & ~live[u]) == 0 && (live[t] != live[u] || u < t);
            if (!dominated) kept.push_back(live[t]);
        }
        slots_ = static_cast<uint32_t>(kept.size());

        uint64_t least = UINT64_MAX;
        for (uint32_t i : chosen) least = std::min(least, intervals[i].alignment);
        for (uint32_t k = 0; k < chosen.size(); ++k) {
            const Interval& v = intervals[chosen[k]];
            Item item{0, v.size, align_up(v.size, least), v.alignment, 0, chosen[k]};
            for (uint32_t t = 0; t < slots_; ++t) item.slots |= (kept[t] >> k & 1) << t;
            padding_ = std::max(padding_, item.padded - item.size);
            items_.push_back(item);
        }
        // Large ones are tried first; interchangeable ones are neighbours.
        std::stable_sort(items_.begin(), items_.end(), [](const Item& a, const Item& b) {
            const auto key = [](const Item& i) {
                return std::tuple(i.size, std::popcount(i.slots), i.slots, i.alignment);
            };
            return key(a) > key(b);
        });
        std::map<Kind, uint32_t> kinds;
        for (Item& item : items_)
            item.kind =
                kinds.try_emplace({item.slots, item.size, item.alignment}, kinds.size()).first->second;
        find_rotation(kinds);
    }

    // Histories come in pairs half a period apart; then every state is as good as its copy half a circle
    // later. Slots are in time order, one for each different live set, so turning the circle turns them too.
    void find_rotation(const std::map<Kind, uint32_t>& kinds) {
        if (slots_ % 2 != 0) return;
        std::vector<uint32_t> image(kinds.size()), count(kinds.size(), 0), image_count(kinds.size(), 0);
        for (const Item& item : items_) {
            const auto found = kinds.find({rotated(item.slots, slots_ / 2), item.size, item.alignment});
            if (found == kinds.end()) return;
            image[item.kind] = found->second;
            ++count[item.kind];
            ++image_count[found->second];
        }
        if (count == image_count) kind_image_ = image;
    }

    uint64_t rotated(uint64_t slots, uint32_t by) const {
        uint64_t result = 0;
        for (uint32_t t = 0; t < slots_; ++t) result |= (slots >> t & 1) << ((t + by) % slots_);
        return result;
    }

    uint64_t lowest_offset(const State& state, const Item& item) const {
        uint64_t height = 0;
        for (uint64_t slots = item.slots; slots; slots &= slots - 1)
            height = std::max(height, state.height[std::countr_zero(slots)]);
        return align_up(height, item.alignment);
    }

    // Whether what is left may fit below the limit: each item by itself, and in each slot all of its items on
    // top of each other, none below its own lowest offset (one machine with release dates).
    bool fits(const State& state) {
        struct Waiting {
            uint64_t lowest;
            const Item* item;
        };
        std::array<Waiting, max_items> waiting;
        size_t count = 0;
        for (uint64_t items = state.remaining; items; items &= items - 1) {
            const Item& item = items_[std::countr_zero(items)];
            const uint64_t lowest = lowest_offset(state, item);
            if (!within_limit(lowest + item.size)) return false;
            waiting[count++] = {lowest, &item};
        }
        std::sort(waiting.begin(), waiting.begin() + count,
                  [](const Waiting& a, const Waiting& b) { return a.lowest < b.lowest; });
        std::array<uint64_t, max_slots> top{};
        for (size_t k = 0; k < count; ++k)
            for (uint64_t slots = waiting[k].item->slots; slots; slots &= slots - 1) {
                uint64_t& t = top[std::countr_zero(slots)];
                t = std::max(t, waiting[k].lowest) + waiting[k].item->padded;
                if (!within_limit(t - padding_)) return false;
            }
        return true;
    }

    // The same where closed slots are known to go on at `above` or higher.
    bool fits_above(const State& state, uint64_t above) {
        State raised = state;
        for (uint64_t slots = state.closed; slots; slots &= slots - 1)
            raised.height[std::countr_zero(slots)] = above;
        return fits(raised);
    }

    bool within_limit(uint64_t heap) {
        if (heap <= limit_) return true;
        next_limit_ = std::min(next_limit_, heap);
        return false;
    }

    // Two hashes of a state, equal for its rotated copy. A false match would need 128 equal bits.
    // Each search for a larger limit starts anew; within one the limit only falls, so that what failed stays
    // failed.
    Failed fingerprint(const State& state) const {
        const auto hash = [&](uint32_t by, uint64_t seed) {
            uint64_t sum = round_;
            for (uint64_t items = state.remaining; items; items &= items - 1) {
                const uint32_t kind = items_[std::countr_zero(items)].kind;
                sum += mix(seed + 1 + (by ? kind_image_[kind] : kind));
            }
            for (uint32_t t = 0; t < slots_; ++t) {
                const uint64_t height = state.left[t] ? state.height[t] : walled;
                sum += mix(mix(height + seed) + uint64_t{(t + by) % slots_} * 2 + (state.closed >> t & 1));
            }
            return mix(sum);
        };
        constexpr uint64_t seed_low = 0x243f6a8885a308d3u, seed_high = 0x13198a2e03707344u;
        Failed sum{hash(0, seed_low), hash(0, seed_high)};
        if (kind_image_.empty()) return sum;
        return {sum.low + hash(slots_ / 2, seed_low), sum.high + hash(slots_ / 2, seed_high)};
    }

    void visit(const State& state);
    void raise_closed(State state, uint64_t level);

    Packing best_;
    std::vector<uint64_t> offsets_;  // of the branch under work
    uint64_t limit_ = 0;             // the largest heap looked for
    uint64_t next_limit_ = 0;        // the least heap that a pruned branch could have had
    uint64_t budget_, nodes_;
    const SearchProgress& progress_;
    uint64_t round_ = 0;
    std::vector<Failed> failed_;  // direct mapped; states from which no packing within the limit was found
    std::vector<Item> items_;
    uint32_t slots_ = 0;
    uint64_t padding_ =
        0;  // the most that an item's padded size exceeds its size, which the topmost one does not need
    std::vector<uint32_t>
        kind_image_;  // what each kind becomes half a circle later; empty where that is no symmetry
};

void Search::visit(const State& state) {
    if (state.remaining == 0) {
        best_ = {offsets_, 0};
        for (const Item& item : items_)
            best_.heap = std::max(best_.heap, offsets_[item.interval] + item.size);
        limit_ = best_.heap - 1;
        return;
    }
    if (++nodes_ > budget_) return;
    if (progress_ && nodes_ % 65'536 == 0) progress_(nodes_);

    const Failed print = fingerprint(state);
    Failed& seen = failed_[print.low % failed_.size()];
    if (seen.low == print.low && seen.high == print.high) return;

    uint64_t level = walled;
    for (uint32_t t = 0; t < slots_; ++t)
        if (state.left[t]) level = std::min(level, state.height[t]);
    uint64_t open = 0;
    for (uint32_t t = 0; t < slots_; ++t)
        if (state.left[t] && state.height[t] == level && !(state.closed >> t & 1)) open |= 1ull << t;

    // The items that can start on the level, one of each kind.
    uint64_t candidates = 0, covered = 0;
    uint32_t last_kind = UINT32_MAX;
    for (uint64_t items = state.remaining; items; items &= items - 1) {
        const int i = std::countr_zero(items);
        if ((items_[i].slots & ~open) != 0 || items_[i].kind == last_kind) continue;
        last_kind = items_[i].kind;
        candidates |= 1ull << i;
        covered |= items_[i].slots;
    }
    State next = state;
    next.closed |= open & ~covered;
    if (covered == 0) {
        raise_closed(next, level);
    } else {
        // What comes next in a closed slot rests on something higher: on a slot that is now, or on an item
        // that starts on this level.
        uint64_t above = walled;
        for (uint32_t t = 0; t < slots_; ++t)
            if (state.left[t] && state.height[t] > level) above = std::min(above, state.height[t]);
        for (uint64_t items = candidates; items; items &= items - 1)
            above = std::min(above, level + items_[std::countr_zero(items)].padded);
        if (next.closed && !fits_above(next, above)) covered = 0;

        // Branch where there is least to choose from.
        uint32_t slot = 0;
        int fewest = INT32_MAX;
        for (uint64_t slots = covered; slots; slots &= slots - 1) {
            const uint32_t t = static_cast<uint32_t>(std::countr_zero(slots));
            int count = above + state.left[t] - padding_ <= limit_;  // whether it can be closed
            for (uint64_t items = candidates; items; items &= items - 1)
                count += static_cast<int>(items_[std::countr_zero(items)].slots >> t & 1);
            if (count < fewest) {
                fewest = count;
                slot = t;
            }
        }
        for (uint64_t items = covered ? candidates : 0; items && nodes_ <= budget_; items &= items - 1) {
            const int i = std::countr_zero(items);
            const Item& item = items_[i];
            if (!(item.slots >> slot & 1)) continue;
            const uint64_t offset = align_up(level, item.alignment);
            if (!within_limit(offset + item.size)) continue;
            State placed = next;
            placed.remaining &= ~(1ull << i);
            for (uint64_t slots = item.slots; slots; slots &= slots - 1) {
                const int t = std::countr_zero(slots);
                placed.height[t] = offset + item.padded;
                placed.left[t] -= item.padded;
            }
            offsets_[item.interval] = offset;
            if (fits(placed)) visit(placed);
        }
        // Nothing starts here: something that does not fit on the level will come later.
        if (covered && nodes_ <= budget_) {
            State closing = next;
            closing.closed |= 1ull << slot;
            if (fits_above(closing, above)) visit(closing);
        }
    }
    if (nodes_ <= budget_) seen = print;
}

// Every slot on the level is closed: what comes next there also lives in a neighbouring slot, hence on its
// height.
void Search::raise_closed(State state, uint64_t level) {
    const auto height = [&](uint32_t t) { return state.left[t] ? state.height[t] : walled; };
    uint32_t start = slots_;
    for (uint32_t t = 0; t < slots_; ++t)
        if (height(t) != level) start = t;
    if (start == slots_) return;  // a level all around supports nothing that was not tried
    State raised = state;
    raised.closed = 0;
    for (uint32_t k = 1; k < slots_;) {
        if (height((start + k) % slots_) != level) {
            ++k;
            continue;
        }
        const uint32_t before = (start + k + slots_ - 1) % slots_;
        uint64_t run = 0;
        while (height((start + k) % slots_) == level) run |= 1ull << ((start + k++) % slots_);
        const uint64_t to = std::min(height(before), height((start + k) % slots_));
        if (to == walled) return;
        for (uint64_t slots = run; slots; slots &= slots - 1) raised.height[std::countr_zero(slots)] = to;
        // Where an item would fit into the space given up, it could move there: that packing is found
        // elsewhere.
        for (uint64_t items = state.remaining; items; items &= items - 1) {
            const Item& item = items_[std::countr_zero(items)];
            if ((item.slots & ~run) == 0 && align_up(level, item.alignment) + item.padded <= to) return;
        }
    }
    if (fits(raised)) visit(raised);
}

}  // namespace

SearchResult search_packing(std::span<const Interval> intervals, uint32_t period, Packing packing,
                            uint64_t max_nodes, const SearchProgress& progress) {
    uint64_t bound = lower_bound(intervals, period);
    if (packing.heap == bound) return {std::move(packing), true, 0};

    uint64_t largest = 0;
    size_t with_bytes = 0;
    for (const Interval& interval : intervals) {
        largest = std::max(largest, interval.size);
        with_bytes += interval.size > 0;
    }
    if (with_bytes > max_items || period > max_slots) return {std::move(packing), false, 0};

    // The large intervals alone are a smaller set to search, and often need as much by themselves.
    uint64_t nodes = 0;
    std::vector<Interval> large;
    Packing large_packing;
    for (size_t i = 0; i < intervals.size(); ++i) {
        if (intervals[i].size < (largest + 31) / 32) continue;
        large.push_back(intervals[i]);
        large_packing.offsets.push_back(packing.offsets[i]);
        large_packing.heap = std::max(large_packing.heap, packing.offsets[i] + intervals[i].size);
    }
    if (large.size() < with_bytes) {
        const SearchResult result =
            search_packing(large, period, std::move(large_packing), max_nodes / 2, progress);
        if (result.exhausted) bound = std::max(bound, result.best.heap);
        nodes = result.nodes;
        if (packing.heap == bound) return {std::move(packing), true, nodes};
    }
    return Search(intervals, period, std::move(packing), nodes, max_nodes, progress).run(bound);
}

SearchResult search_optimum(std::span<const Interval> intervals, uint32_t period, uint64_t max_nodes,
                            const SearchProgress& progress) {
    Packing packing = pack(intervals, period);
    uint64_t least = UINT64_MAX;
    for (const Interval& interval : intervals)
        if (interval.size > 0) least = std::min(least, interval.alignment);
    if (packing.heap - live_bound(intervals, period) < least)
        max_nodes = std::min(max_nodes, small_search_nodes);
    return search_packing(intervals, period, std::move(packing), max_nodes, progress);
}

std::optional<uint64_t> optimum(std::span<const Interval> intervals, uint32_t period, uint64_t max_nodes,
                                const SearchProgress& progress) {
    const SearchResult result = search_optimum(intervals, period, max_nodes, progress);
    if (!result.exhausted) return std::nullopt;
    return result.best.heap;
}

}  // namespace penumbra
