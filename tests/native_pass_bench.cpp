// SPDX-License-Identifier: MIT
// CPU milliseconds of one native pass (native_pass.h), the least of several runs; scripts/compare_cost.sh
// asks for it in turn with the pipelines. Usage: native_pass_bench WIDTHxHEIGHT
#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <limits>

#include "tests/native_pass.h"

using namespace penumbra::test;

int main(int count, char** words) {
    uint32_t width = 0, height = 0;
    char end = 0;
    if (count != 2 || std::sscanf(words[1], "%5ux%5u%c", &width, &height, &end) != 2 || width == 0 ||
        height == 0) {
        fmt::print(stderr, "usage: native_pass_bench WIDTHxHEIGHT\n");
        return 2;
    }
    if (!has_native_pass()) {
        fmt::print(stderr, "native_pass_bench: this processor has no AVX2, FMA or F16C\n");
        return 2;
    }
    const NativeImages images = native_images((width + 7) / 8 * 8, height);
    std::vector<uint32_t> out(images.signal.size());
    double least_ms = std::numeric_limits<double>::infinity();
    for (int run = 0; run < 50; ++run) {
        timespec before{}, after{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &before);
        native_pass(images, out);
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &after);
        least_ms = std::min(least_ms, 1e3 * double(after.tv_sec - before.tv_sec) +
                                          1e-6 * double(after.tv_nsec - before.tv_nsec));
    }
    fmt::print("{:.4f}\n", least_ms);
}
