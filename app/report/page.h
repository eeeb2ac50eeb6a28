// SPDX-License-Identifier: MIT
// index.html: one file that needs no other and no network.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/report/results.h"
#include "penumbra/plan.h"

namespace penumbra::report {

struct PipelinePlan {
    size_t contender = 0;
    Plan plan;
};

// Reads the images that the results name from `folder`; throws FileError where one is missing.
std::string report_page(const Results& results, const std::vector<PipelinePlan>& plans,
                        const std::filesystem::path& folder);

}  // namespace penumbra::report
