// SPDX-License-Identifier: MIT
// Parameters of a node declaration and values for them. The same function reads a declaration's default, a
// pipeline's value, a device class's override and the VALUE of a condition, so that they cannot differ in
// what they accept.
#include "graph/node_param.h"

#include <fmt/format.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <limits>

#include "graph/json_reader.h"

namespace penumbra {

namespace {

std::string number_text(double value) {
    return fmt::format("{}", value);
}

bool in_range(const Param& param, double value, const Json& json, const std::string& path,
              Diagnostics& diagnostics) {
    if (!param.range || (value >= (*param.range)[0] && value <= (*param.range)[1])) return true;
    diagnostics.add(
        json.place, path,
        fmt::format("{} is outside {} .. {}{}{}", number_text(value), number_text((*param.range)[0]),
                    number_text((*param.range)[1]), param.unit.empty() ? "" : " ", param.unit));
    return false;
}

std::optional<float> read_float(const Param& param, const Json& json, const std::string& path,
                                Diagnostics& diagnostics) {
    if (!json.is_number()) {
        diagnostics.add(json.place, path, fmt::format("expected a number, got {}", kind_name(json.kind)));
        return std::nullopt;
    }
    if (!in_range(param, json.real, json, path, diagnostics)) return std::nullopt;
    if (!(std::abs(json.real) <= static_cast<double>(FLT_MAX))) {
        diagnostics.add(json.place, path,
                        fmt::format("{} does not fit a 32-bit float", number_text(json.real)));
        return std::nullopt;
    }
    return static_cast<float>(json.real);
}

// The limits of int and uint apply on top of the parameter's range.
template <typename Integer>
std::optional<ParamValue> read_integer(const Param& param, const Json& json, const std::string& path,
                                       Diagnostics& diagnostics) {
    using Limits = std::numeric_limits<Integer>;
    if (!expect(json, Json::Kind::integer, path, diagnostics)) return std::nullopt;
    if (!in_range(param, json.real, json, path, diagnostics)) return std::nullopt;
    if (json.integer < int64_t{Limits::min()} || json.integer > int64_t{Limits::max()}) {
        diagnostics.add(json.place, path,
                        fmt::format("{} is outside {} .. {}", json.integer, Limits::min(), Limits::max()));
        return std::nullopt;
    }
    return static_cast<Integer>(json.integer);
}

void read_param(const JsonMember& member, NodeType& type, Diagnostics& diagnostics) {
    const std::vector<std::string> types = param_type_words();
    const Json* given = member.value.find("type");
    const size_t word =
        given ? static_cast<size_t>(std::ranges::find(types, given->string) - types.begin()) : types.size();
    Param param{.name = member.key, .type = static_cast<ParamType>(word), .place = member.key_place};
    Scope scope{.kinds = unknown_kind};
    if (word < types.size()) scope = {.kinds = bit(word), .owner = "a parameter of type " + types[word]};
    const ObjectReader reader(member.value, "params." + member.key, vocabulary::param, diagnostics, scope);
    param.doc = reader.text("doc");
    param.unit = reader.text("unit");
    param.constant = reader.flag("constant");
    if (vocabulary::device_class.knows(param.name))
        diagnostics.add(member.key_place, reader.path(), "this name belongs to the dispatch rule");
    if (!reader.word("type")) return;
    for (const ObjectReader::Item& item : reader.list("values")) param.values.push_back(item.text);
    if (const Json* range = reader.find("range"))
        param.range = read_range(*range, false, reader.path("range"), diagnostics);
    if (const Json* fallback = reader.find("default"))
        if (const auto value = parse_param_value(param, *fallback, reader.path("default"), diagnostics))
            param.default_value = *value;
    type.params.push_back(std::move(param));
}

}  // namespace

void parse_params(const Json& json, NodeType& type, Diagnostics& diagnostics) {
    if (!expect(json, Json::Kind::object, "params", diagnostics)) return;
    for (const JsonMember& member : json.members) read_param(member, type, diagnostics);
}

ParamLayout layout_of(ParamType type) {
    switch (type) {
        case ParamType::vec2:
            return {8, 8};
        case ParamType::vec3:
            return {12, 16};
        case ParamType::vec4:
            return {16, 16};
        default:
            return {4, 4};
    }
}

std::optional<ParamValue> parse_param_text(const Param& param, const std::string& text, const Place& place,
                                           const std::string& path, Diagnostics& diagnostics) {
    Diagnostics unused;
    std::optional<Json> json;
    if (param.type != ParamType::enumeration) json = parse_json(text, "", unused);
    if (!json) {
        json.emplace();
        json->kind = Json::Kind::string;
        json->string = text;
    }
    json->place = place;
    return parse_param_value(param, *json, path, diagnostics);
}

std::optional<ParamValue> parse_param_value(const Param& param, const Json& json, const std::string& path,
                                            Diagnostics& diagnostics) {
    switch (param.type) {
        case ParamType::boolean:
            if (!expect(json, Json::Kind::boolean, path, diagnostics)) return std::nullopt;
            return json.boolean;
        case ParamType::integer:
            return read_integer<int32_t>(param, json, path, diagnostics);
        case ParamType::uint:
            return read_integer<uint32_t>(param, json, path, diagnostics);
        case ParamType::real:
            return read_float(param, json, path, diagnostics);
        case ParamType::enumeration: {
            if (!expect(json, Json::Kind::string, path, diagnostics)) return std::nullopt;
            if (std::ranges::find(param.values, json.string) != param.values.end()) return json.string;
            diagnostics.add(json.place, path,
                            fmt::format("no value \"{}\" (values: {}){}", json.string, join(param.values),
                                        did_you_mean(json.string, param.values)));
            return std::nullopt;
        }
        default:
            break;
    }
    const size_t size = layout_of(param.type).size / sizeof(float);
    if (!expect(json, Json::Kind::array, path, diagnostics)) return std::nullopt;
    if (json.items.size() != size) {
        diagnostics.add(json.place, path,
                        fmt::format("expected {} numbers, got {}", size, json.items.size()));
        return std::nullopt;
    }
    std::vector<float> vector;
    for (size_t i = 0; i < size; ++i)
        if (const auto number = read_float(param, json.items[i], fmt::format("{}[{}]", path, i), diagnostics))
            vector.push_back(*number);
    if (vector.size() != size) return std::nullopt;
    return vector;
}

}  // namespace penumbra
