// SPDX-License-Identifier: MIT
#include "tests/gpu_test.h"

#include <cstdlib>

namespace penumbra::test {

Device& gpu() {
    const char* wish = std::getenv("PENUMBRA_TEST_DEVICE");
    static Device device({wish ? wish : "", true});
    return device;
}

}  // namespace penumbra::test
