// SPDX-License-Identifier: MIT
// What a thread takes from operator new, which this program's own replaces (steady_state_test.cpp).
#pragma once

#include <cstddef>

namespace penumbra::test {

extern thread_local size_t allocations;         // so far
extern thread_local size_t failing_allocation;  // the count at which one throws std::bad_alloc

}  // namespace penumbra::test
