// SPDX-License-Identifier: MIT
// Keys, their values and limits are the vocabulary's; what depends on several values is added here. A
// pipeline that extends another is a merge patch, so each of its definitions is made twice, whole and as a
// patch.
#include "app/schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <cfloat>
#include <map>
#include <nlohmann/json.hpp>

#include "app/node_text.h"
#include "graph/vocabulary.h"

namespace penumbra {
namespace {

using Schema = nlohmann::ordered_json;

constexpr const char* id_pattern = "^[a-z][a-z0-9_]{0,63}$";

Schema use(const std::string& name) {
    return {{"$ref", "#/definitions/" + name}};
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
Schema different(Schema list) {
    list["uniqueItems"] = true;
    return list;
}
Schema one_or_list(const char* name) {
    return {{"anyOf", Schema::array({use(name), different(list_of(use(name), 1, 0))})}};
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

// Values that may stand in any file.
Schema common_definitions(const Domain& domain, bool in_pipeline) {
    Schema definitions = {{"id", text(id_pattern)}, {"line", text("^[^\\r\\n]*$")}};
    definitions["condition"] = condition(domain.fact_list(), in_pipeline);
    definitions["format"] = words(format_names());
    return definitions;
}

// What a value of the parameter is, as far as the parameter says.
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

// Objects as the vocabulary has them. In a declaration every value counts; in a pipeline a member that is
// null is none; in a patch every value may be null besides, and every key may be missing.
enum class File { declaration, pipeline, patch };

class Maker {
  public:
    Maker(const Domain& domain, File file)
        : domain_(domain),
          patch_(file == File::patch),
          null_members_(file != File::declaration),
          suffix_(patch_ ? "_patch" : "") {}

    Schema object(const Object& object, const Scope& scope = {}) const {
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

    // An object of no other keys. A null for one that does not exist removes nothing.
    Schema closed(Schema properties, const std::vector<std::string>& required = {}) const {
        Schema schema = {{"type", "object"}, {"properties", std::move(properties)}};
        schema["additionalProperties"] = patch_ ? Schema{{"type", "null"}} : Schema(false);
        if (!required.empty() && !patch_) schema["required"] = required;
        return schema;
    }

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

    bool patch() const { return patch_; }
    std::string name(std::string_view definition) const { return std::string(definition) + suffix_; }

  private:
    // What a key holds by itself, its words, its object: any of them.
    Schema held(const Key& key) const {
        Schema any = Schema::array();
        if (!key.words.empty()) any.push_back(words(split_words(key.words)));
        if (key.holds != Holds::word && key.holds != Holds::object) any.push_back(plain(key));
        if (key.object && key.holds != Holds::objects) any.push_back(use(name(key.object->name)));
        return any.size() == 1 ? any.front() : Schema{{"anyOf", any}};
    }

    Schema plain(const Key& key) const {
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
        return key.holds == Holds::objects ? members(key) : always.at(key.holds);
    }

    static Schema whole(const Key& key) {
        Schema schema = {{"type", "integer"}, {"minimum", key.least}, {"maximum", key.greatest}};
        if (key.multiple > 1) schema["multipleOf"] = key.multiple;
        return schema;
    }

    Schema members(const Key& key) const {
        // Ports alone differ by the section that they stand in.
        const std::string section(key.name.substr(0, key.name.size() - 1));
        const std::string member = key.object == &vocabulary::port ? section : name(key.object->name);
        Schema schema = {{"type", "object"},
                         {"patternProperties", {{id_pattern, nullable(use(member), null_members_)}}}};
        schema["additionalProperties"] = null_members_ ? Schema{{"type", "null"}} : Schema(false);
        if (key.min_items > 0 && !patch_) schema["minProperties"] = key.min_items;
        return schema;
    }

    const Domain& domain_;
    bool patch_, null_members_;
    std::string suffix_;
};

// What is whole in a pipeline and may be null in a patch.
class PipelineMaker {
  public:
    PipelineMaker(const NodeSet& nodes, File file) : nodes_(nodes), maker_(*nodes.domain(), file) {}

    void define(Schema& definitions) const {
        for (const std::string& name : nodes_.names())
            definitions[maker_.name("type_" + name)] = node_type(nodes_.find(name)->type);
        definitions[maker_.name("input")] = input();
        definitions[maker_.name("instance")] = maker_.object(vocabulary::instance);
        definitions[maker_.name("resource")] = maker_.object(vocabulary::resource);
        definitions[maker_.name("node")] = node();
        definitions[maker_.name("pipeline")] = pipeline();
    }

  private:
    Schema wire(const NodeType& type, const Port& port) const {
        const bool certain = port.condition.always();
        bool updated = false;
        for (const Port& other : type.ports)
            updated = updated || (other.output && other.updates == port.name);
        const bool has_no_past = port.kind == PortKind::block || port.bundle || updated;
        const char* name = "value";
        if (port.output || (certain && has_no_past)) name = "id";
        if (!port.output && certain && port.previous) name = "previous";
        Schema schema = maker_.nullable(use(name), maker_.patch() || port.optional || !certain);
        const std::string doc = port.doc.empty() ? "" : "; " + port.doc;
        return described(std::move(schema), describe(port) + doc);
    }

    // What only a node's type knows of it: its ports and parameters.
    Schema node_type(const NodeType& type) const {
        Schema in = Schema::object(), out = Schema::object(), params = Schema::object();
        std::vector<std::string> required;
        for (const Port& port : type.ports) {
            (port.output ? out : in)[port.name] = wire(type, port);
            if (port.previous && !port.optional && port.condition.always()) required.push_back(port.name);
        }
        for (const Param& p : type.params) {
            params[p.name] = maker_.value(value_of(p));
            params[p.name]["default"] = json_of(p.default_value);
            const std::string unit = p.unit.empty() ? "" : " [" + p.unit + "]";
            params[p.name] = described(std::move(params[p.name]), p.doc + unit);
        }
        Schema schema = {{"properties",
                          {{"in", maker_.value(maker_.closed(in, required))},
                           {"out", maker_.value(maker_.closed(out))},
                           {"params", maker_.value(maker_.closed(params))}}}};
        if (!required.empty() && !maker_.patch()) schema["required"] = {"in"};
        return schema;
    }

    Schema node() const {
        Schema types = Schema::array(), rules = Schema::array();
        for (const std::string& name : nodes_.names()) {
            types.push_back({{"const", name}, {"description", nodes_.find(name)->type.doc}});
            rules.push_back(only_if(is("type", {{"const", name}}), use(maker_.name("type_" + name))));
        }
        if (maker_.patch()) types.push_back({{"type", "null"}});
        Schema schema = maker_.object(vocabulary::node);
        schema["properties"]["type"] = described({{"anyOf", types}}, vocabulary::node.at("type").doc);
        schema["allOf"] = rules;
        return schema;
    }

    // Which readers give an input its kind is beyond a schema; where it says so itself, it may not
    // contradict.
    Schema input() const {
        Schema schema = maker_.object(vocabulary::input);
        if (maker_.patch()) return schema;
        const std::vector<std::string> kinds = kind_words(*nodes_.domain());
        for (size_t i = 0; i < kinds.size(); ++i) {
            const Scope scope{.kinds = bit(std::min(i, static_cast<size_t>(PortKind::bundle)))};
            Schema none = Schema::object();
            for (const Key& key : vocabulary::input.keys)
                if (!scope.has(key)) none[std::string(key.name)] = false;
            if (!none.empty())
                schema["allOf"].push_back(only_if(is("kind", {{"const", kinds[i]}}), {{"properties", none}}));
        }
        return schema;
    }

    // A file with "extends" is a patch, and no patch of itself takes the key away.
    Schema pipeline() const {
        Schema schema = maker_.object(vocabulary::pipeline);
        Schema& extends = schema["properties"]["extends"];
        if (maker_.patch()) extends = described(extends["anyOf"][0], vocabulary::pipeline.at("extends").doc);
        return schema;
    }

    const NodeSet& nodes_;
    Maker maker_;
};

// Declarations: a port's keys depend on its kind, a parameter's on its type.
class DeclarationMaker {
  public:
    explicit DeclarationMaker(const Domain& domain) : domain_(domain), maker_(domain, File::declaration) {}

    Schema definitions() const {
        Schema all = common_definitions(domain_, false);
        std::vector<std::string> storable;
        for (const std::string& name : format_names())
            if (info(*format_named(name)).glsl) storable.push_back(name);
        all["storable"] = described(words(storable), "depth formats are only sampled");
        all["formats"] = one_or_list("format");
        all["storables"] = one_or_list("storable");
        all["open_range"] = list_of({{"type", {"number", "null"}}}, 2, 2);
        all["ranges"] = {
            {"anyOf", Schema::array({use("open_range"), list_of(use("open_range"), 1, max_channels)})}};
        all["input"] = port(false);
        all["output"] = port(true);
        all["param"] = param();
        for (const Object* object : {&vocabulary::extent, &vocabulary::count, &vocabulary::table,
                                     &vocabulary::dispatch, &vocabulary::classes, &vocabulary::device_class})
            all[std::string(object->name)] = described(maker_.object(*object), object->doc);
        all["class"]["patternProperties"] = {{id_pattern, {{"description", "a constant parameter"}}}};
        return all;
    }

    Schema declaration() const {
        Schema schema = maker_.object(vocabulary::declaration);
        const Schema writes = {{"required", {"outputs"}},
                               {"properties", {{"outputs", {{"minProperties", 1}}}}}};
        const Schema counts = {{"required", {"counters"}},
                               {"properties", {{"counters", {{"minItems", 1}}}, {"host", false}}}};
        schema["anyOf"] = Schema::array({writes, counts});
        return schema;
    }

  private:
    // One schema for each of the words that the object's selector may be.
    template <typename ForWord>
    Schema selected(const Object& object, const std::vector<std::string>& list, ForWord for_word) const {
        const std::string selector(object.selector);
        Schema schema = {{"type", "object"},
                         {"properties", {{selector, described(words(list), object.at(selector).doc)}}},
                         {"required", {selector}}};
        for (size_t i = 0; i < list.size(); ++i)
            schema["allOf"].push_back(only_if(is(selector, {{"const", list[i]}}), for_word(i)));
        return schema;
    }

    // The rows of a scope; what the selector may be has been said.
    Schema branch(const Object& object, const Scope& scope) const {
        Schema schema = maker_.object(object, scope);
        schema["properties"][std::string(object.selector)] = true;
        return schema;
    }

    Schema port(bool output) const {
        const auto scope_of = [&](size_t i) {
            return Scope{.kinds = bit(std::min(i, static_cast<size_t>(PortKind::bundle))), .output = output};
        };
        std::vector<std::string> kinds = kind_words(domain_);
        while (!vocabulary::port.find("kind", scope_of(kinds.size() - 1))) kinds.pop_back();
        return selected(vocabulary::port, kinds, [&](size_t i) {
            Scope scope = scope_of(i);
            Schema whole = branch(vocabulary::port, scope);
            if (!output && scope.kinds == bit(PortKind::image))
                whole.update(only_if(
                    is("as", {{"const", "storage"}}),
                    {{"properties",
                      {{"format", use("storables")}, {"filter", false}, {"levels", {{"const", false}}}}}}));
            if (!output) return whole;
            if (scope.kinds == bit(PortKind::image))
                whole.update(only_if(
                    is("layers", {{"const", true}}),
                    {{"anyOf", Schema::array({{{"required", {"extent"}}}, {{"required", {"layers_of"}}}})}}));
            scope.updating = true;
            Schema either = only_if({{"required", {"updates"}}}, branch(vocabulary::port, scope));
            either["else"] = whole;
            return either;
        });
    }

    Schema param() const {
        return selected(vocabulary::param, param_type_words(), [&](size_t i) {
            Schema schema = branch(vocabulary::param, {.kinds = bit(i)});
            const Schema value = value_of(Param{.type = static_cast<ParamType>(i)});
            schema["properties"]["default"] = described(value, vocabulary::param.at("default").doc);
            return schema;
        });
    }

    const Domain& domain_;
    Maker maker_;
};

}  // namespace

nlohmann::ordered_json pipeline_schema(const NodeSet& nodes) {
    Schema definitions = common_definitions(*nodes.domain(), true);
    definitions["value"] = text("^[a-z][a-z0-9_]{0,63}(@(-1|before|last))?$");
    definitions["previous"] = text("^[a-z][a-z0-9_]{0,63}@-1$");
    PipelineMaker(nodes, File::pipeline).define(definitions);
    PipelineMaker(nodes, File::patch).define(definitions);
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

nlohmann::ordered_json declaration_schema(const Domain& domain) {
    const DeclarationMaker maker(domain);
    Schema schema = {
        {"$schema", "http://json-schema.org/draft-07/schema#"},
        {"title", "penumbra node declaration"},
        {"description", "Made by `penumbra nodes --format node-schema` from the graph's vocabulary."}};
    schema.update(maker.declaration());
    schema["definitions"] = maker.definitions();
    return schema;
}

}  // namespace penumbra
