// SPDX-License-Identifier: MIT
// A plan's dataflow, laid out to be looked at and clicked on: passes from left to right in layers, a row for
// every resource that a pass writes, host inputs and previous values on the left of who reads them first.
#pragma once

#include <string>
#include <vector>

#include "penumbra/plan.h"

namespace penumbra::viewer {

struct FlowBox {
    enum class Kind { pass, host, previous };
    Kind kind = Kind::pass;
    std::string title;              // a node's id; empty of what no pass writes
    std::vector<std::string> rows;  // resources; "depth@-1" of a previous value
    double x = 0, y = 0, width = 0, height = 0;
};

// From a row of one box to another box.
struct FlowLine {
    size_t from = 0, row = 0, to = 0;
};

struct Dataflow {
    std::vector<FlowBox> boxes;
    std::vector<FlowLine> lines;
    double width = 0, height = 0;
};

// In units of one row's height; `letter` is the width of a letter in them.
Dataflow dataflow_of(const Plan& plan, double letter);

}  // namespace penumbra::viewer
