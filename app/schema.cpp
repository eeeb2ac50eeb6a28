// SPDX-License-Identifier: MIT
// A pipeline that extends another is a merge patch: there every value may be null and every key may be
// missing. So each definition is made twice, whole and as a patch.
#include "app/schema.h"

#include <algorithm>
#include <cfloat>
#include <limits>
#include <nlohmann/json.hpp>

#include "app/node_text.h"

namespace penumbra {
namespace {

using Schema = nlohmann::ordered_json;

constexpr const char* id_pattern = "^[a-z][a-z0-9_]{0,63}$";
constexpr const char* value_pattern = "^[a-z][a-z0-9_]{0,63}(@-1)?$";
constexpr const char* previous_pattern = "^[a-z][a-z0-9_]{0,63}@-1$";

Schema use(const std::string& name) {
    return {{"$ref", "#/definitions/" + name}};
}
Schema text(const char* pattern) {
    return {{"type", "string"}, {"pattern", pattern}};
}
Schema line() {
    return text("^[^\\r\\n]*$");
}
Schema words(const std::vector<std::string>& list) {
    return {{"enum", list}};
}

Schema whole_numbers(double low, double high, int count) {
    const Schema item = {
        {"type", "integer"}, {"minimum", static_cast<int64_t>(low)}, {"maximum", static_cast<int64_t>(high)}};
    return {{"type", "array"}, {"items", item}, {"minItems", count}, {"maxItems", count}};
}

Schema described(Schema schema, const std::string& description) {
    if (!description.empty()) schema["description"] = description;
    return schema;
}

// As graph/condition.h has it; which parameters exist is beyond a pattern.
Schema condition(const std::vector<std::string>& facts) {
    const std::string blank = "[ \\t]*", id = "[a-z][a-z0-9_]{0,63}";
    const std::string compared = "(" + blank + "(=|!=|<=?|>=?)" + blank + "[^&|<>=! \\t]([^&|<>=!]*))?";
    const std::string literal =
        blank + "!?" + blank + "(" + joined(facts, "|") + "|" + id + "\\." + id + compared + ")" + blank;
    return described(text(("^" + literal + "([&|]" + literal + ")*$").c_str()),
                     "facts, and constant parameters of nodes (NODE.PARAM, or compared with a value by = != "
                     "< <= > >=); each may "
                     "have a ! before it, & joins, | stands between alternatives");
}

// What is whole in a pipeline and may be null in a patch.
class Maker {
  public:
    Maker(const NodeSet& nodes, bool patch) : nodes_(nodes), patch_(patch), suffix_(patch ? "_patch" : "") {}

    void define(Schema& definitions) const {
        for (const std::string& name : nodes_.names())
            definitions["type_" + name + suffix_] = node_type(nodes_.find(name)->type);
        definitions["input" + suffix_] = input();
        definitions["resource" + suffix_] = resource();
        definitions["node" + suffix_] = node();
        definitions["pipeline" + suffix_] = pipeline();
    }

  private:
    Schema nullable(Schema schema, bool null_too) const {
        if (!null_too) return schema;
        Schema outer = Schema::object();
        if (schema.contains("description")) {
            outer["description"] = schema["description"];
            schema.erase("description");
        }
        outer["anyOf"] = Schema::array({std::move(schema), {{"type", "null"}}});
        return outer;
    }
    Schema value(Schema schema) const { return nullable(std::move(schema), patch_); }

    // A null for a key that does not exist removes nothing.
    Schema object(Schema properties, const std::vector<std::string>& required = {}) const {
        Schema schema = {{"type", "object"}, {"properties", std::move(properties)}};
        schema["additionalProperties"] = patch_ ? Schema{{"type", "null"}} : Schema(false);
        if (!required.empty() && !patch_) schema["required"] = required;
        return schema;
    }

    // An object of named things; null is none, patch or not.
    Schema named(Schema thing) const {
        return {{"type", "object"},
                {"patternProperties", {{id_pattern, nullable(std::move(thing), true)}}},
                {"additionalProperties", {{"type", "null"}}}};
    }

    Schema wire(const NodeType& type, const Port& port) const {
        const bool certain = port.condition.always();
        bool updated = false;
        for (const Port& other : type.ports)
            updated = updated || (other.output && other.updates == port.name);
        const bool has_no_past = port.kind == PortKind::block || port.bundle || updated;
        const char* name = "value";
        if (port.output || (certain && has_no_past)) name = "id";
        if (!port.output && certain && port.previous) name = "previous";
        Schema schema = nullable(use(name), patch_ || port.optional || !certain);
        if (schema.contains("$ref"))
            schema = {{"allOf", Schema::array({schema})}};  // a $ref hides what is beside it
        const std::string doc = port.doc.empty() ? "" : "; " + port.doc;
        return described(std::move(schema), describe(port) + doc);
    }

    static Schema number(const Param& param, const char* type, double low, double high) {
        if (param.range) {
            low = std::max(low, (*param.range)[0]);
            high = std::min(high, (*param.range)[1]);
        }
        Schema schema = {{"type", type}};
        const bool whole = low == static_cast<double>(static_cast<int64_t>(std::clamp(low, -1e15, 1e15))) &&
                           high == static_cast<double>(static_cast<int64_t>(std::clamp(high, -1e15, 1e15)));
        schema["minimum"] = whole ? Schema(static_cast<int64_t>(low)) : Schema(low);
        schema["maximum"] = whole ? Schema(static_cast<int64_t>(high)) : Schema(high);
        return schema;
    }

    Schema param(const Param& param) const {
        constexpr double most = static_cast<double>(FLT_MAX);
        Schema schema;
        size_t components = 0;
        switch (param.type) {
            case ParamType::boolean:
                schema = {{"type", "boolean"}};
                break;
            case ParamType::integer:
                schema = number(param, "integer", INT32_MIN, INT32_MAX);
                break;
            case ParamType::uint:
                schema = number(param, "integer", 0, UINT32_MAX);
                break;
            case ParamType::real:
                schema = number(param, "number", -most, most);
                break;
            case ParamType::enumeration:
                schema = words(param.values);
                break;
            case ParamType::vec2:
                components = 2;
                break;
            case ParamType::vec3:
                components = 3;
                break;
            case ParamType::vec4:
                components = 4;
                break;
        }
        if (components > 0)
            schema = {{"type", "array"},
                      {"items", number(param, "number", -most, most)},
                      {"minItems", components},
                      {"maxItems", components}};
        schema = value(std::move(schema));
        schema["default"] = json_of(param.default_value);
        return described(std::move(schema), param.doc + (param.unit.empty() ? "" : " [" + param.unit + "]"));
    }

    // What a node's type says of its ports and parameters.
    Schema node_type(const NodeType& type) const {
        Schema in = Schema::object(), out = Schema::object(), params = Schema::object();
        std::vector<std::string> required;
        for (const Port& port : type.ports) {
            (port.output ? out : in)[port.name] = wire(type, port);
            if (port.previous && !port.optional && port.condition.always()) required.push_back(port.name);
        }
        for (const Param& p : type.params) params[p.name] = param(p);
        Schema schema = {{"properties",
                          {{"in", value(object(in, required))},
                           {"out", value(object(out))},
                           {"params", value(object(params))}}}};
        if (!required.empty() && !patch_) schema["required"] = {"in"};
        return schema;
    }

    Schema node() const {
        Schema types = Schema::array(), rules = Schema::array();
        for (const std::string& name : nodes_.names()) {
            types.push_back({{"const", name}, {"description", nodes_.find(name)->type.doc}});
            rules.push_back({{"if", {{"required", {"type"}}, {"properties", {{"type", {{"const", name}}}}}}},
                             {"then", use("type_" + name + suffix_)}});
        }
        if (patch_) types.push_back({{"type", "null"}});
        const Schema wires = {{"type", "object"}};
        Schema schema =
            object({{"type", {{"description", "node type"}, {"anyOf", types}}},
                    {"in", described(value(wires), "port: the resource that it reads, or its value @-1")},
                    {"out", described(value(wires), "port: the name of what it writes")},
                    {"params", value({{"type", "object"}})},
                    {"if", value(use("condition"))},
                    {"doc", value(line())}},
                   {"type"});
        schema["allOf"] = rules;
        return schema;
    }

    Schema input() const {
        std::vector<std::string> kinds = {"image", "texels", "buffer", "block"},
                                 no_texels = {"buffer", "block"};
        for (const Bundle& bundle : nodes_.domain()->bundles) {
            kinds.push_back(bundle.kind);
            no_texels.push_back(bundle.kind);
        }
        const Schema extent = {
            {"anyOf", Schema::array({words({"frame", "any"}), whole_numbers(1, 65536, 2)})}};
        Schema schema = object(
            {{"kind", value(described(words(kinds), "default: what the readers take"))},
             {"format", value(use("format"))},
             {"extent", value(described(extent, "default: frame"))},
             {"history", value(described(words({"host"}), "the host also brings the value for @-1"))},
             {"optional", value({{"type", "boolean"}, {"description", "the host may leave it out"}})}});
        if (patch_) return schema;
        schema["if"] = {{"required", {"kind"}}, {"properties", {{"kind", words(no_texels)}}}};
        schema["then"] = {{"properties", {{"format", false}, {"extent", false}}}};
        return schema;
    }

    Schema resource() const {
        return object({{"format", value(use("format"))},
                       {"first", value(described(words({"any", "clear"}),
                                                 "what a reader of @-1 sees on the first frame"))}});
    }

    Schema pipeline() const {
        const Schema outputs = {
            {"type", "array"}, {"items", use("id")}, {"minItems", 1}, {"uniqueItems", true}};
        Schema nodes = named(use("node" + suffix_));
        if (!patch_) nodes["minProperties"] = 1;
        Schema properties = {{"$schema", value({{"type", "string"}})},
                             {"penumbra", value({{"const", 1}, {"description", "version of the format"}})},
                             {"name", value(use("id"))},
                             {"doc", value(line())}};
        if (patch_)
            properties["extends"] = {{"type", "string"},
                                     {"minLength", 1},
                                     {"description", "file that this one patches (RFC 7396)"}};
        properties["inputs"] =
            value(described(named(use("input" + suffix_)), "what the host hands over each frame"));
        properties["outputs"] = value(described(outputs, "what the host gets"));
        properties["nodes"] = value(described(nodes, "in any order: the dataflow decides"));
        properties["resources"] =
            value(described(named(use("resource" + suffix_)), "settings of what nodes write"));
        return object(properties, {"penumbra", "name", "outputs", "nodes"});
    }

    const NodeSet& nodes_;
    bool patch_;
    std::string suffix_;
};

void write(std::string& out, const Schema& json, size_t indent) {
    constexpr size_t longest = 140;
    const std::string flat = json.dump();
    const bool plain = std::ranges::none_of(json, [](const Schema& item) { return item.is_structured(); });
    if (!json.is_structured() || (json.is_array() && plain) || flat.size() + indent <= longest) {
        out += flat;
        return;
    }
    const bool object = json.is_object();
    out += object ? "{" : "[";
    bool first = true;
    for (const auto& [key, item] : json.items()) {
        out += (first ? "\n" : ",\n") + std::string(indent + 1, ' ');
        if (object) out += Schema(key).dump() + ": ";
        write(out, item, indent + 1);
        first = false;
    }
    out += "\n" + std::string(indent, ' ') + (object ? "}" : "]");
}

}  // namespace

nlohmann::ordered_json pipeline_schema(const NodeSet& nodes) {
    Schema definitions = {{"id", text(id_pattern)},
                          {"value", text(value_pattern)},
                          {"previous", text(previous_pattern)},
                          {"format", words(format_names())},
                          {"condition", condition(nodes.domain()->fact_list())}};
    Maker(nodes, false).define(definitions);
    Maker(nodes, true).define(definitions);
    return {
        {"$schema", "http://json-schema.org/draft-07/schema#"},
        {"title", "penumbra pipeline"},
        {"description", "Made by `penumbra nodes --format schema` from the declarations of the node types."},
        {"type", "object"},
        {"if", {{"required", {"extends"}}}},
        {"then", use("pipeline_patch")},
        {"else", use("pipeline")},
        {"definitions", definitions}};
}

std::string schema_text(const nlohmann::ordered_json& schema) {
    std::string out;
    write(out, schema, 0);
    return out + "\n";
}

}  // namespace penumbra
