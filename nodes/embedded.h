// SPDX-License-Identifier: MIT
// What the build embeds for one node type: its declaration's text, the SPIR-V of its variants and its tables.
#pragma once

#include <cstdint>
#include <span>

namespace penumbra {

struct EmbeddedVariant {
    const char* key;  // to_string(Variant)
    std::span<const uint32_t> spirv;
};

struct EmbeddedTable {
    const char* name;
    std::span<const uint32_t> words;
};

struct EmbeddedNode {
    const char* name;
    const char* declaration;
    std::span<const EmbeddedVariant> variants;
    std::span<const EmbeddedTable> tables;
};

}  // namespace penumbra
