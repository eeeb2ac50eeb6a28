// SPDX-License-Identifier: MIT
// Reading objects of the vocabulary, and which names generated GLSL can carry.
#include "graph/json_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>

namespace penumbra {

namespace {

// Lower-case words that an identifier in our GLSL may not take: keywords and reserved words (GLSL 4.60,
// section 3.6; GL_KHR_vulkan_glsl; the explicit arithmetic types), then built-in functions (chapter 8), which
// a global of the same name would hide. Sorted, for the binary search.
constexpr auto reserved_words = std::to_array<std::string_view>(
    {"active",        "asm",      "atomic_uint", "attribute", "bool",      "break",     "buffer",
     "bvec2",         "bvec3",    "bvec4",       "case",      "cast",      "centroid",  "class",
     "coherent",      "common",   "const",       "continue",  "default",   "discard",   "dmat2",
     "dmat3",         "dmat4",    "do",          "double",    "dvec2",     "dvec3",     "dvec4",
     "else",          "enum",     "extern",      "external",  "false",     "filter",    "fixed",
     "flat",          "float",    "float16_t",   "float32_t", "float64_t", "for",       "fvec2",
     "fvec3",         "fvec4",    "goto",        "half",      "highp",     "hvec2",     "hvec3",
     "hvec4",         "if",       "in",          "inline",    "inout",     "input",     "int",
     "int16_t",       "int32_t",  "int64_t",     "int8_t",    "interface", "invariant", "ivec2",
     "ivec3",         "ivec4",    "layout",      "long",      "lowp",      "main",      "mat2",
     "mat2x2",        "mat2x3",   "mat2x4",      "mat3",      "mat3x2",    "mat3x3",    "mat3x4",
     "mat4",          "mat4x2",   "mat4x3",      "mat4x4",    "mediump",   "namespace", "noinline",
     "noperspective", "out",      "output",      "partition", "patch",     "precise",   "precision",
     "public",        "readonly", "resource",    "restrict",  "return",    "sample",    "sampler",
     "shared",        "short",    "sizeof",      "smooth",    "static",    "struct",    "subroutine",
     "superp",        "switch",   "template",    "texture",   "this",      "true",      "typedef",
     "uint",          "uint16_t", "uint32_t",    "uint64_t",  "uint8_t",   "uniform",   "union",
     "unsigned",      "using",    "uvec2",       "uvec3",     "uvec4",     "varying",   "vec2",
     "vec3",          "vec4",     "void",        "volatile",  "while",     "writeonly"});
static_assert(std::ranges::is_sorted(reserved_words));

constexpr auto builtin_functions = std::to_array<std::string_view>(
    {"abs",         "acos",     "acosh",      "all",     "any",         "asin",    "asinh",       "atan",
     "atanh",       "barrier",  "ceil",       "clamp",   "cos",         "cosh",    "cross",       "degrees",
     "determinant", "distance", "dot",        "equal",   "exp",         "exp2",    "faceforward", "floor",
     "fma",         "fract",    "frexp",      "inverse", "inversesqrt", "isinf",   "isnan",       "ldexp",
     "length",      "log",      "log2",       "max",     "min",         "mix",     "mod",         "modf",
     "normalize",   "not",      "pow",        "radians", "reflect",     "refract", "round",       "sign",
     "sin",         "sinh",     "smoothstep", "sqrt",    "step",        "tan",     "tanh",        "transpose",
     "trunc"});
static_assert(std::ranges::is_sorted(builtin_functions));

}  // namespace

bool is_id(std::string_view name) {
    const auto letter = [](char c) { return c >= 'a' && c <= 'z'; };
    const auto rest = [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_'; };
    return !name.empty() && name.size() <= 64 && letter(name.front()) && std::ranges::all_of(name, rest);
}

const char* glsl_name_problem(std::string_view name) {
    if (std::ranges::binary_search(reserved_words, name)) return "a reserved word of GLSL";
    if (std::ranges::binary_search(builtin_functions, name)) return "a built-in function of GLSL";
    if (name.starts_with("gl_")) return "reserved by GLSL (gl_ begins built-in names)";
    if (name.find("__") != std::string_view::npos) return "reserved by GLSL (two underscores in a row)";
    return nullptr;
}

bool expect(const Json& json, Json::Kind kind, const std::string& path, Diagnostics& diagnostics) {
    if (json.kind == kind) return true;
    diagnostics.add(json.place, path,
                    fmt::format("expected {}, got {}", kind_name(kind), kind_name(json.kind)));
    return false;
}

bool expect_id(const std::string& name, const Place& place, const std::string& path,
               Diagnostics& diagnostics) {
    if (is_id(name)) return true;
    diagnostics.add(place, path, fmt::format("\"{}\" is no id ([a-z][a-z0-9_]*)", name));
    return false;
}

namespace {

bool is_struct_name(std::string_view name) {
    const auto upper = [](char c) { return c >= 'A' && c <= 'Z'; };
    const auto rest = [&](char c) { return upper(c) || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); };
    return !name.empty() && name.size() <= 64 && upper(name.front()) && std::ranges::all_of(name, rest);
}

// What is wrong with a text, or nothing.
std::string text_problem(const Key& key, const std::string& text) {
    const auto first_of = [&](const char* characters) {
        return text.find_first_of(characters) != std::string::npos;
    };
    const std::vector<std::string> words = split_words(key.words);
    switch (key.holds) {
        case Holds::file:
            return text.empty() ? "the name is empty" : "";
        case Holds::shader:
            if (!first_of("/\\") && text.size() > 5 && text.ends_with(".comp")) return "";
            return fmt::format("\"{}\" is no file name that ends in .comp", text);
        case Holds::line:
            return first_of("\r\n") ? "must be one line" : "";
        case Holds::structure:
            if (is_struct_name(text) || std::ranges::find(words, text) != words.end()) return "";
            if (words.empty()) return fmt::format("\"{}\" is no struct's name (like \"Light\")", text);
            return fmt::format("\"{}\" is no struct's name and none of {}{}", text, join(words),
                               did_you_mean(text, words));
        default:
            return "";
    }
}

std::optional<uint32_t> read_whole(const Json& json, const Key& key, const std::string& path,
                                   Diagnostics& diagnostics) {
    if (!expect(json, Json::Kind::integer, path, diagnostics)) return std::nullopt;
    if (json.integer < key.least || json.integer > key.greatest)
        diagnostics.add(json.place, path,
                        fmt::format("{} is outside {} .. {}", json.integer, key.least, key.greatest));
    else if (json.integer % key.multiple != 0)
        diagnostics.add(json.place, path, fmt::format("must be a multiple of {}", key.multiple));
    else
        return static_cast<uint32_t>(json.integer);
    return std::nullopt;
}

}  // namespace

ObjectReader::ObjectReader(const Json& json, std::string path, const Object& object, Diagnostics& diagnostics,
                           Scope scope)
    : json_(json),
      path_(std::move(path)),
      object_(object),
      diagnostics_(diagnostics),
      scope_(std::move(scope)) {
    if (!expect(json_, Json::Kind::object, path_, diagnostics_)) return;
    std::vector<std::string> names = object.names();
    names.insert(names.end(), scope_.names.begin(), scope_.names.end());
    for (const JsonMember& member : json_.members) {
        const auto complain = [&](const std::string& message) {
            diagnostics_.add(member.key_place, path_, fmt::format("key \"{}\" {}", member.key, message));
        };
        const Key* key = object.find(member.key, scope_);
        if (std::ranges::find(names, member.key) == names.end())
            diagnostics_.add(
                member.key_place, path_,
                fmt::format("unknown key \"{}\"{}", member.key, did_you_mean(member.key, names)));
        else if (key && !key->beside.empty() && !json_.find(key->beside))
            complain(fmt::format("does not apply without \"{}\"", key->beside));
        else if (!key && !scope_.owner.empty())
            complain("does not apply to " + scope_.owner);
    }
    for (const Key& key : object.keys)
        if (key.required && scope_.has(key) && !json_.find(key.name) &&
            (key.beside.empty() || json_.find(key.beside)))
            diagnostics_.add(json_.place, path_,
                             fmt::format("key \"{}\" is missing{}", key.name, scope_.hint));
    const std::vector<std::string> forms = split_words(object.exactly_one);
    if (!forms.empty() && std::ranges::count_if(forms, [&](const auto& f) { return json_.find(f); }) != 1)
        diagnostics_.add(json_.place, path_, fmt::format("expected exactly one of the keys {}", join(forms)));
}

std::string ObjectReader::path(std::string_view key) const {
    return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
}

void ObjectReader::error(std::string_view key, std::string message) const {
    const Json* value = json_.find(key);
    diagnostics_.add(value ? value->place : json_.place, path(key), std::move(message));
}

const Json* ObjectReader::find(std::string_view key) const {
    return object_.find(key, scope_) ? json_.find(key) : nullptr;
}

std::string ObjectReader::text(std::string_view key, const char* fallback) const {
    const Json* value = find(key);
    if (!value || !expect(*value, Json::Kind::string, path(key), diagnostics_)) return fallback;
    const Key& row = *object_.find(key, scope_);
    if (row.holds == Holds::id && !expect_id(value->string, value->place, path(key), diagnostics_))
        return fallback;
    if (const std::string problem = text_problem(row, value->string); !problem.empty()) error(key, problem);
    return value->string;
}

bool ObjectReader::flag(std::string_view key) const {
    const Json* value = find(key);
    if (!value || !expect(*value, Json::Kind::boolean, path(key), diagnostics_)) return false;
    if (!value->boolean && object_.find(key, scope_)->holds == Holds::yes)
        error(key, "only true may be written; leave the key out");
    return value->boolean;
}

uint32_t ObjectReader::whole(std::string_view key, uint32_t fallback) const {
    const Json* value = find(key);
    if (!value) return fallback;
    return read_whole(*value, *object_.find(key, scope_), path(key), diagnostics_).value_or(fallback);
}

std::vector<uint32_t> ObjectReader::wholes(std::string_view key) const {
    const Json* value = find(key);
    if (!value || !expect(*value, Json::Kind::array, path(key), diagnostics_)) return {};
    const Key& row = *object_.find(key, scope_);
    if (value->items.size() < row.min_items || value->items.size() > row.max_items) {
        const std::string wanted = row.min_items == row.max_items
                                       ? fmt::format("{}", row.min_items)
                                       : fmt::format("{} to {}", row.min_items, row.max_items);
        error(key, fmt::format("expected {} whole numbers, got {} items", wanted, value->items.size()));
        return {};
    }
    std::vector<uint32_t> numbers;
    for (size_t i = 0; i < value->items.size(); ++i)
        if (const auto number =
                read_whole(value->items[i], row, fmt::format("{}[{}]", path(key), i), diagnostics_))
            numbers.push_back(*number);
    if (numbers.size() != value->items.size()) return {};
    return numbers;
}

std::array<uint32_t, 2> ObjectReader::pair(std::string_view key, std::array<uint32_t, 2> fallback) const {
    const std::vector<uint32_t> numbers = wholes(key);
    return numbers.empty() ? fallback : std::array{numbers[0], numbers[1]};
}

std::optional<size_t> ObjectReader::word(std::string_view key) const {
    if (!find(key)) return std::nullopt;
    return word(key, split_words(object_.find(key, scope_)->words));
}

std::optional<size_t> ObjectReader::word(std::string_view key, std::span<const std::string> words) const {
    const Json* value = find(key);
    if (!value || !expect(*value, Json::Kind::string, path(key), diagnostics_)) return std::nullopt;
    const auto found = std::ranges::find(words, value->string);
    if (found != words.end()) return static_cast<size_t>(found - words.begin());
    error(key, fmt::format("no value \"{}\" (values: {}){}", value->string, join(words),
                           did_you_mean(value->string, words)));
    return std::nullopt;
}

// One, or where the vocabulary says so a list of different ones.
std::vector<Format> ObjectReader::formats(std::string_view key) const {
    const Json* value = find(key);
    if (!value) return {};
    const Holds holds = object_.find(key, scope_)->holds;
    const bool many = holds == Holds::formats || holds == Holds::storables;
    const bool stored = holds == Holds::storable || holds == Holds::storables;
    std::vector<Item> items;
    if (many && value->kind == Json::Kind::array)
        items = list(key);
    else if (expect(*value, Json::Kind::string, path(key), diagnostics_))
        items.push_back({value->string, path(key), value->place});
    std::vector<Format> formats;
    for (const Item& item : items) {
        const std::optional<Format> format = format_named(item.text);
        if (!format)
            diagnostics_.add(item.place, item.path,
                             fmt::format("no format \"{}\" (formats: {}){}", item.text, join(format_names()),
                                         did_you_mean(item.text, format_names())));
        else if (stored && !info(*format).glsl)
            diagnostics_.add(
                item.place, item.path,
                fmt::format("{} cannot be held here: depth formats are only sampled, as images", item.text));
        else
            formats.push_back(*format);
    }
    return formats;
}

std::optional<Format> ObjectReader::format(std::string_view key) const {
    const std::vector<Format> one = formats(key);
    return one.empty() ? std::nullopt : std::optional(one.front());
}

std::vector<ObjectReader::Item> ObjectReader::list(std::string_view key) const {
    std::vector<Item> list;
    const Json* value = find(key);
    if (!value || !expect(*value, Json::Kind::array, path(key), diagnostics_)) return list;
    const Key& row = *object_.find(key, scope_);
    std::set<std::string_view> listed;
    if (value->items.size() < row.min_items) error(key, "the list is empty");
    for (size_t i = 0; i < value->items.size(); ++i) {
        const Json& item = value->items[i];
        const std::string item_path = fmt::format("{}[{}]", path(key), i);
        if (!expect(item, Json::Kind::string, item_path, diagnostics_)) continue;
        if (row.holds == Holds::ids && !expect_id(item.string, item.place, item_path, diagnostics_)) continue;
        if (!listed.insert(item.string).second)
            diagnostics_.add(item.place, item_path, fmt::format("\"{}\" is listed twice", item.string));
        else
            list.push_back({item.string, item_path, item.place});
    }
    return list;
}

std::optional<std::array<double, 2>> read_range(const Json& json, bool open, const std::string& path,
                                                Diagnostics& diagnostics) {
    std::array<double, 2> range = {-std::numeric_limits<double>::infinity(),
                                   std::numeric_limits<double>::infinity()};
    bool good = json.kind == Json::Kind::array && json.items.size() == 2;
    for (size_t end = 0; good && end < 2; ++end) {
        const Json& item = json.items[end];
        good = item.is_number() || (open && item.kind == Json::Kind::null);
        if (item.is_number()) range[end] = item.real;
    }
    if (!good)
        diagnostics.add(json.place, path,
                        fmt::format("expected the least and the greatest value{}",
                                    open ? ", null where there is none" : ""));
    else if (range[0] > range[1])
        diagnostics.add(json.place, path, "the least value exceeds the greatest");
    else
        return range;
    return std::nullopt;
}

std::string join(std::span<const std::string> words) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
    return text;
}

}  // namespace penumbra
