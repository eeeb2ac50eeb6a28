// SPDX-License-Identifier: MIT
// libFuzzer's entry: the build names the target.
#include <cstdint>

#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    penumbra::test::PENUMBRA_FUZZ_TARGET(std::as_bytes(std::span(data, size)));
    return 0;
}
