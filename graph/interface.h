// SPDX-License-Identifier: MIT
// What a declaration means to a shader: bindings, specialisation constants, push constants, variants, and the
// GLSL text ("node.glsl") that spells them out. One definition, used to compile the shader and to fill its
// descriptors.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "graph/node_type.h"

namespace penumbra {

// Binding numbers are unique within a node over both sets, so that wiring a port to a host slot (set 1)
// instead of an internal resource (set 0) only moves it between sets: see bind_to_sets().
inline constexpr uint32_t frame_binding = 0;     // set 1: FrameBlock
inline constexpr uint32_t counters_binding = 1;  // set 1: u32 sums of every pass of the frame
inline constexpr uint32_t first_port_binding = 2;

// Specialisation constant ids.
inline constexpr uint32_t group_constant = 0;       // 0, 1, 2: workgroup size
inline constexpr uint32_t per_thread_constant = 3;  // 3, 4
inline constexpr uint32_t counter_base_constant = 5;
inline constexpr uint32_t first_param_constant = 6;

// A scene port expands to the slots of a trace backend, in binding order: `bvh` to the texel buffers
// NAME.nodes and NAME.leaves, `ray_query` to the acceleration structure NAME.tlas; where the fact alpha
// holds, the texel buffers NAME.alpha_uv and NAME.alpha_map; the block NAME comes last. Bindings are reserved
// for the longest of these lists.
inline constexpr uint32_t scene_bindings = 5;
struct SceneTexels {
    const char* slot;
    Format format;
};
inline constexpr std::array<SceneTexels, 2> scene_tree_slots{
    {{"nodes", Format::rgba32ui}, {"leaves", Format::rgba32ui}}};
inline constexpr std::array<SceneTexels, 2> scene_alpha_slots{
    {{"alpha_uv", Format::rgba32ui}, {"alpha_map", Format::r32ui}}};

// A node type with a scene port may leave the backend to the pipeline: a constant enum parameter of this
// name, whose values are `bvh`, `ray_query` and `auto` (ray_query where the device has it and is not a CPU).
// One shader is compiled per backend; in it the parameter is a preprocessor constant. Other types trace with
// `bvh`.
inline constexpr const char* backend_param = "backend";
const Param* backend_choice(const NodeType& type);  // nullptr: the type has no such choice

// An output with a mip chain takes two bindings: the level that a dispatch writes, and NAME_finer, the level
// before it. One dispatch per level, finest first; params.mip_level says which.

// First binding of each port (parallel to NodeType::ports); an input that an output updates shares the
// output's.
std::vector<uint32_t> port_bindings(const NodeType& type);
// First binding of the tables; table i is at first + i, set 1.
uint32_t first_table_binding(const NodeType& type);

// Byte offsets of the dynamic parameters in the push-constant block (constants have none), and its size.
struct PushConstants {
    std::vector<std::optional<uint32_t>> offsets;  // parallel to NodeType::params
    std::optional<uint32_t> mip_level;             // of nodes that write a mip chain: the level of a dispatch
    uint32_t size = 0;
};
PushConstants push_constants(const NodeType& type);

// A value's bits as a specialisation or push constant: enums become their index, booleans 0 or 1.
std::vector<std::byte> value_bytes(const Param& param, const ParamValue& value);

// Whether a value has the parameter's type, component count and range.
bool fits(const Param& param, const ParamValue& value);

// What a compiled variant depends on: the formats of storage images that have a choice, which optional ports
// exist, the trace backend, and whether the traced scene has alpha-tested geometry (the fact alpha; in the
// shader SCENE_ALPHA is defined then, for a port named scene). Without it nothing of alpha is compiled.
struct Variant {
    std::map<std::string, Format> formats;  // storage image ports with more than one format
    std::map<std::string, bool> present;    // optional and conditional ports, conditional tables
    std::string backend;                    // "bvh" or "ray_query"; empty: the type has no choice
    bool alpha = false;                     // always false where the type has no scene port
};
bool uses_ray_query(const Variant& variant);
bool has_format_choice(const Port& port);  // a storage image that the pipeline may give another format
bool exists(const Variant& variant, const std::string& port_or_table);
bool traces_scene(const NodeType& type);  // has a scene port
std::string to_string(
    const Variant& variant);  // the key of ShaderVariants: "filtered=r8,history=1"; "" if no choice
std::vector<Variant> all_variants(const NodeType& type);

// The text that `#include "node.glsl"` stands for.
std::string generate_glsl(const NodeType& type, const Variant& variant);

// Sets the DescriptorSet decoration of each variable: bindings listed in `host` go to set 1, other ports to
// set 0.
void bind_to_sets(std::vector<uint32_t>& spirv, const std::vector<uint32_t>& host_bindings);

}  // namespace penumbra
