// SPDX-License-Identifier: MIT
// penumbra nodes: the node types as text, Markdown, JSON or the JSON Schema of pipelines, all from their
// declarations.
#include <fmt/format.h>

#include <iostream>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/pipeline_schema.h"
#include "nodes/nodes.h"

namespace penumbra {
namespace {

using OrderedJson = nlohmann::ordered_json;

const char* name_of(ParamType type) {
    constexpr const char* names[] = {"bool", "int", "uint", "float", "vec2", "vec3", "vec4", "enum"};
    return names[static_cast<int>(type)];
}

OrderedJson json_of(const ParamValue& value) {
    return std::visit([](const auto& v) { return OrderedJson(v); }, value);
}

std::vector<std::string> formats_of(const Port& port) {
    std::vector<std::string> names;
    for (const Format format : port.formats) names.push_back(info(format).name);
    return names;
}

OrderedJson json_of(const NodeType& type) {
    OrderedJson inputs = OrderedJson::object(), outputs = OrderedJson::object(),
                params = OrderedJson::object();
    for (const Port& port : type.ports)
        (port.output ? outputs : inputs)[port.name] = {
            {"kind", kind_name(port.kind)},    {"formats", formats_of(port)},
            {"element", port.element},         {"updates", port.updates},
            {"previous", port.previous},       {"optional", port.optional},
            {"if", to_string(port.condition)}, {"doc", port.doc}};
    for (const Param& param : type.params) {
        params[param.name] = {{"type", name_of(param.type)}, {"default", json_of(param.default_value)},
                              {"values", param.values},      {"unit", param.unit},
                              {"constant", param.constant},  {"doc", param.doc}};
        params[param.name]["range"] = param.range ? OrderedJson(*param.range) : OrderedJson();
    }
    return {{"node", type.name},  {"doc", type.doc},  {"needs", type.needs},      {"inputs", inputs},
            {"outputs", outputs}, {"params", params}, {"counters", type.counters}};
}

std::string joined(const std::vector<std::string>& words, const char* separator) {
    return fmt::format("{}", fmt::join(words, separator));
}

std::string describe(const Port& port) {
    std::string text = kind_name(port.kind);
    if (!port.formats.empty()) text += " " + joined(formats_of(port), "|");
    if (!port.element.empty()) text += " " + port.element;
    if (!port.updates.empty()) text = "updates " + port.updates;
    if (port.previous) text += ", previous frame's";
    if (port.optional) text += ", optional";
    if (!port.condition.empty()) text += ", if " + to_string(port.condition);
    return text;
}

std::string describe(const Param& param) {
    std::string text = name_of(param.type);
    if (!param.values.empty()) text = joined(param.values, "|");
    if (param.range) text += fmt::format(" {}..{}", (*param.range)[0], (*param.range)[1]);
    if (!param.unit.empty()) text += " " + param.unit;
    return text + " = " + json_of(param.default_value).dump();
}

void print_text(const NodeType& type) {
    fmt::print("{}: {}\n", type.name, type.doc);
    for (const Port& port : type.ports)
        fmt::print("  {} {:18} {}{}\n", port.output ? "out" : "in ", port.name, describe(port),
                   port.doc.empty() ? "" : "  (" + port.doc + ")");
    for (const Param& param : type.params)
        fmt::print("  {} {:16} {}{}\n", param.constant ? "const" : "param", param.name, describe(param),
                   param.doc.empty() ? "" : "  (" + param.doc + ")");
    for (const std::string& counter : type.counters) fmt::print("  counts {}\n", counter);
}

void print_markdown(const NodeType& type) {
    fmt::print("### {}\n\n{}\n\n| | name | what | |\n|---|---|---|---|\n", type.name, type.doc);
    for (const Port& port : type.ports)
        fmt::print("| {} | `{}` | {} | {} |\n", port.output ? "out" : "in", port.name, describe(port),
                   port.doc);
    for (const Param& param : type.params)
        fmt::print("| {} | `{}` | {} | {} |\n", param.constant ? "constant" : "parameter", param.name,
                   describe(param), param.doc);
    fmt::print("\n");
}

}  // namespace

int run_nodes(const NodesArguments& arguments) {
    const NodeSet nodes = shadow_nodes();
    std::vector<std::string> names = nodes.names();
    if (!arguments.type.empty()) {
        if (!nodes.find(arguments.type)) {
            std::cerr << "there is no node type \"" << arguments.type << "\""
                      << did_you_mean(arguments.type, names) << "\n";
            return exit_wrong;
        }
        names = {arguments.type};
    }
    if (arguments.format == "schema") {
        std::cout << pipeline_schema(nodes).dump(2) << "\n";
        return exit_good;
    }
    OrderedJson list = OrderedJson::array();
    for (const std::string& name : names) {
        const NodeType& type = nodes.find(name)->type;
        if (arguments.format == "json")
            list.push_back(json_of(type));
        else if (arguments.format == "md")
            print_markdown(type);
        else if (arguments.type.empty())
            fmt::print("{:12} {}\n", name, type.doc);
        else
            print_text(type);
    }
    if (arguments.format == "json") std::cout << list.dump(2) << "\n";
    return exit_good;
}

}  // namespace penumbra
