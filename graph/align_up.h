// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace penumbra {

// `value` rounded up to a multiple of `alignment`, a power of two.
constexpr uint64_t align_up(uint64_t value, uint64_t alignment) {
    return (value + alignment - 1) & ~(alignment - 1);
}

}  // namespace penumbra
