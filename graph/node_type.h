// SPDX-License-Identifier: MIT
// A node type as declared in nodes/<type>.json: ports, parameters, dispatch rule. The vocabulary is closed
// (docs: formats of node declarations). Everything else about a node (GLSL interface, barriers, descriptors)
// follows.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "graph/format.h"
#include "graph/json_text.h"

namespace penumbra {

// One literal of a condition: FACT or PARAM=VALUE, or ! and one of them. Literals of a Condition are joined
// by "and"; empty = always.
struct Literal {
    std::string name;
    bool negated = false;
    std::optional<std::string> value;  // set: compares a constant parameter

    friend bool operator==(const Literal&, const Literal&) = default;
};
using Condition = std::vector<Literal>;

// The facts a host may promise for a plan's lifetime; all default to true.
inline constexpr std::array<const char*, 9> fact_names = {
    "sun_up", "sun_disc", "casters", "alpha", "many_cascades", "moves", "sun_moves", "motion_3d", "hdr"};
using Facts = std::map<std::string, bool>;  // name -> value; a name that is absent is true

std::string to_string(const Condition& condition);

// ceil(of / div) * mul per axis, at least 1x1. `of` is "frame" or a port of the same node.
struct ExtentRule {
    std::string of = "frame";
    std::array<uint32_t, 2> div{1, 1};
    std::array<uint32_t, 2> mul{1, 1};
};

// ceil(x / div[0]) * ceil(y / div[1]) * mul + add elements; of empty: `add` elements.
struct CountRule {
    std::string of;
    std::array<uint32_t, 2> div{1, 1};
    uint32_t mul = 1;
    uint32_t add = 0;
};

enum class PortKind : uint8_t { image, texels, buffer, block, scene };
const char* kind_name(PortKind kind);  // as declarations spell it
enum class Writes : uint8_t { all, tiles, some, kept };
enum class First : uint8_t { any, clear };

struct Port {
    std::string name;
    bool output = false;
    PortKind kind = PortKind::image;
    std::vector<Format> formats;  // image and texels: the first is the default; on an input: what is accepted
    bool storage = false;         // image: storage access instead of sampled
    bool linear = false;          // sampled image: linear filter instead of nearest
    bool layers = false;          // 2D array
    bool levels = false;          // mip chain
    std::string element;          // buffer: u32 uvec2 uvec4 f32 vec4 or a struct; block: the struct's name
    ExtentRule extent;            // outputs of kind image and texels
    CountRule count;              // outputs of kind buffer
    Writes writes = Writes::all;
    // Output: what frames before left in it spares work and changes nothing that is put out.
    bool memo = false;
    std::string updates;  // output: the input port whose memory it takes over
    First first = First::any;
    bool previous = false;  // must be bound to NAME@-1
    bool indirect = false;  // holds dispatch arguments
    bool optional = false;
    Condition condition;  // "if": the port exists only where this holds
    // Output of numbers: what each channel may hold, inclusive, infinite where an end is open. Fewer than the
    // format's channels: the others may hold anything finite. A promise, which `validate` checks
    // (validate.h).
    std::vector<std::array<double, 2>> ranges;
    std::string doc;
    Place place;
};

using ParamValue = std::variant<bool, int32_t, uint32_t, float, std::vector<float>, std::string>;
enum class ParamType : uint8_t { boolean, integer, uint, real, vec2, vec3, vec4, enumeration };

struct Param {
    std::string name;
    ParamType type = ParamType::real;
    ParamValue default_value;                    // enum: the value's name
    std::vector<std::string> values;             // enum
    std::optional<std::array<double, 2>> range;  // inclusive
    std::string unit;
    std::string doc;
    bool constant = false;  // specialisation constant; otherwise a push constant
    Place place;
};

// Bytes and std430 alignment of a parameter in the push-constant block; enums are int, bools uint.
struct ParamLayout {
    uint32_t size, alignment;
};
ParamLayout layout_of(ParamType type);

struct Dispatch {
    enum class Kind : uint8_t { over, indirect, groups, host };
    Kind kind = Kind::over;
    std::string over = "frame";               // "frame" or a port
    std::string indirect;                     // port with the arguments
    uint32_t offset = 0;                      // bytes
    std::array<uint32_t, 3> groups{1, 1, 1};  // kind groups
    std::array<uint32_t, 3> group{8, 8, 1};   // workgroup size
    std::array<uint32_t, 2> per_thread{1, 1};
};

// Overrides for one device class; names are parameters' or group / per_thread.
struct ClassOverrides {
    std::map<std::string, ParamValue> params;
    std::optional<std::array<uint32_t, 3>> group;
    std::optional<std::array<uint32_t, 2>> per_thread;
};

// Static read-only data, uploaded once per device; `file` is relative to the declaration's folder.
struct Table {
    std::string name;
    std::string file;
    Format format = Format::r8;
    std::array<uint32_t, 2> extent{1, 1};
    Condition condition;  // "if": the table exists only where this holds
};

struct NodeType {
    std::string name;
    std::string doc;
    std::string shader;  // file name; empty for host nodes
    bool host = false;   // recorded by a C++ callback
    std::vector<std::string> needs;
    std::vector<Port> ports;  // inputs, then outputs, each in the declaration's order
    std::vector<Table> tables;
    std::vector<Param> params;
    Dispatch dispatch;
    ClassOverrides cpu, gpu;
    std::vector<std::string> counters;
    Place place;

    const Port* port(std::string_view name) const;
    // The output with a mip chain, which the node writes level by level; nullptr: it has none.
    const Port* levelled_output() const;
    const Param* param(std::string_view name) const;
    // Writes nothing and counts: it runs where all that it reads is there anyway, and keeps nothing alive.
    bool watches() const;
};

// Reads a declaration; `basename` is the file's name without extension and must equal the key "node".
std::optional<NodeType> parse_node_type(const Json& json, const std::string& basename,
                                        Diagnostics& diagnostics);

// Reads one value for `param` (type, enum value, range); path and place name it in errors.
std::optional<ParamValue> parse_param_value(const Param& param, const Json& json, const std::string& path,
                                            Diagnostics& diagnostics);

// Parses "a & !b & mode=x". `params` lists what PARAM=VALUE may name (empty: facts only).
std::optional<Condition> parse_condition(const Json& json, std::span<const Param> params,
                                         const std::string& path, Diagnostics& diagnostics);

// Whether the condition holds under these facts and parameter values (enum by name, bool "true"/"false",
// numbers as text).
bool holds(const Condition& condition, const Facts& facts, const std::map<std::string, ParamValue>& params);

}  // namespace penumbra
