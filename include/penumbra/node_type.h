// SPDX-License-Identifier: MIT
// A node type as declared in nodes/<group>/<type>.json: ports, parameters, dispatch rule. The vocabulary is
// closed (docs/vocabulary.md). Everything else about a node (GLSL interface, barriers,
// descriptors) follows.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "penumbra/condition.h"
#include "penumbra/export.h"
#include "penumbra/format.h"

namespace penumbra PENUMBRA_API {

// Whose extent a rule is about, as declared and as it is found among the type's ports.
struct SizeOf {
    std::string name = "frame";    // "frame", a port of the same type, or empty: nothing's
    std::optional<uint32_t> port;  // its index; none: the frame, or nothing
};

// ceil(of / div) * mul per axis, at least 1x1.
struct ExtentRule {
    SizeOf of;
    std::array<uint32_t, 2> div{1, 1};
    std::array<uint32_t, 2> mul{1, 1};
};

// ceil(x / div[0]) * ceil(y / div[1]) * mul + add elements; of nothing: `add` elements.
struct CountRule {
    SizeOf of{.name = "", .port = {}};
    std::array<uint32_t, 2> div{1, 1};
    uint32_t mul = 1;
    uint32_t add = 0;
};

enum class Writes : uint8_t { all, tiles, some, kept };
enum class First : uint8_t { any, clear };

struct Port {
    std::string name;
    bool output = false;
    PortKind kind = PortKind::image;
    const Bundle* bundle = nullptr;  // of kind bundle: the domain's
    std::vector<Format> formats;  // image and texels: the first is the default; on an input: what is accepted
    bool storage = false;         // image: storage access instead of sampled
    bool linear = false;          // sampled image: linear filter instead of nearest
    bool layers = false;          // 2D array
    bool levels = false;          // mip chain
    bool in_rows = false;         // output: the shader is compiled for images whose memory is a buffer's, too
    std::string element;          // buffer: u32 uvec2 uvec4 f32 vec4 or a struct; block: the struct's name
    ExtentRule extent;            // outputs of kind image and texels
    // Outputs with layers: a texels port with a row for each; nothing: as `extent`.
    SizeOf layers_of{.name = "", .port = {}};
    CountRule count;  // outputs of kind buffer
    Writes writes = Writes::all;
    // Output: what frames before left in it spares work and changes nothing that is put out.
    bool memo = false;
    // Output: number of alike frames after which its own history improves it no further; 0: never.
    uint32_t settles = 0;
    std::string updates;  // output: the input port whose memory it takes over
    std::optional<uint32_t> updated_input,
        updater;  // the other end of `updates`, an index of the type's ports
    First first = First::any;
    bool previous = false;  // must be bound to NAME@-1
    bool indirect = false;  // holds dispatch arguments
    uint32_t row = 0;       // texels that the host brings: of how many a row is; 0: any
    bool optional = false;
    std::vector<uint32_t> with;  // indices of inputs beside which it is not optional
    Condition condition;         // "if": the port exists only where this holds
    // Output of numbers: what each channel may hold, inclusive, infinite where an end is open. Fewer than the
    // format's channels: the others may hold anything finite. A promise, which the
    // command `penumbra render --validate` checks.
    std::vector<std::array<double, 2>> ranges;
    std::string doc;
    Place place;
};

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
    SizeOf over;
    std::string indirect;  // port with the arguments
    uint32_t indirect_port = 0;
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

// Static read-only data, one copy for all views of a program; `file` is relative to the declaration's folder.
struct Table {
    std::string name;
    std::string file;
    Format format = Format::r8;
    std::array<uint32_t, 2> extent{1, 1};
    bool storage = false;  // "as": a storage image instead of a sampled one
    Condition condition;   // "if": the table exists only where this holds
};

struct NodeType {
    std::shared_ptr<const Domain> domain;  // that it was read with
    std::string name;
    std::string doc;
    std::string shader;  // file name; empty for host nodes
    bool host = false;   // recorded by a C++ callback
    std::vector<std::string> needs;
    std::vector<std::string> jittered;  // facts that hold for a plan with it whose host jitters
    std::vector<Port> ports;            // inputs, then outputs, each in the declaration's order
    std::vector<Table> tables;
    std::vector<Param> params;
    Dispatch dispatch;
    ClassOverrides cpu, gpu;
    bool by_class = false;  // the shader is compiled for each class
    std::vector<std::string> counters;
    Place place;

    const Port* port(std::string_view name) const;
    uint32_t index(const Port& port) const { return static_cast<uint32_t>(&port - ports.data()); }
    // The output with a mip chain, which the node writes level by level; nullptr: it has none.
    const Port* levelled_output() const;
    const Param* param(std::string_view name) const;
    // Writes nothing and counts: it runs where all that it reads is there anyway, and keeps nothing alive.
    bool watches() const;
};

// Reads a declaration; `basename` is the file's name without extension and must equal the key "node".
std::optional<NodeType> parse_node_type(const Json& json, const std::string& basename,
                                        std::shared_ptr<const Domain> domain, Diagnostics& diagnostics);

// Reads one value for `param` (type, enum value, range); path and place name it in errors.
std::optional<ParamValue> parse_param_value(const Param& param, const Json& json, const std::string& path,
                                            Diagnostics& diagnostics);
// The same from the text after a comparison's sign: JSON, or an enum's value as it is.
std::optional<ParamValue> parse_param_text(const Param& param, const std::string& text, const Place& place,
                                           const std::string& path, Diagnostics& diagnostics);

}  // namespace penumbra
