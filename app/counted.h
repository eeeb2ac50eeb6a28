// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

namespace penumbra {

// "1 seed", "2 seeds"
inline std::string counted(uint64_t number, const std::string& what) {
    return std::to_string(number) + " " + what + (number == 1 ? "" : "s");
}

}  // namespace penumbra
