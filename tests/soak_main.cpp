// SPDX-License-Identifier: MIT
// soak FRAMES PIPELINE...: the windows of tests/soak.h as a Markdown table, and an exit status of 1 where the
// limits of docs/hard_cases.md are passed. No part of the tests: 100 000 frames take minutes.
#include <fmt/format.h>

#include <charconv>
#include <cstdio>
#include <ctime>
#include <string_view>

#include "tests/soak.h"

using namespace penumbra;
using namespace penumbra::test;

int main(int argc, char** argv) {
    uint32_t frames = 0;
    if (argc >= 3) {
        const std::string_view text = argv[1];
        std::from_chars(text.data(), text.data() + text.size(), frames);
    }
    if (frames < 1300) {
        std::fputs("usage: soak FRAMES PIPELINE... (at least 1300 frames)\n", stderr);
        return 2;
    }
    Device device({});
    bool held = true;
    for (int i = 2; i < argc; ++i) {
        const std::clock_t begin = std::clock();
        const Soak result = soak(device, {.pipeline = argv[i], .frames = frames});
        fmt::print(
            "{}, {} frames, {:.0f} s of processor time\n\n| frames from | N_eff | mean | KiB | open "
            "files |\n|---|---|---|---|---|\n",
            argv[i], frames, double(std::clock() - begin) / CLOCKS_PER_SEC);
        for (const SoakWindow& w : result.windows)
            fmt::print("| {} | {:.1f} | {:.6f} | {} | {} |\n", w.first, w.n_eff, w.mean, w.resident_kib,
                       w.open_files);
        fmt::print(
            "\nlast third against the first: drift of the mean {:.2g}, N_eff kept {:.3f} +- {:.3f}; left 3 "
            "frames "
            "after a "
            "jump {:.4f} (young history {:.4f}), not finite {}\n\n",
            result.drift(), result.n_eff_kept(), result.kept_noise(), result.left, result.left_of_young,
            result.nonfinite);
        std::fflush(stdout);
        held = held && soak_holds(result);
    }
    return held ? 0 : 1;
}
