// SPDX-License-Identifier: MIT
// The node set of tests/toy/, compiled when the test runs: nodes so simple that their results are exact
// numbers.
#pragma once

#include "penumbra/check.h"
#include "penumbra/node_set.h"

namespace penumbra::test {

// Throws std::runtime_error with the diagnostics where a toy does not compile.
const NodeSet& toy_set();

// tests/toy/toys.json, checked against toy_set().
CheckedPipeline toy_pipeline_file();

}  // namespace penumbra::test
