// SPDX-License-Identifier: MIT
// What was measured, as JSON with every figure and as Markdown tables with those that people compare.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/bench/bench.h"

namespace penumbra::bench {

struct Bench {
    std::string command;
    DeviceInfo device;
    Options options;
    std::vector<Contender> contenders;
    std::vector<Scene> scenes;
};

// Unknown values are null, never absent.
nlohmann::ordered_json to_json(const Bench& bench);

// Per contender and size: a row per pass, a column per shot; and what is not of a pass.
std::string tables(const Bench& bench);

}  // namespace penumbra::bench
