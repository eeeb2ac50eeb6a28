// SPDX-License-Identifier: MIT
// Reads the members of one JSON object against its table in the vocabulary: every unknown key, wrong type and
// value out of range becomes a diagnostic with its place. What declarations and pipelines are read with.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "graph/vocabulary.h"
#include "penumbra/format.h"
#include "penumbra/json_text.h"

namespace penumbra {

// Whether `name` matches [a-z][a-z0-9_]* (at most 64 characters).
bool is_id(std::string_view name);

// Why `name` cannot be an identifier in generated GLSL ("a reserved word of GLSL"), or nullptr where it can.
const char* glsl_name_problem(std::string_view name);

// Reports `json` unless it is of this kind.
bool expect(const Json& json, Json::Kind kind, const std::string& path, Diagnostics& diagnostics);

// The same for a name that is no id.
bool expect_id(const std::string& name, const Place& place, const std::string& path,
               Diagnostics& diagnostics);

class ObjectReader {
  public:
    // Reports `json` if it is no object (every lookup then finds nothing), keys that the vocabulary does not
    // have or that do not apply, and keys that are missing.
    ObjectReader(const Json& json, std::string path, const Object& object, Diagnostics& diagnostics,
                 Scope scope = {});

    bool is_object() const { return json_.kind == Json::Kind::object; }
    const std::string& path() const { return path_; }
    std::string path(std::string_view key) const;
    // At the key's value, or at the object where the key is not given.
    void error(std::string_view key, std::string message) const;

    const Json* find(std::string_view key) const;  // nullptr too where the key does not apply

    // Each reads the key as the vocabulary has it. Where it is missing, the result is empty or the fallback;
    // where its value is wrong, the same after a report.
    std::string text(std::string_view key, const char* fallback = "") const;
    bool flag(std::string_view key) const;
    uint32_t whole(std::string_view key, uint32_t fallback) const;
    std::vector<uint32_t> wholes(std::string_view key) const;
    std::array<uint32_t, 2> pair(std::string_view key, std::array<uint32_t, 2> fallback) const;
    std::optional<size_t> word(std::string_view key) const;  // its index
    std::optional<size_t> word(std::string_view key, std::span<const std::string> words) const;
    std::vector<Format> formats(std::string_view key) const;
    std::optional<Format> format(std::string_view key) const;
    struct Item {
        std::string text, path;
        Place place;
    };
    std::vector<Item> list(std::string_view key) const;  // of different strings

  private:
    const Json& json_;
    std::string path_;
    const Object& object_;
    Diagnostics& diagnostics_;
    Scope scope_;
};

// [least, greatest]; `open`: null stands for infinity.
std::optional<std::array<double, 2>> read_range(const Json& json, bool open, const std::string& path,
                                                Diagnostics& diagnostics);

// "a, b, c"
std::string join(std::span<const std::string> words);

}  // namespace penumbra
