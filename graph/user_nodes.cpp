// SPDX-License-Identifier: MIT
// Declarations are read when the folder is added, shaders when they are needed: a folder of many nodes costs
// its JSON.
#include "penumbra/user_nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>

#include "graph/interface.h"
#include "graph/read_text.h"
#include "graph/shader_cache.h"
#include "graph/shared_glsl.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

// What a node's supplier shares with its copies: compiled variants, and the means to compile more.
struct UserShader {
    NodeType type;
    fs::path file;
    std::shared_ptr<ShaderCache> cache;
    std::mutex mutex;
    std::map<std::string, std::vector<uint32_t>> variants;

    const std::vector<uint32_t>* get(const Variant& variant, Diagnostics& diagnostics) {
        const std::lock_guard lock(mutex);
        const std::string key = to_string(variant);
        const auto known = variants.find(key);
        if (known != variants.end()) return &known->second;
        auto shader = cache->compile(
            {file, generate_glsl(type, variant), {file.parent_path()}, shared_glsl()}, key, diagnostics);
        return shader ? &variants.emplace(key, std::move(shader->spirv)).first->second : nullptr;
    }
};

class FolderReader {
  public:
    FolderReader(const NodeSet& nodes, std::shared_ptr<ShaderCache> cache, Diagnostics& diagnostics)
        : nodes_(nodes), domain_(nodes.domain()), cache_(std::move(cache)), diagnostics_(diagnostics) {}

    std::vector<NodeEntry> read(const fs::path& folder) {
        std::error_code error;
        std::vector<fs::path> files;
        for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
            const std::string name = at->path().filename().string();
            if (name.ends_with(".json") && !name.ends_with(".schema.json")) files.push_back(at->path());
        }
        if (error)
            diagnostics_.add({folder.generic_string()}, "", "cannot be read: " + error.message());
        else if (files.empty())
            diagnostics_.add({folder.generic_string()}, "", "holds no node declarations (NAME.json)");
        std::ranges::sort(files);
        std::vector<NodeEntry> entries;
        for (const fs::path& file : files)
            if (auto entry = read_node(file)) entries.push_back(std::move(*entry));
        return entries;
    }

  private:
    std::optional<NodeEntry> read_node(const fs::path& file) {
        const auto json = read_json(file, diagnostics_);
        auto type = json ? parse_node_type(*json, file.stem().string(), domain_, diagnostics_) : std::nullopt;
        if (!type) return std::nullopt;
        const size_t errors = diagnostics_.size();
        const auto error = [&](const Json* at, const std::string& path, const std::string& message) {
            diagnostics_.add(at ? at->place : type->place, path, message);
        };
        if (nodes_.find(type->name))
            error(json->find("node"), "node",
                  fmt::format("\"{}\" is a node type already; give yours a name of its own", type->name));
        if (type->host)
            error(json->find("host"), "host",
                  "only a program can bring a host node, with its callback (NodeSet::add)");
        const fs::path shader = file.parent_path() / type->shader;
        std::error_code unreadable;
        if (!type->host && !fs::is_regular_file(shader, unreadable))
            error(json->find("shader"), "shader", fmt::format("no file {}", shader.generic_string()));
        NodeEntry entry;
        for (const Table& table : type->tables) {
            const Json* at = json->find("tables")->find(table.name)->find("file");
            const auto bytes = read_text(file.parent_path() / table.file);
            const size_t expected = size_t{info(table.format).bytes} * table.extent[0] * table.extent[1];
            const std::string path = "tables." + table.name + ".file";
            if (!bytes)
                error(at, path,
                      fmt::format("no file {}", (file.parent_path() / table.file).generic_string()));
            else if (bytes->size() != expected)
                error(at, path,
                      fmt::format("has {} bytes; format and extent ask for {}", bytes->size(), expected));
            else
                entry.tables.push_back({table.name, as_bytes(*bytes)});
        }
        if (diagnostics_.size() != errors) return std::nullopt;
        auto shared = std::make_shared<UserShader>();
        shared->type = *type;
        shared->file = shader;
        shared->cache = cache_;
        entry.type = std::move(*type);
        entry.supplier = [shared](const Variant& variant, Diagnostics& out) {
            return shared->get(variant, out);
        };
        return entry;
    }

    static std::vector<std::byte> as_bytes(const std::string& text) {
        const auto bytes = std::as_bytes(std::span(text));
        return {bytes.begin(), bytes.end()};
    }

    const NodeSet& nodes_;
    const std::shared_ptr<const Domain> domain_;  // one for all, also where the set has none yet
    std::shared_ptr<ShaderCache> cache_;
    Diagnostics& diagnostics_;
};

}  // namespace

fs::path default_shader_cache() {
    for (const auto& [variable, below] : {std::pair{"XDG_CACHE_HOME", ""}, std::pair{"HOME", ".cache"}}) {
        const char* value = std::getenv(variable);
        if (value && fs::path(value).is_absolute()) return fs::path(value) / below / "penumbra";
    }
    return {};
}

std::shared_ptr<ShaderCache> open_shader_cache(const fs::path& folder,
                                               std::function<void(const std::string&)> warn) {
    return std::make_shared<ShaderCache>(folder, std::move(warn));
}

bool add_user_nodes(NodeSet& nodes, const fs::path& folder, Diagnostics& diagnostics,
                    std::shared_ptr<ShaderCache> cache) {
    if (!cache) cache = std::make_shared<ShaderCache>(default_shader_cache());
    const size_t errors = diagnostics.size();
    std::vector<NodeEntry> entries = FolderReader(nodes, std::move(cache), diagnostics).read(folder);
    if (diagnostics.size() != errors) return false;
    NodeSet with = nodes;  // all of them or, where memory ends, none
    for (NodeEntry& entry : entries) with.add(std::move(entry));
    nodes = std::move(with);
    return true;
}

bool compile_user_nodes(const CheckedPipeline& pipeline, Diagnostics& diagnostics) {
    std::map<std::string, const NodeEntry*> types;
    for (const BoundNode& node : pipeline.nodes) types.emplace(node.type().name, node.entry.get());
    bool good = true;
    for (const auto& [name, entry] : types) {
        if (!entry->supplier) continue;
        for (const Variant& variant : all_variants(entry->type)) {
            if (find_shader(*entry, variant, diagnostics)) continue;
            good = false;
            break;  // other variants mostly repeat the first one's errors
        }
    }
    return good;
}

}  // namespace penumbra
