// SPDX-License-Identifier: MIT
// Conditions as sets: under which combinations of facts something exists. There are few facts, so such a set
// is one bit per combination, and "is there a writer whenever there is a reader?" is a matter of and, or and
// not.
#pragma once

#include <bitset>
#include <optional>
#include <string>
#include <string_view>

#include "graph/node_type.h"

namespace penumbra {

// Bit c: whether it exists where exactly those facts i are true whose bit i of c is set (in the order of
// fact_names).
using FactCases = std::bitset<size_t{1} << fact_names.size()>;

FactCases all_cases();
FactCases cases_of(const std::string& fact, bool negated);
// Of the literals that are facts; the others do not restrict.
FactCases cases_of(const Condition& condition);
bool contains(const FactCases& cases, const Facts& facts);

// A literal and its negation, or two different values of one parameter.
bool contradict(const Literal& a, const Literal& b);

// What is wrong with a name that should be a fact's; nothing where it is one.
std::optional<std::string> fact_problem(const std::string& name);

// Without blanks at both ends.
std::string_view trimmed(std::string_view text);

// The text after a comparison's sign as the JSON that the parameter's type asks for.
Json value_json(const Param& param, std::string_view text, const Place& place);

}  // namespace penumbra
