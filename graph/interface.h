// SPDX-License-Identifier: MIT
// What a declaration means to a shader: bindings, specialisation constants, push constants, variants, and the
// GLSL text ("node.glsl") that spells them out. One definition, used to compile the shader and to fill its
// descriptors.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "penumbra/export.h"
#include "penumbra/node_type.h"

namespace penumbra PENUMBRA_API {  // for the component glsl alone

// Binding numbers are unique within a node over both sets: set 0 holds what the plan makes (resources,
// tables), set 1 what changes with every frame (the frame block, counters, host slots). Shaders are compiled
// with every port in set 0; bind_to_sets() moves those that are wired to a host slot.
inline constexpr uint32_t frame_binding = 0;     // set 1: FrameBlock
inline constexpr uint32_t counters_binding = 1;  // set 1: u32 sums of every pass of the frame
inline constexpr uint32_t first_port_binding = 2;

// Specialisation constant ids. Constant parameters follow, then presence(), then row_outputs().
inline constexpr uint32_t group_constant = 0;       // 0, 1, 2: workgroup size
inline constexpr uint32_t per_thread_constant = 3;  // 3, 4
inline constexpr uint32_t on_cpu_constant = 5;      // whether the device is of the class cpu
inline constexpr uint32_t in_step_constant = 6;     // DeviceTable::lanes_in_step
inline constexpr uint32_t first_param_constant = 7;

// An output with a mip chain takes two bindings: the level that a dispatch writes, and NAME_finer, the level
// before it. One dispatch per level, finest first; params.mip_level says which.

// An output that may be laid out in rows takes two bindings as well: the image, and in the variant with rows
// a buffer of the same memory (PlanResource::row_bytes), of whose rows the constant NAME_ROW has the length.

// First binding of each port (parallel to NodeType::ports); an input that an output updates shares the
// output's, and the parts of a bundle follow each other.
std::vector<uint32_t> port_bindings(const NodeType& type);
// First binding of the tables; table i is at first + i.
uint32_t first_table_binding(const NodeType& type);

// Where a block that is absent lies, whose port has `binding`: in set 1, behind all that is read. Mesa 22's
// llvmpipe writes beyond an array where a branch follows from what the fifth uniform buffer or a later one
// holds, in order of sets and bindings.
uint32_t absent_block_binding(const NodeType& type, uint32_t binding);

// An input, a part of a bundle or a table that may be absent is bound all the same, to something that is
// never read: the constant HAS_NAME says so, and one module serves both.
struct Presence {
    std::string name;
    std::optional<uint32_t> port, table;  // one of them
    std::optional<uint32_t> part;         // of the port's bundle
};
std::vector<Presence> presence(const NodeType& type);

// The outputs that are laid out in rows, and the bytes of an element of one: a texel, or four that are
// narrow.
std::vector<uint32_t> row_outputs(const NodeType& type);
bool has_rows(Format format);
uint32_t row_element_bytes(Format format);
// The length of the first one's rows; the others' follow.
uint32_t first_row_constant(const NodeType& type);

// Byte offsets of the dynamic parameters in the push-constant block (constants have none), and its size.
struct PushConstants {
    std::vector<std::optional<uint32_t>> offsets;  // parallel to NodeType::params
    std::optional<uint32_t> mip_level;             // of nodes that write a mip chain: the level of a dispatch
    std::optional<uint32_t> counter_base;          // of nodes that count: the first of the pass's counters
    uint32_t size = 0;
};
PushConstants push_constants(const NodeType& type);

// A value's bits as a specialisation or push constant: enums become their index, booleans 0 or 1.
std::vector<std::byte> value_bytes(const Param& param, const ParamValue& value);
// The value that these bits are of.
ParamValue value_of(const Param& param, std::span<const std::byte> bytes);

// Whether a value has the parameter's type, component count and range.
bool fits(const Param& param, const ParamValue& value);

// What is compiled on its own: a format that the layout of what is stored names, an output that need not
// exist (a store needs memory, which what is absent has none of), a backend, a class of devices.
struct Variant {
    std::map<std::string, Format> formats;        // ports with has_format_choice()
    std::map<std::string, bool> outputs;          // optional and conditional ones, HAS_NAME in GLSL
    std::map<std::string, std::string> backends;  // by the bundle's parameter
    std::optional<bool> cpu;                      // the device's class, CLASS_CPU in GLSL: NodeType::by_class
    bool rows = false;                            // all of row_outputs() that exist are
};
bool has_format_choice(const Port& port);
const Param* backend_param(const NodeType& type, const Bundle& bundle);  // nullptr: the last backend it is
const Bundle::Backend& backend_of(const Variant& variant, const Bundle& bundle);
// Whether a port's value may be absent, and the shader is compiled for either case.
bool is_variant_output(const NodeType& type, const Port& port);
// The key of ShaderVariants: "filtered=r8,history=1"; "" if there is no choice.
std::string to_string(const Variant& variant);
// How many sets of parameters' values its conditions of outputs can tell apart.
size_t compared_values(const NodeType& type);
// Every variant that some parameters and facts ask for; of more than max_variants_made, more than that.
std::vector<Variant> all_variants(const NodeType& type);
inline constexpr size_t max_variants_made = 1000;

// The text that `#include "node.glsl"` stands for.
std::string generate_glsl(const NodeType& type, const Variant& variant);

struct HostBinding {
    uint32_t from, to;
};
// Sets the decorations of the variables that were compiled for binding `from`: they go to set 1, and there to
// `to`.
void bind_to_sets(std::vector<uint32_t>& spirv, const std::vector<HostBinding>& host_bindings);

}  // namespace PENUMBRA_API
