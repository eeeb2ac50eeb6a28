// SPDX-License-Identifier: MIT
// Reads the members of one JSON object against a closed vocabulary: every unknown key, wrong type and value
// out of range becomes a diagnostic with its place. What declarations and pipelines are read with.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "penumbra/format.h"
#include "penumbra/json_text.h"

namespace penumbra {

// Whether `name` matches [a-z][a-z0-9_]* (at most 64 characters).
bool is_id(std::string_view name);

// Why `name` cannot be an identifier in generated GLSL ("a reserved word of GLSL"), or nullptr where it can.
const char* glsl_name_problem(std::string_view name);

// Reports `json` unless it is of this kind.
bool expect(const Json& json, Json::Kind kind, const std::string& path, Diagnostics& diagnostics);

class ObjectReader {
  public:
    // Reports `json` if it is no object (every lookup then finds nothing), and its unknown keys.
    ObjectReader(const Json& json, std::string path, std::span<const std::string> keys,
                 Diagnostics& diagnostics);

    bool is_object() const { return json_.kind == Json::Kind::object; }
    const Json& json() const { return json_; }
    const std::string& path() const { return path_; }
    std::string path(std::string_view key) const;
    Diagnostics& diagnostics() const { return diagnostics_; }
    void error(const Json& at, std::string_view key, std::string message) const;

    const Json* find(std::string_view key) const { return json_.find(key); }
    const Json* require(std::string_view key) const;  // reports a missing key

    // Each returns nothing where the key is missing (not an error here) or its value is wrong (reported).
    std::optional<std::string> text(std::string_view key) const;
    std::string one_line(std::string_view key) const;  // "" where missing
    bool flag(std::string_view key) const;             // false where missing
    std::optional<uint32_t> whole(std::string_view key, uint32_t min, uint32_t max) const;
    std::optional<std::vector<uint32_t>> wholes(std::string_view key, size_t min_items, size_t max_items,
                                                uint32_t min, uint32_t max) const;
    std::optional<size_t> choice(std::string_view key, std::span<const std::string> words) const;  // index
    std::optional<Format> format(std::string_view key) const;
    std::optional<std::array<uint32_t, 2>> pair(std::string_view key, uint32_t min, uint32_t max) const;

  private:
    const Json& json_;
    std::string path_;
    Diagnostics& diagnostics_;
};

// A format's name as a value; reports anything else.
std::optional<Format> read_format(const Json& json, const std::string& path, Diagnostics& diagnostics);

// A whole number in [min, max]; reports anything else.
std::optional<uint32_t> read_whole(const Json& json, uint32_t min, uint32_t max, const std::string& path,
                                   Diagnostics& diagnostics);

// "a, b, c"
std::string join(std::span<const std::string> words);

}  // namespace penumbra
