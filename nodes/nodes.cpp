// SPDX-License-Identifier: MIT
// Reads what the build has embedded (CMakeLists.txt lists the types).
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "graph/embedded_file.h"
#include "nodes/archive.h"
#include "penumbra/shadow_nodes.h"

namespace penumbra {

// Declarations (GROUP/NAME.json), their shaders' variants (NAME.spv) and the tables that they name.
std::span<const EmbeddedFile> node_files();

namespace {

std::string_view file_bytes(const std::string& name) {
    const EmbeddedFile* file = find_embedded(node_files(), name);
    if (!file) throw std::logic_error("the build has not embedded " + name);
    return file->bytes;
}

NodeEntry load(const EmbeddedFile& declaration) {
    const std::string name = std::filesystem::path(declaration.name).stem().string();
    Diagnostics diagnostics;
    const auto json = parse_json(declaration.bytes, "nodes/" + std::string(declaration.name), diagnostics);
    auto type = json ? parse_node_type(*json, name, shadow_domain(), diagnostics) : std::nullopt;
    if (!type) throw std::logic_error("an embedded declaration does not parse: " + diagnostics.text());
    NodeEntry entry{std::move(*type), {}, {}, {}};
    constexpr std::string_view variant = "variant ";
    for (const auto& [key, module] : read_archive(file_bytes(name + ".spv"))) {
        std::vector<uint32_t>& words = entry.shaders[key.substr(variant.size())];
        words.resize(module.size() / 4);
        std::memcpy(words.data(), module.data(), module.size());
    }
    for (const Table& table : entry.type.tables) {
        const auto bytes = std::as_bytes(std::span(file_bytes(table.file)));
        entry.tables.push_back({table.name, {bytes.begin(), bytes.end()}});
    }
    return entry;
}

}  // namespace

NodeSet shadow_nodes() {
    NodeSet set(shadow_domain());
    for (const EmbeddedFile& file : node_files())
        if (file.name.ends_with(".json")) set.add(load(file));
    return set;
}

}  // namespace penumbra
