// SPDX-License-Identifier: MIT
#include "graph/instances.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "graph/suggestions.h"
#include "penumbra/condition.h"

namespace penumbra {

namespace {

std::string name_of(const std::string& name, const PipelineInstance& instance) {
    return name + "_" + instance.name;
}

class Writer {
  public:
    Writer(const Pipeline& pipeline, const NodeSet& set, Diagnostics& diagnostics)
        : pipeline_(pipeline), set_(set), diagnostics_(diagnostics) {}

    WrittenOut run() {
        Pipeline& out = result_.pipeline;
        out = {.name = pipeline_.name, .doc = pipeline_.doc, .file = pipeline_.file};
        for (const PipelineInstance& instance : pipeline_.instances)
            members_[instance.family].push_back(&instance);
        check_families();
        find_own_names();
        check_members();
        if (too_many()) return std::move(result_);
        for (const auto& [family, nodes] : nodes_of_) find_chain(nodes);
        for (const HostInput& input : pipeline_.inputs)
            each(input.instances, [&](const PipelineInstance* instance) {
                add(out.inputs, input, input.name, instance, &HostInput::name, "inputs.");
            });
        // One member's nodes after the other's: as far as the dataflow lets them they run in this order, and
        // each member's transients take the memory of the one's before.
        std::set<std::string> done;
        for (const PipelineNode& node : pipeline_.nodes) {
            if (!node.instances.empty() && !done.insert(node.instances).second) continue;
            each(node.instances, [&](const PipelineInstance* instance) {
                if (!instance) return add_node(node, nullptr);
                for (const PipelineNode* other : nodes_of_[node.instances]) add_node(*other, instance);
            });
        }
        for (const ResourceSetting& setting : pipeline_.resources)
            each(family_of(setting.name), [&](const PipelineInstance* instance) {
                ResourceSetting own = setting;
                if (instance) own.name = name_of(setting.name, *instance);
                const auto other = std::ranges::find(out.resources, own.name, &ResourceSetting::name);
                if (other == out.resources.end()) return out.resources.push_back(own);
                // What is said of one member holds before what is said of all.
                if (instance) std::swap(own, *other);
                if (own.format) {
                    other->format = own.format;
                    other->format_place = own.format_place;
                }
                if (own.first) other->first = own.first;
            });
        for (const OutputName& output : pipeline_.outputs)
            each(family_of(output.name), [&](const PipelineInstance* instance) {
                out.outputs.push_back(output);
                if (instance) out.outputs.back().name = name_of(output.name, *instance);
            });
        return std::move(result_);
    }

  private:
    void error(const Place& place, std::string path, std::string message) {
        diagnostics_.add(place, std::move(path), std::move(message));
    }

    // Few members of few nodes are many together, in a text of a few kilobytes.
    bool too_many() {
        constexpr size_t most = 100'000, most_parts = 1'000'000;
        size_t written = 0, parts = 0;
        const auto count = [&](const std::string& family, size_t parts_each = 0) {
            const auto found = members_.find(family);
            if (found == members_.end()) return;
            written += found->second.size();
            parts += found->second.size() * parts_each;
        };
        for (const PipelineNode& node : pipeline_.nodes) {
            count(node.instances, node.params.size() + node.in.size() + node.out.size());
            if (!node.instances.empty()) nodes_of_[node.instances].push_back(&node);
        }
        for (const HostInput& input : pipeline_.inputs) count(input.instances);
        for (const ResourceSetting& setting : pipeline_.resources) count(family_of(setting.name));
        for (const OutputName& output : pipeline_.outputs) count(family_of(output.name));
        const auto refuse = [&](size_t many, const char* what, size_t allowed) {
            error(pipeline_.instances.front().place, "instances",
                  fmt::format("stand for {} {}: {} are the most", many, what, allowed));
        };
        if (written > most) refuse(written, "nodes, inputs, resources and outputs", most);
        if (parts > most_parts) refuse(parts, "parameters and wires", most_parts);
        return written > most || parts > most_parts;
    }

    // Every family that is named has members, and every member a family; facts are the domain's.
    void check_families() {
        std::set<std::string> named;
        std::vector<std::string> families;
        for (const auto& [name, members] : members_) families.push_back(name);
        Suggestions near_families(std::move(families));
        const auto use = [&](const std::string& family, const Place& place, const std::string& path) {
            if (family.empty()) return;
            named.insert(family);
            if (members_.contains(family)) return;
            error(place, path + ".instances",
                  fmt::format("no instance is of \"{}\"{}", family, near_families.nearest(family)));
        };
        for (const HostInput& input : pipeline_.inputs)
            use(input.instances, input.instances_place, "inputs." + input.name);
        for (const PipelineNode& node : pipeline_.nodes)
            use(node.instances, node.instances_place, "nodes." + node.id);
        Suggestions near_named(std::vector(named.begin(), named.end()));
        std::set<std::string> names;
        for (const PipelineInstance& instance : pipeline_.instances) {
            const std::string path = "instances." + instance.name;
            if (!names.insert(instance.name).second)
                error(instance.place, path, "is another member's name, too");
            if (!named.contains(instance.family))
                error(instance.place, path,
                      fmt::format("no input and no node is of the family \"{}\"{}", instance.family,
                                  near_named.nearest(instance.family)));
            for (const auto& [fact, value] : instance.facts)
                if (auto problem = fact_problem(*set_.domain(), fact))
                    error(value.place, fmt::format("{}.facts.{}", path, fact), std::move(*problem));
        }
    }

    // What a node writes, by names: what it surely does, and what it would under the port's own name if
    // somebody asked.
    void names_of(const PipelineNode& node, std::set<std::string>& sure, std::set<std::string>& maybe) const {
        for (const Wire& wire : node.out)
            if (!wire.resource.empty()) sure.insert(wire.resource);
        const auto entry = set_.share(node.type);
        if (!entry) return;
        for (const Port& port : entry->type.ports)
            if (port.output && std::ranges::find(node.out, port.name, &Wire::port) == node.out.end())
                (port.optional ? maybe : sure).insert(port.name);
    }

    void find_own_names() {
        std::set<std::string> shared, unused;
        for (const HostInput& input : pipeline_.inputs)
            if (input.instances.empty()) shared.insert(input.name);
        for (const PipelineNode& node : pipeline_.nodes)
            if (node.instances.empty()) names_of(node, shared, unused);
        const auto own = [&](const std::string& name, const std::string& family, const Place& place,
                             const std::string& path) {
            const auto [at, added] = result_.own_names.try_emplace(name, family);
            if (shared.contains(name) || at->second != family)
                error(
                    place, path,
                    fmt::format("writes \"{}\" for each of \"{}\", and others write it, too", name, family));
        };
        for (const HostInput& input : pipeline_.inputs)
            if (!input.instances.empty())
                own(input.name, input.instances, input.instances_place, "inputs." + input.name);
        for (const PipelineNode& node : pipeline_.nodes) {
            if (node.instances.empty()) continue;
            result_.own_nodes.try_emplace(node.id, node.instances);
            std::set<std::string> sure, maybe;
            names_of(node, sure, maybe);
            for (const std::string& name : sure)
                own(name, node.instances, node.instances_place, "nodes." + node.id);
            for (const std::string& name : maybe)
                if (!shared.contains(name)) result_.own_names.try_emplace(name, node.instances);
        }
    }

    // Who asks for another member's thing asks for one that each has; the member before is one of the node's
    // own family.
    void check_members() {
        for (const PipelineNode& node : pipeline_.nodes)
            for (const Wire& wire : node.in) {
                if (wire.member == Wire::Member::own || wire.resource.empty()) continue;
                const std::string path = fmt::format("nodes.{}.in.{}", node.id, wire.port);
                const std::string family = family_of(wire.resource);
                if (family.empty())
                    error(wire.place, path,
                          fmt::format("no family has a \"{}\" for each of its members", wire.resource));
                else if (wire.member == Wire::Member::before && node.instances != family)
                    error(wire.place, path,
                          fmt::format("\"{}\" is of \"{}\", of which the node is none; there is \"{}@last\"",
                                      wire.resource, family, wire.resource));
            }
    }

    // What a node reads of its own member in this frame: of its wires, and by its ports' names where it has
    // none.
    std::set<std::string> read_by(const PipelineNode& node) const {
        std::set<std::string> names;
        for (const Wire& wire : node.in)
            if (!wire.previous && wire.member == Wire::Member::own) names.insert(wire.resource);
        if (const auto entry = set_.share(node.type))
            for (const Port& port : entry->type.ports)
                if (!port.output && !port.previous &&
                    std::ranges::find(node.in, port.name, &Wire::port) == node.in.end())
                    names.insert(port.name);
        return names;
    }

    // Of a family, who hands on from member to member: who reads a NAME@before, and who is on a way from
    // there to the node that writes NAME. These ways are circles through the members, so that nodes and names
    // that lie on some are a strongly connected component (Kosaraju).
    void find_chain(const std::vector<const PipelineNode*>& nodes) {
        std::map<std::string, size_t> names;
        std::vector<std::vector<size_t>> to(nodes.size()), from(nodes.size());
        const auto id_of = [&](const std::string& name) {
            const size_t id = names.try_emplace(name, to.size()).first->second;
            to.resize(std::max(to.size(), id + 1));
            from.resize(to.size());
            return id;
        };
        const auto add_edge = [&](size_t a, size_t b) {
            to[a].push_back(b);
            from[b].push_back(a);
        };
        for (size_t i = 0; i < nodes.size(); ++i) {
            std::set<std::string> writes;
            names_of(*nodes[i], writes, writes);
            for (const std::string& name : writes) add_edge(i, id_of(name));
            for (const std::string& name : read_by(*nodes[i])) add_edge(id_of(name), i);
            for (const Wire& wire : nodes[i]->in)
                if (wire.member == Wire::Member::before) {
                    add_edge(id_of(wire.resource), i);
                    chain_.insert(nodes[i]);
                }
        }
        std::vector<bool> left(to.size(), true);
        std::vector<size_t> ended;  // in the order in which a search is done with them
        for (size_t root = 0; root < to.size(); ++root) {
            if (!left[root]) continue;
            left[root] = false;
            std::vector<std::pair<size_t, size_t>> way{{root, 0}};
            while (!way.empty()) {
                const auto [at, next] = way.back();
                if (next == to[at].size()) {
                    ended.push_back(at);
                    way.pop_back();
                    continue;
                }
                ++way.back().second;
                const size_t other = to[at][next];
                if (left[other]) way.emplace_back(other, 0);
                left[other] = false;
            }
        }
        left.assign(to.size(), true);
        for (auto root = ended.rbegin(); root != ended.rend(); ++root) {
            if (!left[*root]) continue;
            left[*root] = false;
            std::vector<size_t> circle{*root};
            for (size_t i = 0; i < circle.size(); ++i)
                for (const size_t other : from[circle[i]]) {
                    if (left[other]) circle.push_back(other);
                    left[other] = false;
                }
            if (circle.size() > 1)
                for (const size_t id : circle)
                    if (id < nodes.size()) chain_.insert(nodes[id]);
        }
    }

    std::string family_of(const std::string& name) const {
        const auto found = result_.own_names.find(name);
        return found == result_.own_names.end() ? "" : found->second;
    }

    // Calls `make` for each member, or once with nullptr where there is no family.
    template <typename Make>
    void each(const std::string& family, Make make) const {
        if (family.empty()) return make(nullptr);
        const auto members = members_.find(family);
        if (members == members_.end()) return;
        for (const PipelineInstance* instance : members->second) make(instance);
    }

    template <typename Thing>
    Thing& add(std::vector<Thing>& list, const Thing& thing, const std::string& name,
               const PipelineInstance* instance, std::string Thing::*id, const char* path) {
        Thing& added = list.emplace_back(thing);
        added.instances.clear();
        if (instance) added.*id = name_of(name, *instance);
        if (!ids_.insert(path + added.*id).second)
            error(thing.place, path + name,
                  fmt::format("stands for \"{}\", which is another's name", added.*id));
        return added;
    }

    void add_node(const PipelineNode& node, const PipelineInstance* instance) {
        PipelineNode& added =
            add(result_.pipeline.nodes, node, node.id, instance, &PipelineNode::id, "nodes.");
        result_.of.push_back(instance);
        result_.hands_on.push_back(instance && chain_.contains(&node));
        const size_t index = result_.of.size() - 1;
        for (std::vector<Wire>* wires : {&added.in, &added.out})
            for (Wire& wire : *wires)
                wire.resource = wire.member == Wire::Member::own ? result_.name(index, wire.resource)
                                                                 : others(wire, instance);
    }

    // What another member has of a name; nothing before the first.
    std::string others(const Wire& wire, const PipelineInstance* instance) const {
        const auto found = members_.find(family_of(wire.resource));
        if (found == members_.end()) return {};  // which has been said
        const std::vector<const PipelineInstance*>& members = found->second;
        const auto own = std::ranges::find(members, instance);
        if (wire.member == Wire::Member::last || own == members.end())
            return name_of(wire.resource, *members.back());
        return own == members.begin() ? "" : name_of(wire.resource, **(own - 1));
    }

    const Pipeline& pipeline_;
    const NodeSet& set_;
    Diagnostics& diagnostics_;
    std::map<std::string, std::vector<const PipelineInstance*>> members_;  // by family, in the file's order
    std::map<std::string, std::vector<const PipelineNode*>> nodes_of_;     // by family, too
    std::set<const PipelineNode*> chain_;                                  // who hands on
    std::set<std::string> ids_;                                            // "nodes.trace_desk"
    WrittenOut result_;
};

}  // namespace

std::string WrittenOut::own(const std::map<std::string, std::string>& names, size_t node,
                            const std::string& called) const {
    const auto found = names.find(called);
    const bool is_own = of[node] && found != names.end() && found->second == of[node]->family;
    return is_own ? name_of(called, *of[node]) : called;
}

WrittenOut write_out_instances(const Pipeline& pipeline, const NodeSet& set, Diagnostics& diagnostics) {
    return Writer(pipeline, set, diagnostics).run();
}

}  // namespace penumbra
