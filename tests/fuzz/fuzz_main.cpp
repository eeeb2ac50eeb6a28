// SPDX-License-Identifier: MIT
// libFuzzer's entry. PENUMBRA_FUZZ_TARGET names the target (targets.h): one program serves all, and its flags
// are libFuzzer's own.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "tests/fuzz/targets.h"

namespace {

const penumbra::test::FuzzTarget* wanted = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
    using penumbra::test::fuzz_targets;
    const char* name = std::getenv("PENUMBRA_FUZZ_TARGET");
    const auto* const found =
        std::ranges::find(fuzz_targets, name ? name : std::string_view(), &penumbra::test::FuzzTarget::name);
    if (found != std::end(fuzz_targets)) return wanted = found, 0;
    std::fputs("PENUMBRA_FUZZ_TARGET is one of:", stderr);
    for (const auto& target : fuzz_targets) std::fprintf(stderr, " %s", target.name.data());
    std::fputs("\n", stderr);
    std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    wanted->run(std::as_bytes(std::span(data, size)));
    return 0;
}
