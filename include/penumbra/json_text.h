// SPDX-License-Identifier: MIT
// JSON values that remember where they stand in the text, so that every later error can point there.
// nlohmann-json parses; a pass of our own over the same text gives the places. Rejects duplicate keys, NaN
// and comments.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "penumbra/diagnostic.h"
#include "penumbra/export.h"

namespace penumbra PENUMBRA_API {

struct JsonMember;

struct Json {
    enum class Kind { null, boolean, integer, real, string, array, object };

    Kind kind = Kind::null;
    Place place;  // of the value's first character
    bool boolean = false;
    int64_t integer = 0;
    double real = 0;  // also set for integers
    std::string string;
    std::vector<Json> items;
    std::vector<JsonMember> members;  // in the text's order

    bool is_number() const { return kind == Kind::integer || kind == Kind::real; }
    const Json* find(std::string_view key) const;
};

struct JsonMember {
    std::string key;
    Place key_place;
    Json value;
};

// "object", "string", ...: the word for error messages.
const char* kind_name(Json::Kind kind);

// How many values, keys and punctuation marks a text may have: a pipeline of 10 000 nodes has 300 000. Each
// takes up to some hundred bytes of memory where the text takes one or two.
inline constexpr size_t most_json_tokens = 2'000'000;

// Parses `text`; `file` is the name that places carry.
std::optional<Json> parse_json(std::string_view text, const std::string& file, Diagnostics& diagnostics,
                               size_t most_tokens = most_json_tokens);

// Reads and parses a file; a missing, unreadable or endless file is a diagnostic too.
std::optional<Json> read_json(const std::filesystem::path& path, Diagnostics& diagnostics,
                              size_t most_tokens = most_json_tokens);

// RFC 7396: null removes, objects merge, everything else replaces. Values keep the place they came from.
void merge_patch(Json& target, const Json& patch);

// Sets "a.b.c" in an object, creating objects on the way. Arrays are replaced whole.
// `value_text` is JSON if it parses as JSON, else a string. `place.file` names the source ("--set
// a.b.c=...").
void set_path(Json& target, std::string_view path, std::string_view value_text, const Place& place);

}  // namespace penumbra
