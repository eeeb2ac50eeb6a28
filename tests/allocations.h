// SPDX-License-Identifier: MIT
// What is taken from operator new, which programs that link allocations.cpp replace.
#pragma once

#include <atomic>
#include <cstddef>

namespace penumbra::test {

extern thread_local size_t allocations;         // of this thread, so far
extern thread_local size_t failing_allocation;  // the count at which one throws std::bad_alloc
extern std::atomic<long> live_allocations;      // given out and not got back, by any thread

}  // namespace penumbra::test
