// SPDX-License-Identifier: MIT
// The one language of "if", in declarations and in pipelines: "moves & !static | taps>=8". Atoms are the
// domain's facts and comparisons of constant parameters: of the declaration's own (PARAM), or of a pipeline's
// node (NODE.PARAM); a bool may stand alone. "!" stands before one atom, "&" binds before "|", there are no
// brackets. A comparison is settled once the parameters' values are known; what a condition then says of
// facts is the set of cases in which it holds. There are few facts, so that such a set is one bit per
// combination, and "is there a writer whenever there is a reader?" is a matter of and, or and not.
#pragma once

#include <bitset>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "penumbra/domain.h"
#include "penumbra/export.h"
#include "penumbra/json_text.h"

namespace penumbra PENUMBRA_API {

struct Param;

using ParamVariant = std::variant<bool, int32_t, uint32_t, float, std::vector<float>, std::string>;
// That variant; a copy that runs out of memory throws std::bad_alloc. With libstdc++ 12 a variant's own
// copy of these alternatives, which assumes it is never valueless, then destroys an object never
// constructed.
struct ParamValue : ParamVariant {
    using ParamVariant::ParamVariant;
    ParamValue() = default;
    ParamValue(const ParamValue& other) : ParamVariant() {
        std::visit(
            [this]<class T>(const T& value) {
                T copy = value;
                emplace<T>(std::move(copy));
            },
            static_cast<const ParamVariant&>(other));
    }
    ParamValue(ParamValue&&) = default;
    ParamValue& operator=(ParamValue other) noexcept {
        swap(other);
        return *this;
    }
    ~ParamValue() = default;
};

enum class Relation : uint8_t { is_true, equal, not_equal, less, at_most, greater, at_least };

struct Atom {
    std::string node;  // empty: a fact, or the declaration's own parameter
    std::string name;
    std::optional<size_t> fact;  // index in the domain; none: a parameter
    bool negated = false;
    Relation relation = Relation::is_true;
    std::string value;  // as written

    friend bool operator==(const Atom&, const Atom&) = default;
};

struct Condition {
    std::vector<std::vector<Atom>> terms;  // any of them, each all of its atoms; none: always
    Place place;

    bool always() const { return terms.empty(); }
    friend bool operator==(const Condition& a, const Condition& b) { return a.terms == b.terms; }
};

std::string to_string(const Condition& condition);

// Reports every mistake that can be seen without the parameters. `in_pipeline`: parameters are NODE.PARAM.
std::optional<Condition> parse_condition(const Json& json, const Domain& domain, bool in_pipeline,
                                         const std::string& path, Diagnostics& diagnostics);

// What is wrong with a name that should be a fact's; nothing where it is one.
std::optional<std::string> fact_problem(const Domain& domain, const std::string& name);

// Bit c: whether something exists where exactly those facts hold whose bit of c is set.
using FactCases = std::bitset<size_t{1} << max_facts>;
FactCases all_cases();
FactCases cases_of(size_t fact, bool negated);
// The same where somebody else knows the fact: what a case says of it no longer matters.
FactCases cases_given(const FactCases& cases, size_t fact, bool holds);

// One parameter that a comparison asks for.
struct KnownParam {
    const Param* param = nullptr;  // nullptr: no such thing, and `problem` says why; empty: it has been said
    const ParamValue* value = nullptr;
    std::string problem;
};
using FindParam = std::function<KnownParam(const Atom&)>;

// The cases in which a condition holds; nothing after reporting an error.
std::optional<FactCases> settle(const Condition& condition, const FindParam& find, const std::string& path,
                                Diagnostics& diagnostics);

}  // namespace penumbra
