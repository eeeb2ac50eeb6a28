// SPDX-License-Identifier: MIT
#include "graph/stores.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "graph/interface.h"

namespace penumbra {
namespace {

// How a texel is stored into a buffer: the element's type, and what it is of a colour `v`.
struct RowFormat {
    const char *element, *of_v;
    uint32_t bytes;
};
std::optional<RowFormat> row_format(Format format) {
    switch (format) {
        case Format::r32ui:
            return RowFormat{"uint", "v.x", 4};
        case Format::rg32ui:
            return RowFormat{"uvec2", "v.xy", 8};
        case Format::rgba32ui:
            return RowFormat{"uvec4", "v", 16};
        case Format::r32f:
            return RowFormat{"float", "v.x", 4};
        case Format::rg32f:
            return RowFormat{"vec2", "v.xy", 8};
        case Format::rgba32f:
            return RowFormat{"vec4", "v", 16};
        case Format::rg16f:
            return RowFormat{"uint", "packHalf2x16(v.xy)", 4};
        case Format::rgba16f:
        case Format::r16f:  // of four texels
            return RowFormat{"uvec2", "uvec2(packHalf2x16(v.xy), packHalf2x16(v.zw))", 8};
        case Format::rg16s:
            return RowFormat{"uint", "packSnorm2x16(v.xy)", 4};
        case Format::rgb10a2:
            return RowFormat{"uint", "pack_unorm(v, uvec4(1023u, 1023u, 1023u, 3u), 10)", 4};
        case Format::rgba8:
        case Format::r8:  // of four texels
            return RowFormat{"uint", "pack_unorm(v, uvec4(255u), 8)", 4};
        default:
            return std::nullopt;  // its texels are no words
    }
}

}  // namespace

bool has_rows(Format format) {
    return row_format(format).has_value();
}

uint32_t row_element_bytes(Format format) {
    const auto rows = row_format(format);
    return rows ? rows->bytes : 0;
}

std::string upper(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
    return text;
}

const char* glsl_prefix(Format format) {
    return info(format).kind == FormatClass::uint ? "u" : "";
}

// What is finite stays so, as in stores into an image. Halves are rounded to nearest, ties to even, also
// where a device's stores are not: normal ones by their bits, others, steps of 2^-24, by those beside 0.5.
// Beside 2^23 a float's last bit is 1, so that a sum is rounded to a whole number, which its bits end in:
// lavapipe converts lane by lane.
const char* const rounding_glsl =
    "vec4 within_halves(vec4 v) {\n"
    "    const uvec4 above = floatBitsToUint(v) & 0x7f800000u;\n"
    "    return mix(clamp(v, -65504.0, 65504.0), v, equal(above, uvec4(0x7f800000u)));\n}\n"
    "vec4 to_halves(vec4 v) {\n"
    "    v = within_halves(v);\n"
    "    const uvec4 bits = floatBitsToUint(v), nearest = bits + 0xfffu + (bits >> 13 & 1u) & ~0x1fffu;\n"
    "    const vec4 steps = vec4(ivec4(floatBitsToUint(abs(v) + 0.5) - 0x3f000000u)) * "
    "5.9604644775390625e-8;\n"
    "    const uvec4 denormal = floatBitsToUint(steps) | bits & 0x80000000u;\n"
    "    return uintBitsToFloat(mix(nearest, denormal, lessThan(abs(v), vec4(6.103515625e-5))));\n}\n"
    "uint pack_unorm(vec4 v, uvec4 most, int bits) {\n"
    "    const uvec4 n = floatBitsToUint(clamp(v, 0.0, 1.0) * vec4(most) + 8388608.0) & most;\n"
    "    return n.x | n.y << bits | n.z << 2 * bits | n.w << 3 * bits;\n}\n";

std::string declare_stores(const Port& port, Format format, bool in_rows, uint32_t row_constant,
                           uint32_t binding) {
    const std::string &name = port.name, color = glsl_prefix(format) + std::string("vec4");
    const FormatInfo& of = info(format);
    const bool narrow = of.bytes < 4;  // than a word
    const bool halves = of.kind == FormatClass::real && of.bytes == 2 * of.channels;
    const auto function = [&](const char* store, bool words, const std::string& body) {
        const char* first = !halves ? "" : words ? "    v = within_halves(v);\n" : "    v = to_halves(v);\n";
        return fmt::format("void {}_{}(ivec2 p, {} v) {{\n{}{}}}\n", store, name, color, first, body);
    };
    const auto row_of = [&](const char* column) {
        return fmt::format(
            "    const uint x = {0}, at = uint(p.y) * {1}_ROW + x;\n"
            "    if (x < {1}_ROW && at < uint({2}_rows.length())) {2}_rows[at] = {3};\n",
            column, upper(name), name, row_format(format)->of_v);
    };
    std::string text;
    if (in_rows)
        text = fmt::format(
            "layout(set = 0, binding = {0}, std430) restrict writeonly buffer {1}_rows_buffer {{ {2} "
            "{1}_rows[]; }};\nlayout(constant_id = {3}) const uint {4}_ROW = 1u;\n",
            binding + 1, name, row_format(format)->element, row_constant, upper(name));
    const bool words = in_rows && !narrow;
    text += function("store", words,
                     words ? row_of("uint(p.x)") : fmt::format("    imageStore({}, p, v);\n", name));
    if (!narrow || of.channels > 1) return text;
    std::string four;
    for (const char* i : {"0", "1", "2", "3"})
        four += fmt::format("    imageStore({}, p + ivec2({}, 0), {}(v[{}]));\n", name, i, color, i);
    return text + function("store4", in_rows, in_rows ? row_of("uint(p.x) / 4u") : four);
}

}  // namespace penumbra
