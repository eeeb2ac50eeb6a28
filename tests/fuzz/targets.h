// SPDX-License-Identifier: MIT
// What takes bytes from outside, each as a function of any bytes at all: what libFuzzer drives
// (fuzz_main.cpp) and what the corpora are replayed through in every test run. None may crash, hang or take
// memory without bound, and what is taken is sound: a broken promise throws.
#pragma once

#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace penumbra::test {

using Bytes = std::span<const std::byte>;

inline void promise(bool kept, const std::string& broken) {
    if (!kept) throw std::logic_error(broken);
}

void fuzz_pipeline(Bytes bytes);     // JSON to a plan, which the independent checks accept
void fuzz_declaration(Bytes bytes);  // JSON of a node type
void fuzz_shot(Bytes bytes);         // JSON of a shot
void fuzz_gltf(Bytes bytes);         // .gltf or, where it begins so, .glb
void fuzz_exr(Bytes bytes);
void fuzz_image(Bytes bytes);   // PNG, JPEG
void fuzz_c_api(Bytes bytes);   // a penumbra_plan_request out of the bytes
void fuzz_mutant(Bytes bytes);  // a shipped pipeline, changed as the bytes say

struct FuzzTarget {
    std::string_view name;
    void (*run)(Bytes);
};
inline constexpr FuzzTarget fuzz_targets[] = {{"pipeline", fuzz_pipeline}, {"declaration", fuzz_declaration},
                                              {"shot", fuzz_shot},         {"gltf", fuzz_gltf},
                                              {"exr", fuzz_exr},           {"image", fuzz_image},
                                              {"c_api", fuzz_c_api},       {"mutant", fuzz_mutant}};

}  // namespace penumbra::test
