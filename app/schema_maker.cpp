// SPDX-License-Identifier: MIT
#include "app/schema_maker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cfloat>
#include <map>

#include "app/node_text.h"

namespace penumbra::schema {
namespace {

Schema different(Schema list) {
    list["uniqueItems"] = true;
    return list;
}

// As penumbra/condition.h has it; which parameters exist is beyond a pattern.
Schema condition(const std::vector<std::string>& facts, bool in_pipeline) {
    const std::string blank = "[ \\t]*", id = "[a-z][a-z0-9_]{0,63}";
    const std::string compared = "(" + blank + "(=|!=|<=?|>=?)" + blank + "[^&|<>=! \\t]([^&|<>=!]*))?";
    const std::string node = in_pipeline ? joined(facts, "|") + "|" + id + "\\." : "";
    const std::string literal = blank + "!?" + blank + "(" + node + id + compared + ")" + blank;
    const char* param =
        in_pipeline ? "constant parameters of nodes (NODE.PARAM" : "constant parameters (PARAM";
    return described(
        text(("^" + literal + "([&|]" + literal + ")*$").c_str()),
        fmt::format("facts ({}), and {}, or compared with a value by = != < <= > >=); each may have a "
                    "! before it, & joins, | stands between alternatives",
                    joined(facts, ", "), param));
}

}  // namespace

Schema use(const std::string& definition) {
    return {{"$ref", "#/definitions/" + definition}};
}
Schema text(const char* pattern) {
    return {{"type", "string"}, {"pattern", pattern}};
}
Schema words(const std::vector<std::string>& list) {
    return {{"enum", list}};
}

Schema list_of(Schema item, size_t least, size_t most) {
    Schema list = {{"type", "array"}, {"items", std::move(item)}};
    if (least > 0) list["minItems"] = least;
    if (most > 0) list["maxItems"] = most;
    return list;
}
Schema one_or_list(const char* definition) {
    return {{"anyOf", Schema::array({use(definition), different(list_of(use(definition), 1, 0))})}};
}
Schema only_if(Schema condition, Schema then) {
    return {{"if", std::move(condition)}, {"then", std::move(then)}};
}
Schema is(std::string_view key, Schema value) {
    return {{"required", {key}}, {"properties", {{key, std::move(value)}}}};
}

Schema described(Schema schema, std::string_view description) {
    if (schema.contains("$ref") && !description.empty())
        schema = {{"allOf", Schema::array({schema})}};  // a $ref hides what is beside it
    if (!description.empty()) schema["description"] = description;
    return schema;
}

Schema common_definitions(const Domain& domain, bool in_pipeline) {
    Schema definitions = {{"id", text(id_pattern)}, {"line", text("^[^\\r\\n]*$")}};
    definitions["condition"] = condition(domain.fact_list(), in_pipeline);
    definitions["format"] = words(format_names());
    return definitions;
}

Schema value_of(const Param& param) {
    constexpr double most = static_cast<double>(FLT_MAX);
    const auto number = [&](const char* type, double low, double high) {
        if (param.range) {
            low = std::max(low, (*param.range)[0]);
            high = std::min(high, (*param.range)[1]);
        }
        const auto plain = [](double x) {
            const auto whole = static_cast<int64_t>(std::clamp(x, -1e15, 1e15));
            return x == static_cast<double>(whole) ? Schema(whole) : Schema(x);
        };
        return Schema{{"type", type}, {"minimum", plain(low)}, {"maximum", plain(high)}};
    };
    switch (param.type) {
        case ParamType::boolean:
            return {{"type", "boolean"}};
        case ParamType::integer:
            return number("integer", INT32_MIN, INT32_MAX);
        case ParamType::uint:
            return number("integer", 0, UINT32_MAX);
        case ParamType::real:
            return number("number", -most, most);
        case ParamType::enumeration:
            return param.values.empty() ? use("id") : words(param.values);
        default:
            break;
    }
    const size_t components = layout_of(param.type).size / sizeof(float);
    return list_of(number("number", -most, most), components, components);
}

Maker::Maker(const Domain& domain, File file)
    : domain_(domain),
      patch_(file == File::patch),
      null_members_(file != File::declaration),
      suffix_(patch_ ? "_patch" : "") {}

Schema Maker::object(const Object& object, const Scope& scope) const {
    Schema properties = Schema::object(), needs = Schema::object();
    std::vector<std::string> required;
    for (const Key& key : object.keys) {
        if (!scope.has(key)) continue;
        const std::string name(key.name), beside(key.beside);
        properties[name] = described(value(held(key)), key.doc);
        if (!beside.empty()) needs[name].push_back(beside);
        if (key.required && beside.empty()) required.push_back(name);
        if (key.required && !beside.empty()) needs[beside].push_back(name);
    }
    Schema schema = closed(std::move(properties), required);
    if (patch_) return schema;
    if (!needs.empty()) schema["dependencies"] = needs;
    for (const std::string& form : split_words(object.exactly_one))
        schema["oneOf"].push_back({{"required", {form}}});
    return schema;
}

Schema Maker::closed(Schema properties, const std::vector<std::string>& required) const {
    Schema schema = {{"type", "object"}, {"properties", std::move(properties)}};
    schema["additionalProperties"] = patch_ ? Schema{{"type", "null"}} : Schema(false);
    if (!required.empty() && !patch_) schema["required"] = required;
    return schema;
}

Schema Maker::nullable(Schema schema, bool null_too) const {
    if (!null_too) return schema;
    Schema outer = Schema::object();
    if (schema.contains("description")) {
        outer["description"] = schema["description"];
        schema.erase("description");
    }
    outer["anyOf"] = Schema::array({std::move(schema), {{"type", "null"}}});
    return outer;
}

Schema Maker::held(const Key& key) const {
    Schema any = Schema::array();
    if (!key.words.empty()) any.push_back(words(split_words(key.words)));
    if (key.holds != Holds::word && key.holds != Holds::object) any.push_back(plain(key));
    if (key.object && key.holds != Holds::objects) any.push_back(use(name(key.object->name)));
    return any.size() == 1 ? any.front() : Schema{{"anyOf", any}};
}

Schema Maker::plain(const Key& key) const {
    static const std::map<Holds, Schema> always = {
        {Holds::text, {{"type", "string"}}},
        {Holds::file, {{"type", "string"}, {"minLength", 1}}},
        {Holds::shader, text("^[^/\\\\]+\\.comp$")},
        {Holds::line, use("line")},
        {Holds::id, use("id")},
        {Holds::flag, {{"type", "boolean"}}},
        {Holds::yes, {{"const", true}}},
        {Holds::version, {{"const", 1}}},
        {Holds::range, list_of({{"type", "number"}}, 2, 2)},
        {Holds::ranges, use("ranges")},
        {Holds::node_type, {{"type", "string"}}},
        {Holds::format, use("format")},
        {Holds::storable, use("storable")},
        {Holds::formats, use("formats")},
        {Holds::storables, use("storables")},
        {Holds::structure, text("^[A-Z][A-Za-z0-9]{0,63}$")},
        {Holds::condition, use("condition")},
        {Holds::value, Schema::object()},
        {Holds::values, {{"type", "object"}}},
        {Holds::facts, {{"type", "object"}, {"additionalProperties", {{"type", "boolean"}}}}},
        {Holds::wires, {{"type", "object"}}}};
    if (key.holds == Holds::whole) return whole(key);
    if (key.holds == Holds::wholes) return list_of(whole(key), key.min_items, key.max_items);
    if (key.holds == Holds::ids) return different(list_of(use("id"), key.min_items, 0));
    if (key.holds == Holds::kind) return words(kind_words(domain_));
    if (key.holds == Holds::needs) return different(list_of(words(need_words(domain_)), 0, 0));
    if (key.holds == Holds::truths) return different(list_of(words(domain_.fact_list()), 0, 0));
    return key.holds == Holds::objects ? members(key) : always.at(key.holds);
}

Schema Maker::whole(const Key& key) {
    Schema schema = {{"type", "integer"}, {"minimum", key.least}, {"maximum", key.greatest}};
    if (key.multiple > 1) schema["multipleOf"] = key.multiple;
    return schema;
}

Schema Maker::members(const Key& key) const {
    // Ports alone differ by the section that they stand in.
    const std::string section(key.name.substr(0, key.name.size() - 1));
    const std::string member = key.object == &vocabulary::port ? section : name(key.object->name);
    Schema schema = {{"type", "object"},
                     {"patternProperties", {{id_pattern, nullable(use(member), null_members_)}}}};
    schema["additionalProperties"] = null_members_ ? Schema{{"type", "null"}} : Schema(false);
    if (key.min_items > 0 && !patch_) schema["minProperties"] = key.min_items;
    return schema;
}

}  // namespace penumbra::schema
