// SPDX-License-Identifier: MIT
// Conditions: "sun_up & !alpha & mode=tent". Facts are what the host promises for a plan's lifetime;
// PARAM=VALUE compares a constant parameter, by a text form that parsing and evaluation share.
#include "graph/condition.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/json_reader.h"

namespace penumbra {

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
    while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    return text;
}

namespace {

struct ParamText {
    std::string operator()(bool value) const { return value ? "true" : "false"; }
    std::string operator()(int32_t value) const { return fmt::format("{}", value); }
    std::string operator()(uint32_t value) const { return fmt::format("{}", value); }
    std::string operator()(float value) const { return fmt::format("{}", value); }
    std::string operator()(const std::string& value) const { return value; }
    std::string operator()(const std::vector<float>& value) const {
        std::string text;
        for (const float component : value) text += fmt::format("{}{}", text.empty() ? "" : ",", component);
        return text;
    }
};

std::string text_of(const ParamValue& value) {
    return std::visit(ParamText{}, value);
}

}  // namespace

Json value_json(const Param& param, std::string_view text, const Place& place) {
    Diagnostics unused;
    std::optional<Json> json;
    if (param.type != ParamType::enumeration) json = parse_json(text, "", unused);
    if (!json) {
        json.emplace();
        json->kind = Json::Kind::string;
        json->string = text;
    }
    json->place = place;
    return *json;
}

std::optional<std::string> fact_problem(const std::string& name) {
    const std::vector<std::string> facts(fact_names.begin(), fact_names.end());
    if (std::ranges::find(facts, name) != facts.end()) return std::nullopt;
    return fmt::format("no fact \"{}\" (facts: {}){}", name, join(facts), did_you_mean(name, facts));
}

std::string to_string(const Condition& condition) {
    std::string text;
    for (const Literal& literal : condition) {
        text += text.empty() ? "" : " & ";
        text += (literal.negated ? "!" : "") + literal.name;
        if (literal.value) text += "=" + *literal.value;
    }
    return text;
}

std::optional<Condition> parse_condition(const Json& json, std::span<const Param> params,
                                         const std::string& path, Diagnostics& diagnostics) {
    if (!expect(json, Json::Kind::string, path, diagnostics)) return std::nullopt;
    const size_t errors = diagnostics.size();
    const auto error = [&](std::string message) { diagnostics.add(json.place, path, std::move(message)); };

    Condition condition;
    const std::string_view text = json.string;
    for (size_t begin = 0; begin <= text.size();) {
        const size_t end = std::min(text.find('&', begin), text.size());
        std::string_view part = trimmed(text.substr(begin, end - begin));
        begin = end + 1;

        Literal literal;
        literal.negated = part.starts_with('!');
        if (literal.negated) part = trimmed(part.substr(1));
        const size_t equals = part.find('=');
        literal.name = trimmed(part.substr(0, equals));
        if (literal.name.empty()) {
            error("expected literals joined by \"&\": FACT or PARAM=VALUE, or ! and one of them");
            continue;
        }
        if (equals == std::string_view::npos) {
            if (auto problem = fact_problem(literal.name)) {
                error(std::move(*problem));
                continue;
            }
        } else {
            if (params.empty()) {
                error(fmt::format("\"{}\": the node has no parameters to compare", part));
                continue;
            }
            const auto param = std::ranges::find(params, literal.name, &Param::name);
            if (param == params.end()) {
                std::vector<std::string> names;
                for (const Param& p : params) names.push_back(p.name);
                error(fmt::format("no parameter \"{}\"{}", literal.name, did_you_mean(literal.name, names)));
                continue;
            }
            if (!param->constant) {
                error(fmt::format("parameter \"{}\" may change per frame; a condition needs a constant one",
                                  literal.name));
                continue;
            }
            const Json value = value_json(*param, trimmed(part.substr(equals + 1)), json.place);
            const auto parsed = parse_param_value(*param, value, path, diagnostics);
            if (!parsed) continue;
            literal.value = text_of(*parsed);
        }
        if (std::ranges::any_of(condition, [&](const Literal& other) { return contradict(literal, other); }))
            error(fmt::format("never holds: \"{}\" contradicts an earlier literal", part));
        else if (std::ranges::find(condition, literal) == condition.end())
            condition.push_back(literal);
    }
    if (diagnostics.size() != errors) return std::nullopt;
    return condition;
}

bool holds(const Condition& condition, const Facts& facts, const std::map<std::string, ParamValue>& params) {
    return std::ranges::all_of(condition, [&](const Literal& literal) {
        if (literal.value) {
            const auto param = params.find(literal.name);
            return param != params.end() && (text_of(param->second) == *literal.value) != literal.negated;
        }
        const auto fact = facts.find(literal.name);
        return (fact == facts.end() || fact->second) != literal.negated;
    });
}

bool contradict(const Literal& a, const Literal& b) {
    if (a.name != b.name || a.value.has_value() != b.value.has_value()) return false;
    if (a.negated != b.negated) return a.value == b.value;
    return a.value && !a.negated && *a.value != *b.value;
}

FactCases all_cases() {
    return FactCases().set();
}

FactCases cases_of(const std::string& fact, bool negated) {
    const auto found = std::ranges::find(fact_names, fact);
    const auto bit = static_cast<size_t>(found - fact_names.begin());
    FactCases cases;
    for (size_t c = 0; c < cases.size(); ++c) cases[c] = ((c >> bit & 1) != 0) != negated;
    return cases;
}

FactCases cases_of(const Condition& condition) {
    FactCases cases = all_cases();
    for (const Literal& literal : condition)
        if (!literal.value) cases &= cases_of(literal.name, literal.negated);
    return cases;
}

bool contains(const FactCases& cases, const Facts& facts) {
    size_t c = 0;
    for (size_t i = 0; i < fact_names.size(); ++i) {
        const auto fact = facts.find(fact_names[i]);
        if (fact == facts.end() || fact->second) c |= size_t{1} << i;
    }
    return cases[c];
}

}  // namespace penumbra
