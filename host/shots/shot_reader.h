// SPDX-License-Identifier: MIT
// How the parts of a shot's file are read: every value checked, every error with its place.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <string>
#include <vector>

#include "host/shots/shot.h"
#include "penumbra/json_text.h"

namespace penumbra {

inline constexpr double huge = 1e9;  // metres; positions beyond the solar system's inner part are mistakes

class Reader {
  public:
    explicit Reader(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

    // An object with no other keys than `known`.
    bool object(const Json& json, const std::string& path, const std::vector<const char*>& known) {
        if (json.kind != Json::Kind::object) {
            error(json.place, path, fmt::format("expected an object, not {}", kind_name(json.kind)));
            return false;
        }
        const std::vector<std::string> names(known.begin(), known.end());
        for (const JsonMember& member : json.members) {
            if (std::find(names.begin(), names.end(), member.key) != names.end()) continue;
            error(member.key_place, join(path, member.key), "unknown key" + did_you_mean(member.key, names));
        }
        return true;
    }

    // The member, or an error at the object where it is required.
    const Json* required(const Json& json, const std::string& path, const char* key) {
        const Json* value = json.find(key);
        if (!value) error(json.place, path, fmt::format("\"{}\" is missing", key));
        return value;
    }

    // The one of `list` that has this name, or an error that lists their names.
    template <class Named>
    const Named* named(const Json& json, const std::string& path, const char* what,
                       const std::vector<Named>& list) {
        if (json.kind != Json::Kind::string) {
            error(json.place, path, fmt::format("expected a string, not {}", kind_name(json.kind)));
            return nullptr;
        }
        std::vector<std::string> names;
        for (const Named& one : list) {
            if (json.string == one.name) return &one;
            names.emplace_back(one.name);
        }
        error(json.place, path,
              fmt::format("no {} is named \"{}\"{}; there are {}", what, json.string,
                          did_you_mean(json.string, names), fmt::join(names, ", ")));
        return nullptr;
    }

    void number(const Json& json, const std::string& path, double low, double high, double& out) {
        if (!json.is_number()) {
            error(json.place, path, fmt::format("expected a number, not {}", kind_name(json.kind)));
        } else if (!(json.real >= low && json.real <= high)) {
            error(json.place, path, fmt::format("{} is not in {} .. {}", json.real, low, high));
        } else {
            out = json.real;
        }
    }

    void integer(const Json& json, const std::string& path, int64_t low, int64_t high, uint32_t& out) {
        if (json.kind != Json::Kind::integer) {
            error(json.place, path, fmt::format("expected an integer, not {}", kind_name(json.kind)));
        } else if (json.integer < low || json.integer > high) {
            error(json.place, path, fmt::format("{} is not in {} .. {}", json.integer, low, high));
        } else {
            out = static_cast<uint32_t>(json.integer);
        }
    }

    void vector(const Json& json, const std::string& path, glm::dvec3& out) {
        if (json.kind != Json::Kind::array || json.items.size() != 3) {
            error(json.place, path, "expected three numbers");
            return;
        }
        for (int i = 0; i < 3; ++i) {
            number(json.items[static_cast<size_t>(i)], fmt::format("{}[{}]", path, i), -huge, huge, out[i]);
        }
    }

    // "keys": a list of objects with rising "frame"; `read` fills the rest of a key.
    template <class Key>
    void keys(const Json& parent, const std::string& parent_path, std::initializer_list<const char*> known,
              std::vector<Key>& out, auto read) {
        const Json* list = required(parent, parent_path, "keys");
        if (!list) return;
        const std::string path = join(parent_path, "keys");
        if (list->kind != Json::Kind::array || list->items.empty()) {
            error(list->place, path, "expected a list of at least one key");
            return;
        }
        for (size_t i = 0; i < list->items.size(); ++i) {
            const Json& item = list->items[i];
            const std::string item_path = fmt::format("{}[{}]", path, i);
            if (!object(item, item_path, known)) continue;
            Key key;
            if (const Json* frame = required(item, item_path, "frame")) {
                number(*frame, join(item_path, "frame"), 0, 1e6, key.frame);
                if (!out.empty() && !(key.frame > out.back().frame)) {
                    error(frame->place, join(item_path, "frame"), "frames of keys must rise");
                }
            }
            read(item, item_path, key);
            out.push_back(key);
        }
    }

    void error(const Place& place, const std::string& path, const std::string& message) {
        diagnostics_.add(place, path, message);
    }

    size_t errors() const { return diagnostics_.size(); }

    static std::string join(const std::string& path, std::string_view key) {
        return path.empty() ? std::string(key) : fmt::format("{}.{}", path, key);
    }

  private:
    Diagnostics& diagnostics_;
};

// "scene", where that is an object.
void read_analytic(Reader& reader, const Json& scene, Shot& shot);
// "lights", where the shot has any.
void read_lights(Reader& reader, const Json& root, Shot& shot);

}  // namespace penumbra
