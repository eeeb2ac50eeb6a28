// SPDX-License-Identifier: MIT
// A pipeline node's "if": "sun_up & trace.rays_per_pixel>=8 | !casters". Facts are the host's to promise; a
// comparison asks for a constant parameter of a node of the same pipeline, so check() settles it, once and
// for all: what a formula then says of facts is a set of cases (condition.h). "&" binds before "|"; there are
// no brackets.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "graph/condition.h"

namespace penumbra {

enum class Relation : uint8_t { is_true, equal, not_equal, less, at_most, greater, at_least };

struct Atom {
    std::string node;  // empty: `name` is a fact, else a parameter of this node
    std::string name;
    bool negated = false;
    Relation relation = Relation::is_true;
    std::string value;  // as written

    friend bool operator==(const Atom&, const Atom&) = default;
};

struct Formula {
    std::vector<std::vector<Atom>> terms;  // any of them, each all of its atoms; none: always
    Place place;
};

std::string to_string(const Formula& formula);

// Reports every mistake that can be seen without the node set.
std::optional<Formula> parse_formula(const Json& json, const std::string& path, Diagnostics& diagnostics);

// What check() knows of one parameter of a pipeline's node.
struct KnownParam {
    const Param* param = nullptr;  // nullptr: no such thing, and `problem` says why
    const ParamValue* value = nullptr;
    std::string problem;
};
using FindParam = std::function<KnownParam(const std::string& node, const std::string& param)>;

// The cases of facts in which a formula holds; nothing after reporting an error.
std::optional<FactCases> settle(const Formula& formula, const FindParam& find, const std::string& path,
                                Diagnostics& diagnostics);

}  // namespace penumbra
