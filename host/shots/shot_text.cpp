// SPDX-License-Identifier: MIT
#include "host/shots/shot_text.h"

#include "host/json_dump.h"

namespace penumbra {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr size_t line_width = 110;

// The members of a list or an object between their brackets, each as `text` writes it.
template <class Text>
std::string members(const OrderedJson& json, const std::string& between, const Text& text) {
    std::string all;
    for (auto member = json.begin(); member != json.end(); ++member) {
        if (!all.empty()) all += between;
        if (json.is_object()) all += json_dump(OrderedJson(member.key())) + ": ";
        all += text(*member);
    }
    return all;
}

std::string in_a_line(const OrderedJson& json) {
    if (!json.is_structured()) return json_dump(json);
    const std::string inside = members(json, ", ", in_a_line);
    if (json.is_array()) return "[" + inside + "]";
    return inside.empty() ? "{}" : "{ " + inside + " }";
}

std::string laid_out(const OrderedJson& json, size_t indent) {
    if (const std::string line = in_a_line(json);
        indent > 0 && (!json.is_structured() || indent + line.size() <= line_width))
        return line;
    const std::string outer = "\n" + std::string(indent, ' '), inner = outer + "  ";
    const std::string inside =
        members(json, "," + inner, [&](const OrderedJson& member) { return laid_out(member, indent + 2); });
    return (json.is_array() ? "[" : "{") + inner + inside + outer + (json.is_array() ? "]" : "}");
}

}  // namespace

std::string shot_text(const OrderedJson& shot) {
    return laid_out(shot, 0) + "\n";
}

}  // namespace penumbra
