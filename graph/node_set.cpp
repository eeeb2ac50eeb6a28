// SPDX-License-Identifier: MIT
// The table of node types.
#include "penumbra/node_set.h"

#include <stdexcept>

#include "graph/interface.h"

namespace penumbra {

const std::vector<uint32_t>* find_shader(const NodeEntry& entry, const Variant& variant,
                                         Diagnostics& diagnostics) {
    const auto found = entry.shaders.find(to_string(variant));
    if (found != entry.shaders.end()) return &found->second;
    return entry.supplier ? entry.supplier(variant, diagnostics) : nullptr;
}

void NodeSet::add(NodeEntry entry) {
    if (!domain_) domain_ = entry.type.domain;
    if (entry.type.domain != domain_)
        throw std::invalid_argument("the node type \"" + entry.type.name + "\" was read with another domain");
    std::string name = entry.type.name;
    entries_.insert_or_assign(std::move(name), std::make_shared<const NodeEntry>(std::move(entry)));
}

std::shared_ptr<const NodeEntry> NodeSet::share(std::string_view name) const {
    const auto found = entries_.find(name);
    return found == entries_.end() ? nullptr : found->second;
}

std::vector<std::string> NodeSet::names() const {
    std::vector<std::string> names;
    for (const auto& [name, entry] : entries_) names.push_back(name);
    return names;
}

}  // namespace penumbra
