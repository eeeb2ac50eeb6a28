// SPDX-License-Identifier: MIT
// Preloaded: operator new throws at the first call of the program from the one on whose number
// PENUMBRA_FAIL_NEW_AT says, and says so on the standard error stream. Only calls that come after main began
// count; before it nobody could catch what is thrown. Calls from within a Vulkan driver or loader are not the
// program's: LLVM, for one, ends the process where it gets no memory.
#include <dlfcn.h>
#include <execinfo.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <new>

namespace {
std::atomic<bool> running{false}, failed{false};
std::atomic<long> calls{0};
thread_local bool looking = false;

long wanted() {
    static const char* text = std::getenv("PENUMBRA_FAIL_NEW_AT");
    static const long number = text ? std::atol(text) : -1;
    return number;
}

bool is_of_a_driver(const void* code) {
    Dl_info info;
    if (!dladdr(code, &info) || !info.dli_fname) return true;  // made at run time
    for (const char* name : {"libvulkan", "libLLVM", "libVkLayer", "libgallium"})
        if (std::strstr(info.dli_fname, name)) return true;
    return false;
}

bool is_the_programs(const void* caller) {
    if (is_of_a_driver(caller)) return false;
    std::array<void*, 64> frames;
    const int count = backtrace(frames.data(), int(frames.size()));
    for (int i = 0; i < count; ++i)
        if (is_of_a_driver(frames[static_cast<size_t>(i)])) return false;
    return true;
}

void* take(size_t bytes, const void* caller) {
    if (running.load() && !looking && ++calls >= wanted() && wanted() > 0 && !failed.load()) {
        looking = true;
        const bool fails = is_the_programs(caller) && !failed.exchange(true);
        looking = false;
        if (fails) {
            static_cast<void>(!::write(2, "[memory ends]\n", 14));
            throw std::bad_alloc();
        }
    }
    if (void* memory = std::malloc(bytes ? bytes : 1)) return memory;
    throw std::bad_alloc();
}

using Main = int (*)(int, char**, char**);
Main real_main = nullptr;
int watched_main(int count, char** arguments, char** environment) {
    void* frame = nullptr;
    backtrace(&frame, 1);  // which takes memory when it is first called
    running = true;
    const int code = real_main(count, arguments, environment);
    running = false;
    return code;
}
}  // namespace

void* operator new(size_t bytes) {
    return take(bytes, __builtin_return_address(0));
}
void* operator new[](size_t bytes) {
    return take(bytes, __builtin_return_address(0));
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
