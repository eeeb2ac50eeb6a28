// SPDX-License-Identifier: MIT
// What of a plan can be turned while it runs: the dynamic parameters of its nodes, as their declarations
// describe them.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "app/session.h"

namespace penumbra::viewer {

struct Control {
    Param param;       // type, range, unit, doc, values
    std::string node;  // its id
    std::vector<std::array<size_t, 2>>
        places;          // pass and parameter of the plan: a node may be several passes
    ParamValue value;    // as it is now
    ParamValue initial;  // as the pipeline says, with the device class's overrides

    std::string name() const { return node + "." + param.name; }
    bool changed() const { return value != initial; }
};

// In the plan's order. `seed` is not among them: the shot's is set in every node at once.
std::vector<Control> controls_of(const Plan& plan);

// What was turned, by Control::name(), to be turned again where the plan was made anew.
using Turned = std::map<std::string, ParamValue>;

// Sets a control and every pass that it is of; false, and nothing happens, where the value is not of its type
// and range.
bool turn(Session& session, Control& control, const ParamValue& value);
// What no longer is there, or takes no such value, is left out; its names are returned.
std::vector<std::string> turn_again(Session& session, std::vector<Control>& controls, const Turned& turned);

// "nodes.filter0.params.step=2", as --set takes it.
std::string setting_of(const Control& control);

}  // namespace penumbra::viewer
