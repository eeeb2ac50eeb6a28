// SPDX-License-Identifier: MIT
// Parsing and settling are apart because the first needs one file and the second the whole pipeline: the node
// that a comparison names may stand further down, and its parameter may be set on the command line.
#include "graph/formula.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "graph/json_reader.h"

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
std::optional<std::string> parse_atom(std::string_view text, Atom& atom) {
    atom.negated = text.starts_with('!');
    if (atom.negated) text = trimmed(text.substr(1));
    const size_t at = text.find_first_of("<>=!");
    std::string_view left = trimmed(text.substr(0, at));
    if (at != std::string_view::npos)
        for (const auto& [sign, meaning] : signs)
            if (atom.relation == Relation::is_true && text.substr(at).starts_with(sign)) {
                atom.relation = meaning;
                atom.value = trimmed(text.substr(at + sign.size()));
            }
    const bool compares = atom.relation != Relation::is_true;
    const bool no_value =
        compares && (atom.value.empty() || atom.value.find_first_of("<>=!") != std::string::npos);
    if (left.empty() || (at != std::string_view::npos && !compares) || no_value)
        return "expected FACT, NODE.PARAM, or NODE.PARAM compared with a value (= != < <= > >=), each may "
               "have a ! before it; "
               "joined by \"&\", and those by \"|\"";
    const size_t dot = left.find('.');
    if (dot != std::string_view::npos) {
        atom.node = left.substr(0, dot);
        atom.name = left.substr(dot + 1);
        for (const std::string& id : {atom.node, atom.name})
            if (!is_id(id))
                return fmt::format("\"{}\": expected NODE.PARAM, two ids ([a-z][a-z0-9_]*)", left);
        return std::nullopt;
    }
    atom.name = left;
    if (compares)
        return fmt::format(
            "\"{}\": a comparison needs NODE.PARAM before its sign, as in trace.rays_per_pixel=1", text);
    return fact_problem(atom.name);
}

bool contradicts(const Atom& a, const Atom& b) {
    return a.node.empty() && b.node.empty() && a.name == b.name && a.negated != b.negated;
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
    const KnownParam known = find(atom.node, atom.name);
    if (!known.param) return known.problem.empty() ? std::nullopt : fail(known.problem);
    const std::string name = atom.node + "." + atom.name;
    if (!known.param->constant)
        return fail(fmt::format("\"{}\" may change per frame; a condition needs a constant parameter", name));
    const ParamType type = known.param->type;
    const bool truth = type == ParamType::boolean, named = type == ParamType::enumeration;
    if (atom.relation == Relation::is_true) {
        if (!truth) return fail(fmt::format("\"{}\" is no bool; compare it with a value", name));
        return std::get<bool>(*known.value) != atom.negated;
    }
    const bool ordered = atom.relation != Relation::equal && atom.relation != Relation::not_equal;
    if (ordered && (truth || named))
        return fail(fmt::format("\"{}\": {} has no order; compare it by = or !=", text_of(atom),
                                truth ? "a bool" : "a name"));
    const std::string where = fmt::format("{}: \"{}\"", path, text_of(atom));
    const auto value =
        parse_param_value(*known.param, value_json(*known.param, atom.value, place), where, diagnostics);
    if (!value) return std::nullopt;
    return compare(atom.relation, *known.value, *value) != atom.negated;
}

}  // namespace

std::string to_string(const Formula& formula) {
    std::string text;
    for (const auto& term : formula.terms) {
        if (!text.empty()) text += " | ";
        for (const Atom& atom : term) text += (&atom == term.data() ? "" : " & ") + text_of(atom);
    }
    return text;
}

std::optional<Formula> parse_formula(const Json& json, const std::string& path, Diagnostics& diagnostics) {
    if (!expect(json, Json::Kind::string, path, diagnostics)) return std::nullopt;
    const size_t errors = diagnostics.size();
    const auto error = [&](std::string message) { diagnostics.add(json.place, path, std::move(message)); };
    Formula formula{.terms = {}, .place = json.place};
    for (const std::string_view term_text : split(json.string, '|')) {
        std::vector<Atom>& term = formula.terms.emplace_back();
        for (const std::string_view part : split(term_text, '&')) {
            Atom atom;
            if (auto problem = parse_atom(part, atom))
                error(std::move(*problem));
            else if (std::ranges::any_of(term, [&](const Atom& other) { return contradicts(atom, other); }))
                error(fmt::format("never holds: \"{}\" contradicts an earlier literal", text_of(atom)));
            else if (std::ranges::find(term, atom) == term.end())
                term.push_back(std::move(atom));
        }
    }
    if (diagnostics.size() != errors) return std::nullopt;
    return formula;
}

std::optional<FactCases> settle(const Formula& formula, const FindParam& find, const std::string& path,
                                Diagnostics& diagnostics) {
    if (formula.terms.empty()) return all_cases();
    bool good = true;
    FactCases any;
    for (const auto& term : formula.terms) {
        FactCases all = all_cases();
        for (const Atom& atom : term) {
            if (atom.node.empty()) {
                all &= cases_of(atom.name, atom.negated);
                continue;
            }
            const auto truth = settle(atom, formula.place, find, path, diagnostics);
            good = good && truth.has_value();
            if (!truth.value_or(false)) all.reset();
        }
        any |= all;
    }
    if (!good) return std::nullopt;
    return any;
}

}  // namespace penumbra
