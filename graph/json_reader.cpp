// SPDX-License-Identifier: MIT
// Reading objects of a closed vocabulary, and which names generated GLSL can carry.
#include "graph/json_reader.h"

#include <fmt/format.h>

#include <algorithm>

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

ObjectReader::ObjectReader(const Json& json, std::string path, std::span<const std::string> keys,
                           Diagnostics& diagnostics)
    : json_(json), path_(std::move(path)), diagnostics_(diagnostics) {
    expect(json_, Json::Kind::object, path_, diagnostics_);
    for (const JsonMember& member : json_.members) {
        if (std::ranges::find(keys, member.key) != keys.end()) continue;
        diagnostics_.add(member.key_place, path_,
                         fmt::format("unknown key \"{}\"{}", member.key, did_you_mean(member.key, keys)));
    }
}

std::string ObjectReader::path(std::string_view key) const {
    return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
}

void ObjectReader::error(const Json& at, std::string_view key, std::string message) const {
    diagnostics_.add(at.place, path(key), std::move(message));
}

const Json* ObjectReader::require(std::string_view key) const {
    const Json* value = find(key);
    if (!value && is_object())
        diagnostics_.add(json_.place, path_, fmt::format("key \"{}\" is missing", key));
    return value;
}

std::optional<std::string> ObjectReader::text(std::string_view key) const {
    const Json* value = find(key);
    if (!value || !expect(*value, Json::Kind::string, path(key), diagnostics_)) return std::nullopt;
    return value->string;
}

std::string ObjectReader::one_line(std::string_view key) const {
    const std::string line = text(key).value_or("");
    if (line.find_first_of("\r\n") != std::string::npos) error(*find(key), key, "must be one line");
    return line;
}

bool ObjectReader::flag(std::string_view key) const {
    const Json* value = find(key);
    return value && expect(*value, Json::Kind::boolean, path(key), diagnostics_) && value->boolean;
}

std::optional<uint32_t> ObjectReader::whole(std::string_view key, uint32_t min, uint32_t max) const {
    const Json* value = find(key);
    return value ? read_whole(*value, min, max, path(key), diagnostics_) : std::nullopt;
}

std::optional<std::vector<uint32_t>> ObjectReader::wholes(std::string_view key, size_t min_items,
                                                          size_t max_items, uint32_t min,
                                                          uint32_t max) const {
    const Json* value = find(key);
    if (!value || !expect(*value, Json::Kind::array, path(key), diagnostics_)) return std::nullopt;
    if (value->items.size() < min_items || value->items.size() > max_items) {
        const std::string wanted = min_items == max_items ? fmt::format("{}", min_items)
                                                          : fmt::format("{} to {}", min_items, max_items);
        error(*value, key,
              fmt::format("expected {} whole numbers, got {} items", wanted, value->items.size()));
        return std::nullopt;
    }
    std::vector<uint32_t> numbers;
    for (size_t i = 0; i < value->items.size(); ++i) {
        const std::string item_path = fmt::format("{}[{}]", path(key), i);
        if (const auto number = read_whole(value->items[i], min, max, item_path, diagnostics_))
            numbers.push_back(*number);
    }
    if (numbers.size() != value->items.size()) return std::nullopt;
    return numbers;
}

std::optional<std::array<uint32_t, 2>> ObjectReader::pair(std::string_view key, uint32_t min,
                                                          uint32_t max) const {
    const auto numbers = wholes(key, 2, 2, min, max);
    if (!numbers) return std::nullopt;
    return std::array<uint32_t, 2>{(*numbers)[0], (*numbers)[1]};
}

std::optional<size_t> ObjectReader::choice(std::string_view key, std::span<const std::string> words) const {
    const std::optional<std::string> word = text(key);
    if (!word) return std::nullopt;
    const auto found = std::ranges::find(words, *word);
    if (found != words.end()) return static_cast<size_t>(found - words.begin());
    error(*find(key), key,
          fmt::format("no value \"{}\" (values: {}){}", *word, join(words), did_you_mean(*word, words)));
    return std::nullopt;
}

std::optional<Format> ObjectReader::format(std::string_view key) const {
    const Json* value = find(key);
    return value ? read_format(*value, path(key), diagnostics_) : std::nullopt;
}

std::optional<Format> read_format(const Json& json, const std::string& path, Diagnostics& diagnostics) {
    if (!expect(json, Json::Kind::string, path, diagnostics)) return std::nullopt;
    const std::optional<Format> format = format_named(json.string);
    if (!format)
        diagnostics.add(json.place, path,
                        fmt::format("no format \"{}\" (formats: {}){}", json.string, join(format_names()),
                                    did_you_mean(json.string, format_names())));
    return format;
}

std::optional<uint32_t> read_whole(const Json& json, uint32_t min, uint32_t max, const std::string& path,
                                   Diagnostics& diagnostics) {
    if (!expect(json, Json::Kind::integer, path, diagnostics)) return std::nullopt;
    if (json.integer < min || json.integer > max) {
        diagnostics.add(json.place, path, fmt::format("{} is outside {} .. {}", json.integer, min, max));
        return std::nullopt;
    }
    return static_cast<uint32_t>(json.integer);
}

std::string join(std::span<const std::string> words) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
    return text;
}

}  // namespace penumbra
