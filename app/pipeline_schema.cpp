// SPDX-License-Identifier: MIT
// JSON Schema 2020-12. A node's type chooses the definition that its ports and parameters must meet; nothing
// is required, since a variant's file is a merge patch, in which null removes what the other file says.
#include "app/pipeline_schema.h"

#include <nlohmann/json.hpp>

namespace penumbra {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr const char* id_pattern = "^[a-z][a-z0-9_]*$";

OrderedJson object_of(OrderedJson properties) {
    return {
        {"type", {"object", "null"}}, {"properties", std::move(properties)}, {"additionalProperties", false}};
}

OrderedJson map_to(OrderedJson value) {
    return {{"type", {"object", "null"}},
            {"propertyNames", {{"pattern", id_pattern}}},
            {"additionalProperties", std::move(value)}};
}

OrderedJson text() {
    return {{"type", {"string", "null"}}};
}

OrderedJson one_of(std::vector<std::string> words) {
    OrderedJson values = OrderedJson::array();
    for (std::string& word : words) values.push_back(std::move(word));
    values.push_back(nullptr);
    return {{"enum", values}};
}

OrderedJson matching(const char* pattern) {
    return {{"type", {"string", "null"}}, {"pattern", pattern}};
}

OrderedJson with_doc(OrderedJson schema, const std::string& doc) {
    if (!doc.empty()) schema["description"] = doc;
    return schema;
}

OrderedJson schema_of(const Param& param) {
    OrderedJson number = {{"type", {"number", "null"}}};
    if (param.type == ParamType::integer || param.type == ParamType::uint) number["type"][0] = "integer";
    if (param.type == ParamType::uint) number["minimum"] = 0;
    if (param.range) {
        number["minimum"] = (*param.range)[0];
        number["maximum"] = (*param.range)[1];
    }
    OrderedJson schema;
    if (param.type == ParamType::boolean)
        schema = {{"type", {"boolean", "null"}}};
    else if (param.type == ParamType::enumeration)
        schema = one_of(param.values);
    else if (const auto* list = std::get_if<std::vector<float>>(&param.default_value))
        schema = {{"type", {"array", "null"}},
                  {"items", number},
                  {"minItems", list->size()},
                  {"maxItems", list->size()}};
    else
        schema = number;
    schema["default"] = std::visit([](const auto& value) { return OrderedJson(value); }, param.default_value);
    return with_doc(schema, param.unit.empty() ? param.doc : param.doc + " [" + param.unit + "]");
}

OrderedJson schema_of(const NodeType& type) {
    OrderedJson in = OrderedJson::object(), out = OrderedJson::object(), params = OrderedJson::object();
    for (const Port& port : type.ports)
        (port.output ? out : in)[port.name] = with_doc(matching(port.output     ? id_pattern
                                                                : port.previous ? "^[a-z][a-z0-9_]*@-1$"
                                                                                : "^[a-z][a-z0-9_]*(@-1)?$"),
                                                       port.doc);
    for (const Param& param : type.params) params[param.name] = schema_of(param);
    return {{"description", type.doc},
            {"properties", {{"in", object_of(in)}, {"out", object_of(out)}, {"params", object_of(params)}}}};
}

OrderedJson node_schema(const NodeSet& nodes) {
    OrderedJson node = object_of({{"type", one_of(nodes.names())},
                                  {"in", {{"type", {"object", "null"}}}},
                                  {"out", {{"type", {"object", "null"}}}},
                                  {"params", {{"type", {"object", "null"}}}},
                                  {"if", text()},
                                  {"doc", text()}});
    for (const std::string& name : nodes.names())
        node["allOf"].push_back(
            {{"if", {{"properties", {{"type", {{"const", name}}}}}, {"required", {"type"}}}},
             {"then", {{"$ref", "#/$defs/" + name}}}});
    return node;
}

OrderedJson input_schema() {
    const OrderedJson size = {{"type", "array"},
                              {"items", {{"type", "integer"}, {"minimum", 1}}},
                              {"minItems", 2},
                              {"maxItems", 2}};
    return object_of({{"kind", one_of({"image", "texels", "buffer", "block", "scene"})},
                      {"format", one_of(format_names())},
                      {"extent", {{"anyOf", {one_of({"frame", "any"}), size}}}},
                      {"history", one_of({"host", "copy"})},
                      {"optional", {{"type", {"boolean", "null"}}}}});
}

}  // namespace

OrderedJson pipeline_schema(const NodeSet& nodes) {
    OrderedJson schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                          {"title", "penumbra pipeline"}};
    schema.update(object_of(
        {{"$schema", text()},
         {"penumbra", {{"const", 1}}},
         {"name", matching(id_pattern)},
         {"doc", text()},
         {"extends", text()},
         {"inputs", map_to(input_schema())},
         {"outputs", {{"type", {"array", "null"}}, {"items", {{"type", "string"}, {"pattern", id_pattern}}}}},
         {"resources",
          map_to(object_of({{"format", one_of(format_names())}, {"first", one_of({"any", "clear"})}}))},
         {"nodes", map_to(node_schema(nodes))}}));
    for (const std::string& name : nodes.names()) schema["$defs"][name] = schema_of(nodes.find(name)->type);
    return schema;
}

}  // namespace penumbra
