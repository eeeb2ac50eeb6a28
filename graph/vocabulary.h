// SPDX-License-Identifier: MIT
// The keys of node declarations and of pipelines, each once: what its value is, where it applies, what it
// means. The readers, both JSON Schemas and docs/vocabulary.md follow from these tables. What a domain adds
// (kinds of ports, needs, facts) comes from the domain.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "penumbra/domain.h"

namespace penumbra {

// Vulkan guarantees 128; every device of the last decade has 1024.
inline constexpr uint32_t max_group_threads = 1024;
inline constexpr size_t max_channels = 4;

enum class Holds : uint8_t {
    text,
    file,     // text that is not empty
    shader,   // a file name that ends in .comp
    line,     // text without a line break
    id,       // [a-z][a-z0-9_]*
    ids,      // a list of different ones
    flag,     // true or false
    yes,      // true; otherwise the key is left out
    version,  // 1
    whole,    // a whole number within the limits
    wholes,   // a list of those
    range,    // [least, greatest]
    ranges,   // [least, greatest], null where there is none; or a list with one for each channel
    word,     // one of `words`
    kind,     // one of kind_words()
    needs,    // a list of different need_words()
    truths,   // a list of different facts
    node_type,
    format,
    storable,   // a format that is no depth format
    formats,    // a format, or a list of different ones
    storables,  // the same without depth formats
    structure,  // a struct's name, or one of `words`
    condition,  // condition.h
    value,      // of the parameter's type
    values,     // parameter: its value
    facts,      // fact: whether it holds
    wires,      // port: resource
    object,     // with keys of its own
    objects     // id: such an object
};

// Where a key applies: bits of PortKind, or of ParamType.
using Kinds = uint16_t;
constexpr Kinds bit(auto kind) {
    return static_cast<Kinds>(1u << static_cast<unsigned>(kind));
}
inline constexpr Kinds every_kind = 0xffff;
inline constexpr Kinds unknown_kind = 0x8000;  // in every_kind alone

struct Object;

// What can be said of a key beside what it holds.
struct Rules {
    bool required = false;
    std::string_view words = {};      // with blanks between; of what is no Holds::word: may stand instead
    const Object* object = nullptr;   // of what is no Holds::object(s): may stand instead
    int64_t least = 0, greatest = 0;  // of whole numbers
    int64_t multiple = 1;             // of which they are
    size_t min_items = 0, max_items = 0;
    Kinds in = every_kind, out = every_kind;  // of inputs and outputs; what is no port counts as input
    bool updating = true;                     // applies to outputs that update an input, too
    std::string_view beside = {};  // applies, and may be required, only where this other key stands
};

struct Key : Rules {
    std::string_view name;
    Holds holds;
    std::string_view doc;

    constexpr Key(std::string_view key, Holds value, std::string_view meaning, const Rules& rules = {})
        : Rules(rules), name(key), holds(value), doc(meaning) {}
};

// Which rows of a table apply to one object, and what is said where the object breaks them.
struct Scope {
    Kinds kinds = every_kind;
    bool output = false;
    bool updating = false;
    std::string owner = {};               // what a key does not apply to; empty: that goes without a word
    std::vector<std::string> names = {};  // keys beside the table's
    std::string hint = {};                // to a key that is missing

    bool has(const Key& key) const {
        return (kinds & (output ? key.out : key.in)) != 0 && (!updating || key.updating);
    }
};

// Several rows may have one name: the value then depends on where the key stands.
struct Object {
    std::string_view name;
    std::string_view doc;
    std::span<const Key> keys;
    std::string_view exactly_one = {};  // of these keys
    std::string_view selector = {};     // the key that says of which kind the object is

    const Key* find(std::string_view key, const Scope& scope) const;  // the row that applies
    const Key& at(std::string_view key) const;                        // the first of this name
    bool knows(std::string_view key) const;
    std::vector<std::string> names() const;
};

namespace vocabulary {
extern const Object declaration, port, extent, count, table, param, dispatch, classes, device_class;
extern const Object pipeline, input, node, instance, resource;
// In the documentation's order.
std::span<const Object* const> objects();
}  // namespace vocabulary

std::vector<std::string> split_words(std::string_view words);
std::vector<std::string> kind_words(const Domain& domain);  // in the order of PortKind; bundles last
std::vector<std::string> need_words(const Domain& domain);
std::vector<std::string> param_type_words();  // in the order of ParamType

}  // namespace penumbra
