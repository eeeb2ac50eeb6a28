// SPDX-License-Identifier: MIT
#include "app/node_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "graph/vocabulary.h"

namespace penumbra {
namespace {

// "0..1" for every channel, "x 0..1, y 0..inf" for some.
std::string describe_ranges(const std::vector<std::array<double, 2>>& ranges) {
    const auto text_of = [](const std::array<double, 2>& r) { return fmt::format("{}..{}", r[0], r[1]); };
    if (ranges.size() == 4 && std::ranges::count(ranges, ranges.front()) == 4) return text_of(ranges.front());
    std::string text;
    for (size_t i = 0; i < ranges.size(); ++i)
        text += fmt::format("{}{} {}", i ? ", " : "", "xyzw"[i], text_of(ranges[i]));
    return text;
}

}  // namespace

std::string type_name(ParamType type) {
    return param_type_words()[static_cast<size_t>(type)];
}

nlohmann::ordered_json json_of(const ParamValue& value) {
    return std::visit([](const auto& v) { return nlohmann::ordered_json(v); }, value);
}

std::vector<std::string> format_names_of(const Port& port) {
    std::vector<std::string> names;
    for (const Format format : port.formats) names.push_back(info(format).name);
    return names;
}

std::string joined(const std::vector<std::string>& words, const char* separator) {
    return fmt::format("{}", fmt::join(words, separator));
}

std::string describe(const Port& port) {
    std::string text = port.bundle ? port.bundle->kind : kind_name(port.kind);
    if (!port.formats.empty()) text += " " + joined(format_names_of(port), "|");
    if (!port.element.empty()) text += " " + port.element;
    if (port.row) text += fmt::format(", rows of {}", port.row);
    if (!port.updates.empty()) text = "updates " + port.updates;
    if (port.previous) text += ", previous frame's";
    if (port.optional) text += ", optional";
    if (!port.condition.always()) text += ", if " + to_string(port.condition);
    if (!port.ranges.empty()) text += ", " + describe_ranges(port.ranges);
    return text;
}

std::string describe(const Param& param) {
    std::string text = type_name(param.type);
    if (!param.values.empty()) text = joined(param.values, "|");
    if (param.range) text += fmt::format(" {}..{}", (*param.range)[0], (*param.range)[1]);
    if (!param.unit.empty()) text += " " + param.unit;
    return text + " = " + json_of(param.default_value).dump();
}

}  // namespace penumbra
