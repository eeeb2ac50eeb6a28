// SPDX-License-Identifier: MIT
// The variants of a node's shader: which there can be, and how each is told from the others. Declared in
// interface.h.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "graph/interface.h"

namespace penumbra {
namespace {

// Every value that the facts and constant parameters in the conditions of ports and tables can have, as text.
std::map<std::string, std::vector<std::string>> choices_in_conditions(const NodeType& type) {
    std::map<std::string, std::vector<std::string>> choices;
    const auto add = [&](const Condition& condition) {
        for (const Literal& literal : condition) {
            std::vector<std::string>& values = choices[literal.name];
            const Param* param = literal.value ? type.param(literal.name) : nullptr;
            if (param && param->type == ParamType::enumeration)
                values = param->values;
            else if (!param || param->type == ParamType::boolean)
                values = {"false", "true"};
            else
                values.insert(values.end(), {*literal.value, "another"});
        }
    };
    for (const Port& port : type.ports) add(port.condition);
    for (const Table& table : type.tables) add(table.condition);
    return choices;
}

// Which conditional ports and tables can exist together; what exists under one condition exists together.
std::set<std::map<std::string, bool>> possible_presences(const NodeType& type) {
    std::vector<std::map<std::string, std::string>> worlds(1);
    for (const auto& [name, values] : choices_in_conditions(type)) {
        std::vector<std::map<std::string, std::string>> more;
        for (const auto& world : worlds)
            for (const std::string& value : values) more.emplace_back(world)[name] = value;
        worlds = std::move(more);
    }
    std::set<std::map<std::string, bool>> presences;
    for (const auto& world : worlds) {
        Facts facts;
        std::map<std::string, ParamValue> params;
        for (const auto& [name, value] : world) {
            facts[name] = value == "true";
            params[name] = value;
        }
        std::map<std::string, bool> present;
        for (const Port& port : type.ports)
            if (!port.optional && !port.condition.empty())
                present[port.name] = holds(port.condition, facts, params);
        for (const Table& table : type.tables)
            if (!table.condition.empty()) present[table.name] = holds(table.condition, facts, params);
        presences.insert(std::move(present));
    }
    return presences;
}

}  // namespace

bool has_format_choice(const Port& port) {
    return port.kind == PortKind::image && port.storage && port.formats.size() > 1 && port.updates.empty();
}

const Param* backend_choice(const NodeType& type) {
    return traces_scene(type) ? type.param(backend_param) : nullptr;
}

bool traces_scene(const NodeType& type) {
    return std::any_of(type.ports.begin(), type.ports.end(),
                       [](const Port& port) { return port.kind == PortKind::scene; });
}

bool uses_ray_query(const Variant& variant) {
    return variant.backend == "ray_query";
}

bool exists(const Variant& variant, const std::string& port_or_table) {
    const auto found = variant.present.find(port_or_table);
    return found == variant.present.end() || found->second;
}

std::string to_string(const Variant& variant) {
    std::string key;
    for (const auto& [port, format] : variant.formats)
        key += fmt::format("{}{}={}", key.empty() ? "" : ",", port, info(format).name);
    for (const auto& [port, present] : variant.present)
        key += fmt::format("{}{}={:d}", key.empty() ? "" : ",", port, present);
    if (!variant.backend.empty())
        key += fmt::format("{}{}={}", key.empty() ? "" : ",", backend_param, variant.backend);
    if (variant.alpha) key += fmt::format("{}alpha=1", key.empty() ? "" : ",");
    return key;
}

std::vector<Variant> all_variants(const NodeType& type) {
    std::vector<Variant> variants(1);
    const auto multiply = [&](size_t choices, auto&& set) {
        std::vector<Variant> next;
        for (const Variant& variant : variants)
            for (size_t i = 0; i < choices; ++i) set(next.emplace_back(variant), i);
        variants = std::move(next);
    };
    for (const Port& port : type.ports) {
        if (has_format_choice(port))
            multiply(port.formats.size(),
                     [&](Variant& v, size_t i) { v.formats[port.name] = port.formats[i]; });
        if (port.optional) multiply(2, [&](Variant& v, size_t i) { v.present[port.name] = i == 1; });
    }
    const std::set<std::map<std::string, bool>> presences = possible_presences(type);
    const std::vector<std::map<std::string, bool>> list(presences.begin(), presences.end());
    multiply(list.size(), [&](Variant& v, size_t i) { v.present.insert(list[i].begin(), list[i].end()); });
    if (const Param* choice = backend_choice(type)) {
        std::vector<std::string> backends = choice->values;
        std::erase(backends, "auto");
        multiply(backends.size(), [&](Variant& v, size_t i) { v.backend = backends[i]; });
    }
    if (traces_scene(type)) multiply(2, [&](Variant& v, size_t i) { v.alpha = i == 1; });
    return variants;
}

}  // namespace penumbra
