// SPDX-License-Identifier: MIT
// What a session's last frame left in a captured resource, as values.
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include "app/session.h"

namespace penumbra {

// Bytes beyond the last whole value are left out. `name`: one of SessionOptions::captures.
template <class T>
std::vector<T> captured_values(const Session& session, const std::string& name) {
    const auto bytes = session.view().captured(name);
    std::vector<T> values(bytes.size() / sizeof(T));
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
    return values;
}

}  // namespace penumbra
