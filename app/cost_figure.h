// SPDX-License-Identifier: MIT
// Where pipelines' time goes: a bar per report.json of `render`, a part of it per pass.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "penumbra/diagnostic.h"

namespace penumbra {

struct PassCost {
    std::string node, type;
    double ms = 0;
};

struct PipelineCosts {
    std::string pipeline, shot, device;
    std::array<uint32_t, 2> size{};
    std::vector<PassCost> passes;  // in plan order, without captures
    bool by_cpu = false;           // process CPU time; else the device's timestamps

    double total() const;
};

// What is wrong with the file is a diagnostic: none, no report, or one without times of passes.
std::optional<PipelineCosts> read_costs(const std::string& file, Diagnostics& diagnostics);

// A whole SVG file. A node type has the same colour in every bar.
std::string cost_figure(const std::vector<PipelineCosts>& costs);

}  // namespace penumbra
