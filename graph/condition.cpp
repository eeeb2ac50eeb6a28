// SPDX-License-Identifier: MIT
// Parsing and settling are apart because the first needs one file and the second the whole pipeline: the node
// that a comparison names may stand further down, and its parameter may be set on the command line.
#include "penumbra/condition.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "graph/json_reader.h"
#include "penumbra/node_type.h"

namespace penumbra {

namespace {

// Longer signs first: "<=" is not "<".
constexpr std::array<std::pair<std::string_view, Relation>, 6> signs = {{{"<=", Relation::at_most},
                                                                         {">=", Relation::at_least},
                                                                         {"!=", Relation::not_equal},
                                                                         {"<", Relation::less},
                                                                         {">", Relation::greater},
                                                                         {"=", Relation::equal}}};

std::string_view sign_of(Relation relation) {
    for (const auto& [sign, meaning] : signs)
        if (meaning == relation) return sign;
    return "";
}

std::string text_of(const Atom& atom) {
    return (atom.negated ? "!" : "") + (atom.node.empty() ? "" : atom.node + ".") + atom.name +
           std::string(sign_of(atom.relation)) + atom.value;
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
    while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    return text;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    for (size_t begin = 0; begin <= text.size();) {
        const size_t end = std::min(text.find(separator, begin), text.size());
        parts.push_back(trimmed(text.substr(begin, end - begin)));
        begin = end + 1;
    }
    return parts;
}

// What is wrong with the atom, or nothing.
std::optional<std::string> parse_atom(std::string_view text, const Domain& domain, bool in_pipeline,
                                      Atom& atom) {
    atom.negated = text.starts_with('!');
    if (atom.negated) text = trimmed(text.substr(1));
    const size_t at = text.find_first_of("<>=!");
    const std::string_view left = trimmed(text.substr(0, at));
    if (at != std::string_view::npos)
        for (const auto& [sign, meaning] : signs)
            if (atom.relation == Relation::is_true && text.substr(at).starts_with(sign)) {
                atom.relation = meaning;
                atom.value = trimmed(text.substr(at + sign.size()));
            }
    const bool compares = atom.relation != Relation::is_true;
    const bool no_value =
        compares && (atom.value.empty() || atom.value.find_first_of("<>=!") != std::string::npos);
    const char* own = in_pipeline ? "NODE.PARAM" : "PARAM";
    if (left.empty() || (at != std::string_view::npos && !compares) || no_value)
        return fmt::format(
            "expected FACT, {0}, or {0} compared with a value (= != < <= > >=), each may have a ! before it; "
            "joined by \"&\", and those by \"|\"",
            own);
    const size_t dot = left.find('.');
    if (in_pipeline && dot != std::string_view::npos) {
        atom.node = left.substr(0, dot);
        atom.name = left.substr(dot + 1);
        for (const std::string& id : {atom.node, atom.name})
            if (!is_id(id))
                return fmt::format("\"{}\": expected NODE.PARAM, two ids ([a-z][a-z0-9_]*)", left);
        return std::nullopt;
    }
    atom.name = left;
    if (in_pipeline && compares)
        return fmt::format(
            "\"{}\": a comparison needs NODE.PARAM before its sign, as in trace.rays_per_pixel=1", text);
    const auto fact = std::ranges::find(domain.facts, atom.name, &Fact::name);
    if (fact != domain.facts.end() && !compares) atom.fact = static_cast<size_t>(fact - domain.facts.begin());
    if (in_pipeline && !atom.fact) return fact_problem(domain, atom.name);
    return std::nullopt;  // a declaration's own parameter, which settle() looks for
}

// Whether two texts are one value, as 1 and 1.0.
bool same_value(const std::string& a, const std::string& b) {
    double x = 0, y = 0;
    const auto number = [](const std::string& text, double& value) {
        return std::from_chars(text.data(), text.data() + text.size(), value).ec == std::errc();
    };
    return a == b || (number(a, x) && number(b, y) && x == y);
}

// Both cannot hold, whatever the facts and parameters are.
bool contradict(const Atom& a, const Atom& b) {
    if (a.node != b.node || a.name != b.name) return false;
    Atom opposite = b;
    opposite.negated = !b.negated;
    const bool two_values =
        a.relation == Relation::equal && b.relation == Relation::equal && !same_value(a.value, b.value);
    return a == opposite || (two_values && !a.negated && !b.negated);
}

struct AsNumber {
    double operator()(bool value) const { return value ? 1 : 0; }
    double operator()(int32_t value) const { return value; }
    double operator()(uint32_t value) const { return value; }
    double operator()(float value) const { return static_cast<double>(value); }
    double operator()(const std::string&) const { return 0; }
    double operator()(const std::vector<float>&) const { return 0; }
};

bool compare(Relation relation, const ParamValue& a, const ParamValue& b) {
    const double x = std::visit(AsNumber{}, a), y = std::visit(AsNumber{}, b);
    switch (relation) {
        case Relation::less:
            return x < y;
        case Relation::at_most:
            return x <= y;
        case Relation::greater:
            return x > y;
        case Relation::at_least:
            return x >= y;
        case Relation::not_equal:
            return a != b;
        default:
            return a == b;
    }
}

// Whether a comparison holds; nothing after reporting why it cannot be asked.
std::optional<bool> settle(const Atom& atom, const Place& place, const FindParam& find,
                           const std::string& path, Diagnostics& diagnostics) {
    const auto fail = [&](std::string message) {
        diagnostics.add(place, path, std::move(message));
        return std::nullopt;
    };
    const KnownParam known = find(atom);
    if (!known.param) return known.problem.empty() ? std::nullopt : fail(known.problem);
    const std::string name = (atom.node.empty() ? "" : atom.node + ".") + atom.name;
    if (!known.param->constant)
        return fail(fmt::format("\"{}\" may change per frame; a condition needs a constant parameter", name));
    const bool truth = known.param->type == ParamType::boolean,
               named = known.param->type == ParamType::enumeration;
    if (atom.relation == Relation::is_true) {
        if (!truth) return fail(fmt::format("\"{}\" is no bool; compare it with a value", name));
        return std::get<bool>(*known.value) != atom.negated;
    }
    const bool ordered = atom.relation != Relation::equal && atom.relation != Relation::not_equal;
    if (ordered && (truth || named))
        return fail(fmt::format("\"{}\": {} has no order; compare it by = or !=", text_of(atom),
                                truth ? "a bool" : "a name"));
    const std::string where = fmt::format("{}: \"{}\"", path, text_of(atom));
    const auto value = parse_param_text(*known.param, atom.value, place, where, diagnostics);
    if (!value) return std::nullopt;
    return compare(atom.relation, *known.value, *value) != atom.negated;
}

}  // namespace

std::vector<std::string> Domain::fact_list() const {
    std::vector<std::string> names;
    for (const Fact& fact : facts) names.push_back(fact.name);
    return names;
}

std::optional<std::string> fact_problem(const Domain& domain, const std::string& name) {
    const std::vector<std::string> facts = domain.fact_list();
    if (std::ranges::find(facts, name) != facts.end()) return std::nullopt;
    return fmt::format("no fact \"{}\" (facts: {}){}", name, join(facts), did_you_mean(name, facts));
}

std::string to_string(const Condition& condition) {
    std::string text;
    for (const auto& term : condition.terms) {
        if (!text.empty()) text += " | ";
        for (const Atom& atom : term) text += (&atom == term.data() ? "" : " & ") + text_of(atom);
    }
    return text;
}

std::optional<Condition> parse_condition(const Json& json, const Domain& domain, bool in_pipeline,
                                         const std::string& path, Diagnostics& diagnostics) {
    if (!expect(json, Json::Kind::string, path, diagnostics)) return std::nullopt;
    const size_t errors = diagnostics.size();
    const auto error = [&](std::string message) { diagnostics.add(json.place, path, std::move(message)); };
    Condition condition{.terms = {}, .place = json.place};
    for (const std::string_view term_text : split(json.string, '|')) {
        std::vector<Atom>& term = condition.terms.emplace_back();
        const std::vector<std::string_view> parts = split(term_text, '&');
        constexpr size_t most = 64;  // each is compared with all before it
        if (parts.size() > most) {
            error(fmt::format("{} literals are joined by \"&\"; {} are the most", parts.size(), most));
            continue;
        }
        for (const std::string_view part : parts) {
            Atom atom;
            if (auto problem = parse_atom(part, domain, in_pipeline, atom))
                error(std::move(*problem));
            else if (std::ranges::any_of(term, [&](const Atom& other) { return contradict(atom, other); }))
                error(fmt::format("never holds: \"{}\" contradicts an earlier literal", text_of(atom)));
            else if (std::ranges::find(term, atom) == term.end())
                term.push_back(std::move(atom));
        }
    }
    if (diagnostics.size() != errors) return std::nullopt;
    return condition;
}

FactCases all_cases() {
    return FactCases().set();
}

FactCases cases_of(size_t fact, bool negated) {
    FactCases cases;
    for (size_t c = 0; c < cases.size(); ++c) cases[c] = ((c >> fact & 1) != 0) != negated;
    return cases;
}

FactCases cases_given(const FactCases& cases, size_t fact, bool holds) {
    FactCases given;
    const size_t known = size_t{1} << fact;
    for (size_t c = 0; c < cases.size(); ++c) given[c] = cases[holds ? c | known : c & ~known];
    return given;
}

std::optional<FactCases> settle(const Condition& condition, const FindParam& find, const std::string& path,
                                Diagnostics& diagnostics) {
    if (condition.always()) return all_cases();
    bool good = true;
    FactCases any;
    for (const auto& term : condition.terms) {
        FactCases all = all_cases();
        for (const Atom& atom : term) {
            if (atom.fact) {
                all &= cases_of(*atom.fact, atom.negated);
                continue;
            }
            const auto truth = settle(atom, condition.place, find, path, diagnostics);
            good = good && truth.has_value();
            if (!truth.value_or(false)) all.reset();
        }
        any |= all;
    }
    if (!good) return std::nullopt;
    return any;
}

}  // namespace penumbra
