// SPDX-License-Identifier: MIT
// Preloaded: operator new throws at the call whose number PENUMBRA_FAIL_NEW_AT says. Only the program's own
// allocations that come after main began count; before it nobody could catch what is thrown.
#include <dlfcn.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<bool> running{false};
std::atomic<long> calls{0};

long wanted() {
    static const char* text = std::getenv("PENUMBRA_FAIL_NEW_AT");
    return text ? std::atol(text) : -1;
}

void* take(size_t bytes) {
    if (running.load() && ++calls == wanted()) throw std::bad_alloc();
    if (void* memory = std::malloc(bytes ? bytes : 1)) return memory;
    throw std::bad_alloc();
}

using Main = int (*)(int, char**, char**);
Main real_main = nullptr;
int watched_main(int count, char** arguments, char** environment) {
    running = true;
    const int code = real_main(count, arguments, environment);
    running = false;
    return code;
}
}  // namespace

void* operator new(size_t bytes) {
    return take(bytes);
}
void* operator new[](size_t bytes) {
    return take(bytes);
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete[](void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, size_t) noexcept {
    std::free(memory);
}
void operator delete[](void* memory, size_t) noexcept {
    std::free(memory);
}

extern "C" __attribute__((visibility("default"))) int __libc_start_main(Main main, int count,
                                                                        char** arguments, void (*init)(),
                                                                        void (*fini)(), void (*rtld_fini)(),
                                                                        void* stack_end) {
    real_main = main;
    using Start = int (*)(Main, int, char**, void (*)(), void (*)(), void (*)(), void*);
    const auto start = reinterpret_cast<Start>(dlsym(RTLD_NEXT, "__libc_start_main"));
    return start(watched_main, count, arguments, init, fini, rtld_fini, stack_end);
}
