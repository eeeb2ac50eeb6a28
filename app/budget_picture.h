// SPDX-License-Identifier: MIT
// Where a frame's rays went: what the nodes `pilots`, `allot` and `refine` decided, as an image.
// docs/budget.md.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "app/session.h"

namespace penumbra {

struct BudgetPicture {
    std::array<uint32_t, 2> size{};
    std::vector<uint8_t>
        rgba;  // row by row: dark where no ray could go, grey for none, from blue to white for 1 to 32
    std::array<uint64_t, 33> pixels{};  // that got so many rays, of those that could have one
    uint64_t rays = 0;

    uint64_t receivers() const;
    std::string summary() const;
};

// What a session of shadows.json has to capture.
const std::vector<std::string>& budget_captures();

// Of the frame that the session has run last.
BudgetPicture budget_picture(const Session& session);

}  // namespace penumbra
