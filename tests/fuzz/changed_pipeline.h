// SPDX-License-Identifier: MIT
// A shipped pipeline, changed as the bytes say by what is in it already: members removed, doubled and
// swapped, texts exchanged, `@-1` added, numbers, conditions. What comes out is still JSON and nearly a
// pipeline, as noise never is; not all that is read compiles and runs (docs/reliability.md says how many).
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace penumbra::test {

// `most`: changes, 1 to 6.
std::string changed_pipeline(std::span<const std::byte> bytes, size_t most = 6);

}  // namespace penumbra::test
