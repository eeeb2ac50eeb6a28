// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <string>

#include "graph/fnv1a.h"

namespace penumbra {

// Of a version of a text, as 16 hexadecimal digits.
inline std::string digest(std::string_view text) {
    return fmt::format("{:016x}", fnv1a(text));
}

}  // namespace penumbra
