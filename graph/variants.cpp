// SPDX-License-Identifier: MIT
// The variants of a node's shader: which there can be, and how each is told from the others. Declared in
// interface.h; declarations are limited by it, the build compiles what it lists, plans choose from it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "graph/interface.h"

namespace penumbra {
namespace {

// Values of a parameter that can make a difference to a comparison with `value`: it, and one on either side
// of it.
void add_around(const ParamValue& value, std::set<ParamValue>& values) {
    values.insert(value);
    if (const auto* number = std::get_if<int32_t>(&value)) {
        if (*number > INT32_MIN) values.emplace(*number - 1);
        if (*number < INT32_MAX) values.emplace(*number + 1);
    } else if (const auto* word = std::get_if<uint32_t>(&value)) {
        if (*word > 0) values.emplace(*word - 1);
        if (*word < UINT32_MAX) values.emplace(*word + 1);
    } else if (const auto* real = std::get_if<float>(&value)) {
        values.emplace(std::nextafter(*real, -INFINITY));
        values.emplace(std::nextafter(*real, INFINITY));
    }
}

// For every parameter that the conditions of variant outputs ask for, the values that matter.
std::map<std::string, std::set<ParamValue>> values_in_conditions(const NodeType& type) {
    std::map<std::string, std::set<ParamValue>> values;
    Diagnostics unused;
    for (const Port& port : type.ports) {
        if (!is_variant_output(type, port)) continue;
        for (const auto& term : port.condition.terms)
            for (const Atom& atom : term) {
                if (atom.fact) continue;
                const Param& param = *type.param(atom.name);
                std::set<ParamValue>& list = values[atom.name];
                if (param.type == ParamType::boolean)
                    list = {false, true};
                else if (param.type == ParamType::enumeration)
                    list.insert(param.values.begin(), param.values.end());
                else if (const auto value = parse_param_text(param, atom.value, {}, "", unused))
                    add_around(*value, list);
            }
    }
    for (auto& [name, list] : values) {
        const Param& param = *type.param(name);  // clang 14 captures no structured binding
        std::erase_if(list, [&](const ParamValue& value) { return !fits(param, value); });
    }
    return values;
}

// Which outputs can exist together; what exists under one condition exists together.
std::set<std::map<std::string, bool>> possible_outputs(const NodeType& type) {
    std::vector<std::map<std::string, ParamValue>> worlds(1);
    for (const auto& [name, values] : values_in_conditions(type)) {
        std::vector<std::map<std::string, ParamValue>> more;
        for (const auto& world : worlds)
            for (const ParamValue& value : values) more.emplace_back(world)[name] = value;
        worlds = std::move(more);
    }
    std::set<std::map<std::string, bool>> sets;
    Diagnostics unused;
    for (const auto& world : worlds) {
        const auto find = [&](const Atom& atom) -> KnownParam {
            return {.param = type.param(atom.name), .value = &world.at(atom.name)};
        };
        std::vector<std::pair<std::string, FactCases>> cases;
        for (const Port& port : type.ports)
            if (is_variant_output(type, port) && !port.optional)
                cases.emplace_back(port.name, settle(port.condition, find, "", unused).value_or(FactCases()));
        for (size_t c = 0; c < size_t{1} << type.domain->facts.size(); ++c) {
            std::map<std::string, bool> outputs;
            for (const auto& [name, exists] : cases) outputs[name] = exists[c];
            sets.insert(std::move(outputs));
        }
    }
    return sets;
}

}  // namespace

bool has_format_choice(const Port& port) {
    const bool named =
        port.kind == PortKind::image ? port.storage : port.kind == PortKind::texels && port.output;
    return named && port.formats.size() > 1 && port.updates.empty();
}

bool is_variant_output(const NodeType& type, const Port& port) {
    const Port& written = port.updater ? type.ports[*port.updater] : port;
    return written.output && (written.optional || !written.condition.always());
}

const Param* backend_param(const NodeType& type, const Bundle& bundle) {
    return type.param(bundle.param);
}

const Bundle::Backend& backend_of(const Variant& variant, const Bundle& bundle) {
    const auto chosen = variant.backends.find(bundle.param);
    if (chosen == variant.backends.end()) return bundle.backends.back();
    return *std::ranges::find(bundle.backends, chosen->second, &Bundle::Backend::name);
}

std::string to_string(const Variant& variant) {
    std::string key;
    const auto add = [&](const std::string& name, std::string_view value) {
        key += fmt::format("{}{}={}", key.empty() ? "" : ",", name, value);
    };
    for (const auto& [port, format] : variant.formats) add(port, info(format).name);
    for (const auto& [port, present] : variant.outputs) add(port, present ? "1" : "0");
    for (const auto& [param, backend] : variant.backends) add(param, backend);
    if (variant.cpu) add("class", *variant.cpu ? "cpu" : "gpu");
    if (variant.rows) add("rows", "1");
    return key;
}

size_t compared_values(const NodeType& type) {
    uint64_t sets = 1;
    for (const auto& [name, values] : values_in_conditions(type))
        sets = std::min<uint64_t>(sets * values.size(), 1u << 31);
    return sets;
}

std::vector<Variant> all_variants(const NodeType& type) {
    std::vector<Variant> variants(1);
    const auto multiply = [&](const auto& choices, auto&& set) {
        if (variants.size() > max_variants_made) return;
        std::vector<Variant> next;
        for (const Variant& variant : variants)
            for (const auto& choice : choices) set(next.emplace_back(variant), choice);
        variants = std::move(next);
    };
    for (const Port& port : type.ports) {
        if (has_format_choice(port))
            multiply(port.formats, [&](Variant& v, Format format) { v.formats[port.name] = format; });
        if (port.optional && is_variant_output(type, port))
            multiply(std::array{false, true},
                     [&](Variant& v, bool exists) { v.outputs[port.name] = exists; });
        if (const Param* param = port.bundle ? backend_param(type, *port.bundle) : nullptr) {
            std::vector<std::string> backends = param->values;
            std::erase(backends, "auto");
            multiply(backends, [&](Variant& v, const std::string& name) { v.backends[param->name] = name; });
        }
    }
    multiply(possible_outputs(type), [](Variant& v, const std::map<std::string, bool>& outputs) {
        v.outputs.insert(outputs.begin(), outputs.end());
    });
    if (type.by_class) multiply(std::array{false, true}, [](Variant& v, bool cpu) { v.cpu = cpu; });
    if (!row_outputs(type).empty()) {
        multiply(std::array{false, true}, [](Variant& v, bool rows) { v.rows = rows; });
        std::erase_if(variants, [](const Variant& v) { return v.rows && v.cpu == false; });
    }
    return variants;
}

}  // namespace penumbra
