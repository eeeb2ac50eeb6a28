// SPDX-License-Identifier: MIT
#include "app/node_text.h"

#include <fmt/format.h>

namespace penumbra {

const char* type_name(ParamType type) {
    constexpr const char* names[] = {"bool", "int", "uint", "float", "vec2", "vec3", "vec4", "enum"};
    return names[static_cast<int>(type)];
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
    std::string text = kind_name(port.kind);
    if (!port.formats.empty()) text += " " + joined(format_names_of(port), "|");
    if (!port.element.empty()) text += " " + port.element;
    if (!port.updates.empty()) text = "updates " + port.updates;
    if (port.previous) text += ", previous frame's";
    if (port.optional) text += ", optional";
    if (!port.condition.empty()) text += ", if " + to_string(port.condition);
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
