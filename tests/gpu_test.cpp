// SPDX-License-Identifier: MIT
#include "tests/gpu_test.h"

#include <cstdlib>

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define PENUMBRA_LEAKS_COUNT
#include <dlfcn.h>
#include <link.h>
#endif
#endif

namespace penumbra::test {
namespace {

// Drivers and layers stay where they are until the end: of one that is unloaded nobody could say that a leak
// is its own (tests/leaks.supp).
void keep_libraries() {
#ifdef PENUMBRA_LEAKS_COUNT
    ::dl_iterate_phdr(
        [](dl_phdr_info* info, size_t, void*) {
            if (*info->dlpi_name) ::dlopen(info->dlpi_name, RTLD_LAZY | RTLD_NOLOAD | RTLD_NODELETE);
            return 0;
        },
        nullptr);
#endif
}

}  // namespace

Device& gpu() {
    const char* wish = std::getenv("PENUMBRA_TEST_DEVICE");
    static Device device({wish ? wish : "", true});
    static const bool kept = (keep_libraries(), true);
    static_cast<void>(kept);
    return device;
}

}  // namespace penumbra::test
