// SPDX-License-Identifier: MIT
// The exact search behind optimum(): also pack()'s last step on small sets, within a small budget.
#pragma once

#include <cstdint>
#include <span>

#include "graph/pack.h"

namespace penumbra {

struct SearchResult {
    Packing best;  // the given packing, or a smaller one
    bool exhausted =
        true;  // nothing is smaller than `best`; false where the budget ran out before that was known
    uint64_t nodes = 0;  // search nodes visited
};

// Looks for packings smaller than `packing`, visiting at most `max_nodes` nodes. At most 64 intervals with
// bytes; beyond that the result is not exhausted. Deterministic.
SearchResult search_packing(std::span<const Interval> intervals, uint32_t period, Packing packing,
                            uint64_t max_nodes, const SearchProgress& progress = {});

// What optimum() does: starts from pack()'s packing. Where less than the least alignment is at stake, the
// budget is that of pack() itself: bytes of padding are not worth the seconds that a whole search may take.
SearchResult search_optimum(std::span<const Interval> intervals, uint32_t period, uint64_t max_nodes,
                            const SearchProgress& progress = {});

// What the exact search at the end of pack() may cost: at most a tenth of a second. Real pipelines take some
// hundred nodes.
inline constexpr uint64_t small_search_nodes = 20'000;

}  // namespace penumbra
