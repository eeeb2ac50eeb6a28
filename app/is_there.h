// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "penumbra/diagnostic.h"

namespace penumbra {

// Whether there is such a file. Where nobody can tell, as in a folder that may not be read, that is an error.
inline bool is_there(const std::filesystem::path& file, Diagnostics& diagnostics) {
    std::error_code failure;
    const bool there = std::filesystem::exists(file, failure);
    if (failure) diagnostics.add({file.string(), 0, 0}, "", "cannot be read: " + failure.message());
    return there;
}

}  // namespace penumbra
