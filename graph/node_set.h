// SPDX-License-Identifier: MIT
// The node types a pipeline may name: declarations with their compiled shaders. An explicit table that a host
// fills (nodes/nodes.h has penumbra's own); no static registration, which would vanish from a static library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "graph/node_type.h"

namespace penumbra {

struct Variant;          // interface.h
struct HostPassContext;  // view.h: command buffer, bindings and parameters of a host node's pass
using HostCallback = std::function<void(const HostPassContext&)>;

// SPIR-V per variant key (see interface.h: the storage formats and optional ports that a variant was compiled
// for).
using ShaderVariants = std::map<std::string, std::vector<uint32_t>>;

// Gives a variant that ShaderVariants lack, for nodes that are compiled when they are used (user_nodes.h):
// nullptr after reporting why not. What it points to lives as long as the function.
using ShaderSupplier = std::function<const std::vector<uint32_t>*(const Variant&, Diagnostics&)>;

struct TableData {
    std::string name;
    std::vector<std::byte> texels;
};

struct NodeEntry {
    NodeType type;
    ShaderVariants shaders;
    std::vector<TableData> tables;
    HostCallback callback;  // host nodes
    ShaderSupplier supplier;
};

// The variant's SPIR-V; nullptr where the entry has none and cannot supply it (reported only if that failed).
const std::vector<uint32_t>* find_shader(const NodeEntry& entry, const Variant& variant,
                                         Diagnostics& diagnostics);

class NodeSet {
  public:
    // Adds a type; a type of the same name is replaced. Pointers to entries stay valid for the set's
    // lifetime.
    void add(NodeEntry entry);
    const NodeEntry* find(std::string_view name) const;
    std::vector<std::string> names() const;  // sorted

    // Sizes in bytes of the structs that blocks and buffer elements may name (shaders/common/blocks.h).
    void add_struct(std::string name, uint32_t bytes) { structs_[std::move(name)] = bytes; }
    const std::map<std::string, uint32_t>& structs() const { return structs_; }

  private:
    std::map<std::string, std::unique_ptr<NodeEntry>, std::less<>> entries_;
    std::map<std::string, uint32_t> structs_;
};

}  // namespace penumbra
