// SPDX-License-Identifier: MIT
// penumbra nodes: the node types as text, Markdown, JSON or the JSON Schema of pipelines, all from their
// declarations; and what declarations may say, as a JSON Schema or a page.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/node_folders.h"
#include "app/node_text.h"
#include "app/plan_schema.h"
#include "app/reference_pages.h"
#include "app/schema.h"
#include "app/vocabulary_page.h"
#include "graph/interface.h"

namespace penumbra {
namespace {

using OrderedJson = nlohmann::ordered_json;

// Of whole numbers in whole numbers, as they are set.
OrderedJson range_json(const Param& param) {
    if (!param.range) return nullptr;
    const auto [low, high] = *param.range;
    if (param.type == ParamType::integer || param.type == ParamType::uint)
        return {static_cast<int64_t>(low), static_cast<int64_t>(high)};
    return {low, high};
}

OrderedJson declaration_json(const NodeType& type) {
    OrderedJson inputs = OrderedJson::object(), outputs = OrderedJson::object(),
                params = OrderedJson::object();
    for (const Port& port : type.ports)
        (port.output ? outputs : inputs)[port.name] = {
            {"kind", port.bundle ? port.bundle->kind : kind_name(port.kind)},
            {"formats", format_names_of(port)},
            {"element", port.element},
            {"row", port.row},
            {"updates", port.updates},
            {"previous", port.previous},
            {"optional", port.optional},
            {"if", to_string(port.condition)},
            {"range", port.ranges},
            {"doc", port.doc}};
    for (const Param& param : type.params) {
        params[param.name] = {{"type", type_name(param.type)}, {"default", json_of(param.default_value)},
                              {"values", param.values},        {"unit", param.unit},
                              {"constant", param.constant},    {"doc", param.doc}};
        params[param.name]["range"] = range_json(param);
    }
    return {{"node", type.name},         {"doc", type.doc},          {"needs", type.needs},
            {"inputs", inputs},          {"outputs", outputs},       {"params", params},
            {"counters", type.counters}, {"jittered", type.jittered}};
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

// node.glsl of the variant with the most outputs.
std::string glsl_of(const NodeType& type) {
    const std::vector<Variant> all = all_variants(type);
    const auto outputs = [](const Variant& variant) {
        return std::ranges::count_if(variant.outputs, [](const auto& output) { return output.second; });
    };
    return generate_glsl(type, *std::ranges::max_element(all, {}, outputs));
}

}  // namespace

int run_nodes(const NodesArguments& arguments) {
    const auto nodes = open_nodes(arguments.node_folders);
    if (!nodes) return exit_wrong;
    std::vector<std::string> names = nodes->names();
    const bool of_all = arguments.format == "schema" || arguments.format == "node-schema" ||
                        arguments.format == "plan-schema" || arguments.format == "vocabulary" ||
                        arguments.format == "page";
    if (of_all) {
        if (!arguments.type.empty()) {
            std::cerr << "--format " << arguments.format << " is about all types; leave \"" << arguments.type
                      << "\" out\n";
            return exit_wrong;
        }
        if (arguments.format == "vocabulary")
            std::cout << vocabulary_page(*nodes->domain());
        else if (arguments.format == "page")
            std::cout << nodes_page(*nodes);
        else
            std::cout << schema_text(arguments.format == "schema" ? pipeline_schema(*nodes)
                                     : arguments.format == "node-schema"
                                         ? declaration_schema(*nodes->domain())
                                         : plan_schema());
        return exit_good;
    }
    if (!arguments.type.empty()) {
        if (!nodes->find(arguments.type)) {
            std::cerr << "there is no node type \"" << arguments.type << "\""
                      << did_you_mean(arguments.type, names) << "\n";
            return exit_wrong;
        }
        names = {arguments.type};
    }
    if (arguments.format == "glsl" && arguments.type.empty()) {
        std::cerr << "--format glsl is about one type\n";
        return exit_wrong;
    }
    OrderedJson list = OrderedJson::array();
    for (const std::string& name : names) {
        const NodeType& type = nodes->find(name)->type;
        if (arguments.format == "json")
            list.push_back(declaration_json(type));
        else if (arguments.format == "md")
            std::cout << node_section(type);
        else if (arguments.format == "glsl")
            std::cout << glsl_of(type);
        else if (arguments.type.empty())
            fmt::print("{:12} {}\n", name, type.doc);
        else
            print_text(type);
    }
    if (arguments.format == "json") std::cout << list.dump(2) << "\n";
    return exit_good;
}

}  // namespace penumbra
