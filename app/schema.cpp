// SPDX-License-Identifier: MIT
// Keys, their values and limits are the vocabulary's; what depends on several values is added here. A
// pipeline that extends another is a merge patch, so each of its definitions is made twice, whole and as a
// patch.
#include "app/schema.h"

#include <algorithm>

#include "app/node_text.h"
#include "app/schema_maker.h"

namespace penumbra {
namespace {

using namespace schema;

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
