// SPDX-License-Identifier: MIT
// FNV-1a, 64 bits (Fowler, Noll, Vo 1991; parameters of RFC 9923): tells versions of a thing apart and finds
// damage; equality is never judged by it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace penumbra {

inline uint64_t fnv1a(std::span<const std::byte> bytes) {
    uint64_t hash = 0xcbf29ce484222325;
    for (const std::byte b : bytes) hash = (hash ^ static_cast<uint64_t>(b)) * 0x100000001b3;
    return hash;
}

inline uint64_t fnv1a(std::string_view text) {
    return fnv1a(std::as_bytes(std::span(text)));
}

}  // namespace penumbra
