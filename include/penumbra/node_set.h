// SPDX-License-Identifier: MIT
// The node types a pipeline may name: declarations with their compiled shaders. An explicit table that a host
// fills (shadow_nodes() are penumbra's own); no static registration, which would vanish from a static
// library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "penumbra/export.h"
#include "penumbra/node_type.h"

namespace penumbra PENUMBRA_API {

struct HostPassContext;  // view.h: command buffer, bindings and parameters of a host node's pass
using HostCallback = std::function<void(const HostPassContext&)>;

// How a shader is specialised beyond constants, and its SPIR-V by the variant's name: penumbra's own, of no
// use to a host. Nodes of a host's own are recorded by it (NodeEntry::callback) or compiled from GLSL
// (user_nodes.h).
struct Variant;
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
    ShaderVariants shaders;  // penumbra's own
    std::vector<TableData> tables;
    HostCallback callback;    // host nodes
    ShaderSupplier supplier;  // penumbra's own
};

// The variant's SPIR-V; nullptr where the entry has none and cannot supply it (reported only if that failed).
const std::vector<uint32_t>* find_shader(const NodeEntry& entry, const Variant& variant,
                                         Diagnostics& diagnostics);

// Types of one domain. Entries are shared with the pipelines checked against the set and the plans made of
// them, which keep the entry that they were made with.
class NodeSet {
  public:
    NodeSet() = default;  // of the domain of the first type that is added
    // Throws std::invalid_argument for a domain of more than max_facts facts, or of a part that is a
    // structure and may be absent (Bundle::Part::fact, on).
    explicit NodeSet(std::shared_ptr<const Domain> domain);

    // Adds a type, in place of one of the same name. Throws std::invalid_argument for a type of another
    // domain, whose facts mean something else.
    void add(NodeEntry entry);
    std::shared_ptr<const NodeEntry> share(std::string_view name) const;  // nullptr: none
    const NodeEntry* find(std::string_view name) const { return share(name).get(); }
    std::vector<std::string> names() const;  // sorted
    // An empty one where nothing has said which.
    std::shared_ptr<const Domain> domain() const {
        return domain_ ? domain_ : std::make_shared<const Domain>();
    }

  private:
    std::shared_ptr<const Domain> domain_;
    std::map<std::string, std::shared_ptr<const NodeEntry>, std::less<>> entries_;
};

}  // namespace penumbra
