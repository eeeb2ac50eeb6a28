// SPDX-License-Identifier: MIT
// How much memory what a file describes may take once it is read. A few bytes can describe gigabytes: whoever
// reads files of others' making bounds that, and whoever has larger ones of his own raises the bound.
#pragma once

#include <cstdint>
#include <string>

namespace penumbra {

// Bytes: PENUMBRA_INPUT_LIMIT_MIB of the environment, else 2 GiB. Throws std::invalid_argument where the
// variable is no whole number from 1 to 2^30.
uint64_t input_limit();

// "more than 2048 MiB, the limit for one file (PENUMBRA_INPUT_LIMIT_MIB raises it)"
std::string over_input_limit();

}  // namespace penumbra
