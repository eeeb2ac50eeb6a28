// SPDX-License-Identifier: MIT
// The table of node types.
#include "penumbra/node_set.h"

#include <stdexcept>

#include "graph/interface.h"

namespace penumbra {

namespace {

// A set of cases of facts has a bit for each (condition.h): more would be cut off without a word. Nothing can
// be bound in place of an acceleration structure that is absent.
std::shared_ptr<const Domain> checked(std::shared_ptr<const Domain> domain) {
    if (!domain) return domain;
    if (domain->facts.size() > max_facts)
        throw std::invalid_argument("the domain has " + std::to_string(domain->facts.size()) +
                                    " facts, and at most " + std::to_string(max_facts) + " are possible");
    for (const Bundle& bundle : domain->bundles)
        for (const Bundle::Part& part : bundle.parts)
            if (part.kind == PortKind::structure && !part.always())
                throw std::invalid_argument("the part \"" + part.name + "\" of \"" + bundle.kind +
                                            "\" is an acceleration structure, which cannot exist by a fact "
                                            "or by the size of texel buffers");
    return domain;
}

}  // namespace

NodeSet::NodeSet(std::shared_ptr<const Domain> domain) : domain_(checked(std::move(domain))) {}

const std::vector<uint32_t>* find_shader(const NodeEntry& entry, const Variant& variant,
                                         Diagnostics& diagnostics) {
    const auto found = entry.shaders.find(to_string(variant));
    if (found != entry.shaders.end()) return &found->second;
    return entry.supplier ? entry.supplier(variant, diagnostics) : nullptr;
}

void NodeSet::add(NodeEntry entry) {
    if (!domain_) domain_ = checked(entry.type.domain);
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
