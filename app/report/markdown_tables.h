// SPDX-License-Identifier: MIT
// tables.md: the report's figures as Markdown, for documents that quote it.
#pragma once

#include <string>

#include "app/report/results.h"

namespace penumbra::report {

// Speed against error, N_eff after a cut, error and cost in motion, and behind the moving edge: a row per
// contender. Contenders whose masks are the same to the bit everywhere share a row where only masks count.
std::string markdown_tables(const Results& results);

}  // namespace penumbra::report
