// SPDX-License-Identifier: MIT
// The table of node types. Entries are held by pointer, so that plans may refer to them while a host adds
// more.
#include "graph/node_set.h"

#include "graph/interface.h"

namespace penumbra {

const std::vector<uint32_t>* find_shader(const NodeEntry& entry, const Variant& variant,
                                         Diagnostics& diagnostics) {
    const auto found = entry.shaders.find(to_string(variant));
    if (found != entry.shaders.end()) return &found->second;
    return entry.supplier ? entry.supplier(variant, diagnostics) : nullptr;
}

void NodeSet::add(NodeEntry entry) {
    std::unique_ptr<NodeEntry>& slot = entries_[entry.type.name];
    if (slot)
        *slot = std::move(entry);  // in place: pointers to the replaced entry stay valid and see the new one
    else
        slot = std::make_unique<NodeEntry>(std::move(entry));
}

const NodeEntry* NodeSet::find(std::string_view name) const {
    const auto found = entries_.find(name);
    return found == entries_.end() ? nullptr : found->second.get();
}

std::vector<std::string> NodeSet::names() const {
    std::vector<std::string> names;
    for (const auto& [name, entry] : entries_) names.push_back(name);
    return names;
}

}  // namespace penumbra
