// SPDX-License-Identifier: MIT
// operator new of the programs that link this: counted, and made to fail.
#include "tests/allocations.h"

#include <cstdlib>
#include <new>

namespace penumbra::test {

thread_local size_t allocations = 0, failing_allocation = ~size_t{0};
std::atomic<long> live_allocations{0};

}  // namespace penumbra::test

static void* taken(size_t bytes) {
    using namespace penumbra::test;
    if (++allocations == failing_allocation) throw std::bad_alloc();
    void* memory = std::malloc(bytes ? bytes : 1);
    if (!memory) throw std::bad_alloc();
    ++live_allocations;
    return memory;
}
static void given_back(void* memory) {
    if (memory) --penumbra::test::live_allocations;
    std::free(memory);
}

void* operator new(size_t bytes) {
    return taken(bytes);
}
void* operator new[](size_t bytes) {
    return taken(bytes);
}
// The library's own would come here, but a sanitiser's do not.
void* operator new(size_t bytes, const std::nothrow_t&) noexcept {
    try {
        return taken(bytes);
    } catch (const std::bad_alloc&) {
        return nullptr;
    }
}
void* operator new[](size_t bytes, const std::nothrow_t& nothrow) noexcept {
    return operator new(bytes, nothrow);
}
void operator delete(void* memory) noexcept {
    given_back(memory);
}
void operator delete[](void* memory) noexcept {
    given_back(memory);
}
void operator delete(void* memory, size_t) noexcept {
    given_back(memory);
}
void operator delete[](void* memory, size_t) noexcept {
    given_back(memory);
}
