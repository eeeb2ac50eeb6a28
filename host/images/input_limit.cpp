// SPDX-License-Identifier: MIT
#include "host/images/input_limit.h"

#include <fmt/format.h>

#include <charconv>
#include <cstdlib>
#include <stdexcept>
#include <string_view>

namespace penumbra {

namespace {

constexpr const char* variable = "PENUMBRA_INPUT_LIMIT_MIB";

uint64_t limit_mib() {
    const char* set = std::getenv(variable);
    if (!set) return 2048;
    const std::string_view text(set);
    uint64_t mib = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), mib);
    if (error != std::errc() || end != text.data() + text.size() || mib < 1 || mib > uint64_t(1) << 30)
        throw std::invalid_argument(
            fmt::format("{}: \"{}\" is no whole number from 1 to 2^30", variable, text));
    return mib;
}

}  // namespace

uint64_t input_limit() {
    return limit_mib() << 20;
}

std::string over_input_limit() {
    return fmt::format("more than {} MiB, the limit for one file ({} raises it)", limit_mib(), variable);
}

}  // namespace penumbra
