// SPDX-License-Identifier: MIT
// Ports are named once, in the declaration; their GLSL follows from kind, format and direction.
#include "graph/interface.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "graph/align_up.h"
#include "graph/stores.h"
#include "penumbra/frame_block.h"

namespace penumbra {
namespace {

// An output that updates inherits everything but its name from the input.
const Port& described_by(const NodeType& type, const Port& port) {
    return port.updated_input ? type.ports[*port.updated_input] : port;
}

const char* element_glsl(const std::string& element) {
    if (element == "u32") return "uint";
    if (element == "f32") return "float";
    return element.c_str();
}

// Texel buffers are written as plain storage buffers: one element per texel, or packed words for narrow
// formats.
const char* texel_element_glsl(Format format) {
    switch (format) {
        case Format::r32f:
            return "float";
        case Format::rg32f:
            return "vec2";
        case Format::rgba32f:
            return "vec4";
        case Format::rg32ui:
            return "uvec2";
        case Format::rgba32ui:
            return "uvec4";
        default:
            return "uint";
    }
}

std::string declare_image(bool storage, bool layers, const std::string& name, Format format,
                          const char* access, uint32_t b) {
    const char* dim = layers ? "2DArray" : "2D";
    if (!storage)
        return fmt::format("layout(set = 0, binding = {}) uniform {}sampler{} {};\n", b, glsl_prefix(format),
                           dim, name);
    return fmt::format("layout(set = 0, binding = {}, {}) uniform {}{}image{} {};\n", b, info(format).glsl,
                       access, glsl_prefix(format), dim, name);
}

// The level that is written, and the finer one that it is made from (its own in level 0, where nobody may
// read it).
std::string declare_chain(const Port& port, const std::string& name, Format format, uint32_t b) {
    return declare_image(true, port.layers, name, format, "writeonly ", b) +
           declare_image(true, port.layers, name + "_finer", format, "readonly ", b + 1);
}

uint32_t binding_count(const Port& port) {
    if (port.bundle) return static_cast<uint32_t>(port.bundle->parts.size());
    return (port.output && port.levels) || port.in_rows ? 2 : 1;
}

std::string declare_block(const std::string& name, const std::string& element, uint32_t b) {
    return fmt::format("layout(set = 0, binding = {}, std140) uniform {}_block {{ {} {}; }};\n", b, name,
                       element, name);
}

std::string declare_buffer(const std::string& name, const std::string& element, const char* access,
                           uint32_t b) {
    return fmt::format("layout(set = 0, binding = {}, std430) restrict {}buffer {}_buffer {{ {} {}[]; }};\n",
                       b, access, name, element_glsl(element), name);
}

std::string declare_bundle(const Port& port, const Variant& variant, uint32_t b) {
    std::string text;
    for (const Bundle::Part& part : port.bundle->parts) {
        const uint32_t binding = b++;
        if (!part.backend.empty() && part.backend != backend_of(variant, *port.bundle).name) continue;
        const std::string name = part.name.empty() ? port.name : port.name + "_" + part.name;
        if (part.kind == PortKind::texels && part.on == Bundle::Texels::loaded)
            text += fmt::format("layout(set = 0, binding = {}, {}) readonly uniform {}imageBuffer {};\n",
                                binding, info(part.format).glsl, glsl_prefix(part.format), name);
        else if (part.kind == PortKind::texels)
            text += fmt::format("layout(set = 0, binding = {}) uniform {}samplerBuffer {};\n", binding,
                                glsl_prefix(part.format), name);
        else if (part.kind == PortKind::buffer)
            text += declare_buffer(name, part.element, "readonly ", binding);
        else if (part.kind == PortKind::structure)
            text += fmt::format("layout(set = 0, binding = {}) uniform accelerationStructureEXT {};\n",
                                binding, name);
        else
            text += declare_block(name, part.element, binding);
    }
    return text;
}

Format format_of(const Port& port, const Variant& variant) {
    const auto chosen = variant.formats.find(port.name);
    if (chosen != variant.formats.end()) return chosen->second;
    return port.formats.empty() ? Format::r8 : port.formats.front();
}

std::string declare_port(const NodeType& type, const Port& port, const Variant& variant, uint32_t b) {
    const Port& what = described_by(type, port);
    const char* access = !port.output ? "readonly " : port.updates.empty() ? "writeonly " : "";
    const Format format = format_of(what, variant);
    switch (what.kind) {
        case PortKind::image: {
            if (port.output && what.levels) return declare_chain(what, port.name, format, b);
            return declare_image(what.storage, what.layers, port.name, format, access, b);
        }
        case PortKind::texels:
            if (!port.output)
                return fmt::format("layout(set = 0, binding = {}) uniform {}samplerBuffer {};\n", b,
                                   glsl_prefix(format), port.name);
            return fmt::format(
                "layout(set = 0, binding = {}, std430) restrict buffer {}_buffer {{ {} {}[]; }};\n", b,
                port.name, texel_element_glsl(format), port.name);
        case PortKind::buffer:
            return declare_buffer(port.name, what.element, port.output ? "" : "readonly ", b);
        case PortKind::block:
            return declare_block(port.name, what.element, b);
        case PortKind::bundle:
            return declare_bundle(port, variant, b);
        case PortKind::structure:
            break;  // a part of bundles only
    }
    return {};
}

const char* type_glsl(ParamType type) {
    switch (type) {
        case ParamType::boolean:
            return "uint";
        case ParamType::integer:
            return "int";
        case ParamType::uint:
            return "uint";
        case ParamType::real:
            return "float";
        case ParamType::vec2:
            return "vec2";
        case ParamType::vec3:
            return "vec3";
        case ParamType::vec4:
            return "vec4";
        case ParamType::enumeration:
            return "int";
    }
    return "";
}

std::string declare_constant(const Param& param, uint32_t id) {
    const std::string name = upper(param.name);
    switch (param.type) {
        case ParamType::boolean:
            return fmt::format("layout(constant_id = {}) const bool {} = {};\n", id, name,
                               std::get<bool>(param.default_value));
        case ParamType::uint:
            return fmt::format("layout(constant_id = {}) const uint {} = {}u;\n", id, name,
                               std::get<uint32_t>(param.default_value));
        case ParamType::real:
            return fmt::format("layout(constant_id = {}) const float {} = {:#};\n", id, name,
                               std::get<float>(param.default_value));
        case ParamType::enumeration:
            return fmt::format("layout(constant_id = {}) const int {} = 0;\n", id, name);
        default:
            return fmt::format("layout(constant_id = {}) const int {} = {};\n", id, name,
                               std::get<int32_t>(param.default_value));
    }
}

size_t index_of(const std::vector<std::string>& names, const std::string& name) {
    return static_cast<size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

// The bundle whose backend a parameter chooses.
const Bundle* bundle_of(const NodeType& type, const Param& param) {
    for (const Port& port : type.ports)
        if (port.bundle && port.bundle->param == param.name) return port.bundle;
    return nullptr;
}

std::string declare_params(const NodeType& type, const Variant& variant) {
    std::string constants, dynamic;
    uint32_t id = first_param_constant;
    for (const Param& param : type.params) {
        for (size_t i = 0; i < param.values.size(); ++i)
            constants += fmt::format("#define {}_{} {}\n", upper(param.name), upper(param.values[i]), i);
        if (const Bundle* bundle = bundle_of(type, param))
            constants += fmt::format("#define {} {}\n", upper(param.name),
                                     index_of(param.values, backend_of(variant, *bundle).name)),
                ++id;
        else if (param.constant)
            constants += declare_constant(param, id++);
        else
            dynamic += fmt::format("    {} {};\n", type_glsl(param.type), param.name);
    }
    for (const Presence& p : presence(type))
        constants += fmt::format("layout(constant_id = {}) const bool HAS_{} = true;\n", id++, upper(p.name));
    if (type.levelled_output()) dynamic += "    uint mip_level;\n";
    if (!type.counters.empty()) dynamic += "    uint counter_base;\n";
    if (!dynamic.empty())
        constants += "layout(push_constant, std430) uniform Params {\n" + dynamic + "} params;\n";
    return constants;
}

// One atomic per subgroup: active lanes add first.
std::string declare_counters(const NodeType& type) {
    if (type.counters.empty()) return {};
    std::string text =
        fmt::format("layout(set = 1, binding = {}, std430) buffer counters_buffer {{ uint counters[]; }};\n",
                    counters_binding);
    for (size_t i = 0; i < type.counters.size(); ++i)
        text += fmt::format(
            "void count_{}(uint n) {{\n    uint sum = subgroupAdd(n);\n"
            "    if (subgroupElect() && sum != 0u) atomicAdd(counters[params.counter_base + {}u], "
            "sum);\n}}\n",
            type.counters[i], i);
    return text;
}

void append(std::vector<std::byte>& out, const void* data, size_t bytes) {
    const auto* begin = static_cast<const std::byte*>(data);
    out.insert(out.end(), begin, begin + bytes);
}

}  // namespace

std::vector<uint32_t> port_bindings(const NodeType& type) {
    std::vector<uint32_t> bindings(type.ports.size());
    uint32_t next = first_port_binding;
    for (size_t i = 0; i < type.ports.size(); ++i) {
        if (type.ports[i].updater) continue;
        bindings[i] = next;
        next += binding_count(type.ports[i]);
    }
    for (size_t i = 0; i < type.ports.size(); ++i)
        if (type.ports[i].updater) bindings[i] = bindings[*type.ports[i].updater];
    return bindings;
}

uint32_t first_table_binding(const NodeType& type) {
    uint32_t next = first_port_binding;
    for (const Port& port : type.ports)
        if (!port.updater) next += binding_count(port);
    return next;
}

uint32_t absent_block_binding(const NodeType& type, uint32_t binding) {
    return first_table_binding(type) + static_cast<uint32_t>(type.tables.size()) + binding;
}

std::vector<Presence> presence(const NodeType& type) {
    std::vector<Presence> list;
    for (uint32_t i = 0; i < type.ports.size(); ++i) {
        const Port& port = type.ports[i];
        if (port.output || port.updater) continue;
        if (port.optional || !port.condition.always()) list.push_back({port.name, i, {}, {}});
        for (uint32_t p = 0; port.bundle && p < port.bundle->parts.size(); ++p)
            if (!port.bundle->parts[p].always())
                list.push_back({port.name + "_" + port.bundle->parts[p].name, i, {}, p});
    }
    for (uint32_t t = 0; t < type.tables.size(); ++t)
        if (!type.tables[t].condition.always()) list.push_back({type.tables[t].name, {}, t, {}});
    return list;
}

std::vector<uint32_t> row_outputs(const NodeType& type) {
    std::vector<uint32_t> list;
    for (uint32_t i = 0; i < type.ports.size(); ++i)
        if (type.ports[i].in_rows) list.push_back(i);
    return list;
}

uint32_t first_row_constant(const NodeType& type) {
    const auto constants = std::ranges::count_if(type.params, &Param::constant);
    return first_param_constant + static_cast<uint32_t>(constants + presence(type).size());
}

PushConstants push_constants(const NodeType& type) {
    PushConstants result;
    for (const Param& param : type.params) {
        if (param.constant) {
            result.offsets.emplace_back();
            continue;
        }
        const ParamLayout layout = layout_of(param.type);
        const auto offset = static_cast<uint32_t>(align_up(result.size, layout.alignment));
        result.offsets.emplace_back(offset);
        result.size = offset + layout.size;
    }
    if (type.levelled_output()) {
        result.mip_level = static_cast<uint32_t>(align_up(result.size, 4));
        result.size = *result.mip_level + 4;
    }
    if (!type.counters.empty()) {
        result.counter_base = static_cast<uint32_t>(align_up(result.size, 4));
        result.size = *result.counter_base + 4;
    }
    return result;
}

std::vector<std::byte> value_bytes(const Param& param, const ParamValue& value) {
    std::vector<std::byte> out;
    if (param.type == ParamType::enumeration) {
        const auto& name = std::get<std::string>(value);
        const auto index = static_cast<int32_t>(index_of(param.values, name));
        append(out, &index, 4);
    } else if (const bool* flag = std::get_if<bool>(&value)) {
        const uint32_t word = *flag;
        append(out, &word, 4);
    } else if (const auto* list = std::get_if<std::vector<float>>(&value)) {
        append(out, list->data(), 4 * list->size());
    } else {
        std::visit(
            [&](const auto& v) {
                if constexpr (sizeof(v) == 4) append(out, &v, 4);
            },
            value);
    }
    return out;
}

ParamValue value_of(const Param& param, std::span<const std::byte> bytes) {
    const auto word = [&](auto v) {
        std::memcpy(&v, bytes.data(), sizeof v);
        return v;
    };
    switch (param.type) {
        case ParamType::boolean:
            return word(uint32_t{}) != 0;
        case ParamType::integer:
            return word(int32_t{});
        case ParamType::uint:
            return word(uint32_t{});
        case ParamType::real:
            return word(float{});
        case ParamType::enumeration:
            return param.values.at(word(uint32_t{}));
        default:
            break;
    }
    std::vector<float> list(layout_of(param.type).size / sizeof(float));
    std::memcpy(list.data(), bytes.data(), list.size() * sizeof(float));
    return list;
}

bool fits(const Param& param, const ParamValue& value) {
    if (value.index() != param.default_value.index()) return false;
    // A float is held to the floats that a range's ends are.
    const auto in_range = [&]<class T>(T number) {
        return std::isfinite(double(number)) &&
               (!param.range || (T((*param.range)[0]) <= number && number <= T((*param.range)[1])));
    };
    if (const auto* name = std::get_if<std::string>(&value))
        return std::find(param.values.begin(), param.values.end(), *name) != param.values.end();
    if (const auto* list = std::get_if<std::vector<float>>(&value))
        return list->size() * sizeof(float) == layout_of(param.type).size &&
               std::all_of(list->begin(), list->end(), in_range);
    if (const auto* number = std::get_if<float>(&value)) return in_range(*number);
    if (const auto* number = std::get_if<int32_t>(&value)) return in_range(double(*number));
    if (const auto* number = std::get_if<uint32_t>(&value)) return in_range(double(*number));
    return true;
}

std::string generate_glsl(const NodeType& type, const Variant& variant) {
    std::string text =
        "// Generated from the node's declaration.\n"
        "#extension GL_KHR_shader_subgroup_basic : require\n"
        "#extension GL_KHR_shader_subgroup_arithmetic : require\n"
        "#extension GL_KHR_shader_subgroup_ballot : require\n"
        "#extension GL_EXT_control_flow_attributes : require\n";
    for (const Port& port : type.ports)
        if (port.bundle) text += backend_of(variant, *port.bundle).glsl;
    text += "#include \"penumbra/frame_block.glsl\"\n";
    if (!type.domain->structs_file.empty())
        text += fmt::format("#include \"{}\"\n", type.domain->structs_file);
    text += fmt::format(
        "const uint FRAME_RESET = {}u;\nconst uint FRAME_ORTHOGRAPHIC = {}u;\n"
        "const uint FRAME_DEPTH_AT_CENTRES = {}u;\n"
        "layout(local_size_x_id = {}, local_size_y_id = {}, local_size_z_id = {}) in;\n"
        "#define GROUP_X gl_WorkGroupSize.x\n#define GROUP_Y gl_WorkGroupSize.y\n"
        "layout(constant_id = {}) const uint PER_THREAD_X = 1u;\n"
        "layout(constant_id = {}) const uint PER_THREAD_Y = 1u;\n"
        "layout(constant_id = {}) const bool ON_CPU = false;\n"
        "layout(constant_id = {}) const uint LANES_IN_STEP = 1u;\n"
        "// Order shared memory. To wait is dear on devices where these lanes wait for nobody.\n"
        "void group_barrier() {{\n"
        "    if (gl_WorkGroupSize.x <= LANES_IN_STEP && gl_WorkGroupSize.y * gl_WorkGroupSize.z == 1u)\n"
        "        subgroupMemoryBarrierShared();\n    else\n        barrier();\n}}\n"
        "void subgroup_barrier() {{\n"
        "    subgroupMemoryBarrierShared();\n    if (LANES_IN_STEP == 1u) subgroupBarrier();\n}}\n"
        "layout(set = 1, binding = {}, std140) uniform frame_block {{ FrameBlock frame; }};\n",
        uint32_t{frame_reset}, uint32_t{frame_orthographic}, uint32_t{frame_depth_at_centres}, group_constant,
        group_constant + 1, group_constant + 2, per_thread_constant, per_thread_constant + 1, on_cpu_constant,
        in_step_constant, frame_binding);
    text += rounding_glsl;
    if (variant.cpu) text += fmt::format("#define CLASS_CPU {:d}\n", *variant.cpu);
    for (const auto& [name, exists] : variant.outputs)
        text += fmt::format("#define HAS_{} {:d}\n", upper(name), exists);
    const std::vector<uint32_t> bindings = port_bindings(type);
    const std::vector<uint32_t> in_rows = row_outputs(type);
    for (uint32_t i = 0; i < type.ports.size(); ++i) {
        const Port& port = type.ports[i];
        const auto exists = variant.outputs.find(port.name);
        if (port.updater || (exists != variant.outputs.end() && !exists->second)) continue;
        if (has_format_choice(port))
            text += fmt::format("#define FORMAT_{}_{} 1\n", upper(port.name),
                                upper(info(variant.formats.at(port.name)).name));
        text += declare_port(type, port, variant, bindings[i]);
        const Port& what = described_by(type, port);
        if (port.output && what.kind == PortKind::image && !what.layers)
            text += declare_stores(port, format_of(what, variant), variant.rows && port.in_rows,
                                   first_row_constant(type) +
                                       static_cast<uint32_t>(std::ranges::find(in_rows, i) - in_rows.begin()),
                                   bindings[i]);
    }
    uint32_t table_binding = first_table_binding(type);
    for (const Table& table : type.tables)
        text += declare_image(table.storage, false, table.name, table.format, "readonly ", table_binding++);
    return text + declare_params(type, variant) + declare_counters(type);
}

void bind_to_sets(std::vector<uint32_t>& spirv, const std::vector<HostBinding>& host_bindings) {
    constexpr uint32_t op_decorate = 71, decoration_binding = 33, decoration_set = 34;
    std::set<uint32_t> moved;  // variables' ids
    const auto each_decoration = [&](uint32_t decoration, auto&& visit) {
        for (size_t at = 5; at < spirv.size(); at += std::max(spirv[at] >> 16, 1u))
            if ((spirv[at] & 0xffff) == op_decorate && spirv[at + 2] == decoration)
                visit(spirv[at + 1], spirv[at + 3]);
    };
    each_decoration(decoration_binding, [&](uint32_t id, uint32_t& value) {
        const auto to = std::ranges::find(host_bindings, value, &HostBinding::from);
        if (to == host_bindings.end()) return;
        moved.insert(id);
        value = to->to;
    });
    each_decoration(decoration_set, [&](uint32_t id, uint32_t& value) {
        if (moved.contains(id)) value = 1;
    });
}

}  // namespace penumbra
