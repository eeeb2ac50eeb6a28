// SPDX-License-Identifier: MIT
// What a report of radiance writes: results.json, tables.md, index.html.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/report/radiance_measure.h"

namespace penumbra::report {

// Unknown values are null, never absent.
nlohmann::ordered_json to_json(const RadianceResults& results);
// Speed against error and N_eff by roughness, a row per contender.
std::string markdown_tables(const RadianceResults& results);
// One file that needs no other; reads the images that the results name from `folder`.
std::string radiance_page(const RadianceResults& results, const std::filesystem::path& folder);

}  // namespace penumbra::report
