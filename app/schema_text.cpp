// SPDX-License-Identifier: MIT
// How schemas are written: what is short on one line, an item a line else.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/schema.h"

namespace penumbra {
namespace {

using Schema = nlohmann::ordered_json;

void write(std::string& out, const Schema& json, size_t indent) {
    constexpr size_t longest = 140;
    const std::string flat = json.dump();
    const bool plain = std::ranges::none_of(json, [](const Schema& item) { return item.is_structured(); });
    if (!json.is_structured() || (json.is_array() && plain) || flat.size() + indent <= longest) {
        out += flat;
        return;
    }
    const bool object = json.is_object();
    out += object ? "{" : "[";
    bool first = true;
    for (const auto& [key, item] : json.items()) {
        out += (first ? "\n" : ",\n") + std::string(indent + 1, ' ');
        if (object) out += Schema(key).dump() + ": ";
        write(out, item, indent + 1);
        first = false;
    }
    out += "\n" + std::string(indent, ' ') + (object ? "}" : "]");
}

}  // namespace

std::string schema_text(const nlohmann::ordered_json& schema) {
    std::string out;
    write(out, schema, 0);
    return out + "\n";
}

}  // namespace penumbra
