// SPDX-License-Identifier: MIT
// The second part of check(): writers, updates and order under every combination of facts.
// Conditions are conjunctions of few facts, so the questions "is there a writer?" and "is there a cycle?" are
// answered by trying every combination of the facts that occur (2^8 at most) instead of by reasoning about
// formulas.
#include "graph/check_dataflow.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <set>

#include "graph/condition.h"

namespace penumbra {

namespace {

std::vector<std::string> facts_in(const std::vector<const Condition*>& conditions) {
    std::set<std::string> names;
    for (const Condition* condition : conditions)
        for (const Literal& literal : *condition) names.insert(literal.name);
    return {names.begin(), names.end()};
}

// Bit i of `bits` is the truth of names[i].
Facts facts_of(const std::vector<std::string>& names, size_t bits) {
    Facts facts;
    for (size_t i = 0; i < names.size(); ++i) facts[names[i]] = (bits >> i & 1) != 0;
    return facts;
}

// The shortest condition, dropping facts greedily, under which `bad` holds whatever the other facts are; none
// if nothing is bad. All facts true is tried first: it is the default and the least surprising
// counterexample.
std::optional<Condition> find_bad(const std::vector<std::string>& names,
                                  const std::function<bool(const Facts&)>& bad) {
    const size_t combinations = size_t{1} << names.size();
    std::vector<bool> is_bad(combinations);
    for (size_t bits = 0; bits < combinations; ++bits) is_bad[bits] = bad(facts_of(names, bits));
    const auto found = std::find(is_bad.rbegin(), is_bad.rend(), true);
    if (found == is_bad.rend()) return std::nullopt;
    const size_t example = combinations - 1 - static_cast<size_t>(found - is_bad.rbegin());

    size_t kept = combinations - 1;  // mask of the facts that matter
    for (size_t i = 0; i < names.size(); ++i) {
        const size_t fewer = kept & ~(size_t{1} << i);
        bool always = true;
        for (size_t bits = 0; bits < combinations; ++bits)
            if ((bits & fewer) == (example & fewer)) always = always && is_bad[bits];
        if (always) kept = fewer;
    }
    Condition condition;
    for (size_t i = 0; i < names.size(); ++i)
        if (kept >> i & 1) condition.push_back({names[i], (example >> i & 1) == 0, std::nullopt});
    return condition;
}

class DataflowChecker {
  public:
    DataflowChecker(const Dataflow& dataflow, Diagnostics& diagnostics)
        : dataflow_(dataflow), nodes_(dataflow.pipeline.nodes), diagnostics_(diagnostics) {}

    void run() {
        for (const auto& [name, use] : dataflow_.resources) {
            check_single_writer(name, use);
            check_presence(name, use);
            check_updates(name, use);
        }
        check_outputs();
        check_cycles();
    }

  private:
    void error(const PortUse& use, std::string message) {
        diagnostics_.add(use.place, use.path, std::move(message));
    }

    static bool is_updater(const PortUse& writer) { return !writer.bound->port->updates.empty(); }

    const BoundPort& updated_input(const PortUse& writer) const {
        const BoundNode& node = nodes_[writer.node];
        return *std::ranges::find_if(node.ports, [&](const BoundPort& bound) {
            return bound.port->name == writer.bound->port->updates;
        });
    }

    void check_single_writer(const std::string& name, const ResourceUse& use) {
        for (size_t i = 0; i < use.writers.size(); ++i) {
            if (use.host)
                error(use.writers[i], fmt::format("\"{}\" is a host input; a node cannot write it", name));
            for (size_t j = 0; j < i; ++j)
                if (!exclusive(use.writers[i].condition, use.writers[j].condition))
                    error(
                        use.writers[i],
                        fmt::format(
                            "\"{}\" is also written by {}; two writers of one name need conditions (\"if\") "
                            "that exclude each other",
                            name, use.writers[j].path));
        }
    }

    // Under which facts `needed` holds and nobody writes.
    std::optional<Condition> missing_writer(const ResourceUse& use, const Condition& needed) const {
        std::vector<const Condition*> conditions = {&needed};
        for (const PortUse& writer : use.writers) conditions.push_back(&writer.condition);
        return find_bad(facts_in(conditions), [&](const Facts& facts) {
            return holds(needed, facts, {}) && std::ranges::none_of(use.writers, [&](const PortUse& writer) {
                       return holds(writer.condition, facts, {});
                   });
        });
    }

    void check_presence(const std::string& name, const ResourceUse& use) {
        for (const PortUse& reader : use.readers) {
            if (reader.bound->port->optional) continue;
            if (use.host) {
                if (use.host->optional)
                    error(
                        reader,
                        fmt::format("the host may leave out \"{}\" (\"optional\": true), but the port is not "
                                    "optional",
                                    name));
                continue;
            }
            if (use.writers.empty()) continue;  // reported where the name was looked up
            if (const auto facts = missing_writer(use, reader.condition))
                error(reader, fmt::format("nobody writes \"{}\" where {}, and the port is not optional", name,
                                          to_string(*facts)));
        }
    }

    // Names that take over the memory of `name`, which must then be read before them and cannot outlive the
    // frame.
    void check_updates(const std::string& name, const ResourceUse& use) {
        std::vector<const PortUse*> updaters;
        for (const auto& [new_name, new_use] : dataflow_.resources)
            for (const PortUse& writer : new_use.writers)
                if (is_updater(writer) && updated_input(writer).resource == name) updaters.push_back(&writer);
        std::ranges::sort(updaters, {}, [](const PortUse* updater) { return updater->node; });

        for (size_t i = 0; i < updaters.size(); ++i) {
            const PortUse& updater = *updaters[i];
            if (use.host)
                error(updater, fmt::format("\"{}\" is a host input, which cannot be updated", name));
            if (is_kept(use))
                error(updater, fmt::format("\"{}\" is kept for the next frame and cannot be updated", name));
            if (updated_input(updater).previous)
                error(updater,
                      fmt::format("\"{}@-1\" is the previous frame's value, which cannot be updated", name));
            for (size_t j = 0; j < i; ++j)
                if (!exclusive(updater.condition, updaters[j]->condition))
                    error(updater, fmt::format("\"{}\" is also updated by {}; a name has one updater", name,
                                               updaters[j]->path));
            for (const PortUse& reader : use.readers)
                if (reader.bound->previous && !updated_input(updater).previous && !use.host &&
                    !exclusive(reader.condition, updater.condition))
                    error(reader,
                          fmt::format("\"{}\" does not last to the next frame: {} updates it to \"{}\"; read "
                                      "\"{}@-1\"",
                                      name, updater.path, updater.bound->resource,
                                      last_of_chain(updater.bound->resource)));
            const auto output = std::ranges::find(dataflow_.outputs, name, &OutputName::name);
            if (output != dataflow_.outputs.end() && !updated_input(updater).previous)
                diagnostics_.add(
                    output->place, output_path(*output),
                    fmt::format("\"{}\" does not last to the end of the frame: {} updates it to \"{}\"", name,
                                updater.path, updater.bound->resource));
        }
    }

    std::string last_of_chain(const std::string& name) const {
        std::string last = name;
        for (size_t steps = 0; steps < dataflow_.resources.size(); ++steps) {
            const std::string before = last;
            for (const auto& [new_name, use] : dataflow_.resources)
                for (const PortUse& writer : use.writers)
                    if (is_updater(writer) && updated_input(writer).resource == before) last = new_name;
            if (last == before) break;
        }
        return last;
    }

    std::string output_path(const OutputName& output) const {
        return fmt::format("outputs[{}]", &output - dataflow_.outputs.data());
    }

    void check_outputs() {
        for (const OutputName& output : dataflow_.outputs) {
            const auto found = dataflow_.resources.find(output.name);
            if (found == dataflow_.resources.end() || found->second.host || found->second.writers.empty())
                continue;  // reported where the name was looked up
            if (const auto facts = missing_writer(found->second, {}))
                diagnostics_.add(
                    output.place, output_path(output),
                    fmt::format("nobody writes \"{}\" where {}", output.name, to_string(*facts)));
        }
    }

    struct Edge {
        size_t from, to;
        Condition condition;  // both ends exist
        const PortUse* why;   // the port that asks for this order
    };

    bool updates(size_t node, const std::string& name) const {
        return std::ranges::any_of(nodes_[node].ports, [&](const BoundPort& bound) {
            const std::string& input = bound.port->updates;
            const auto is_source = [&](const BoundPort& other) {
                return other.port->name == input && other.resource == name;
            };
            return !input.empty() && std::ranges::any_of(nodes_[node].ports, is_source);
        });
    }

    // Within a frame: a writer comes before its readers, other readers of a name before its updater.
    std::vector<Edge> edges() const {
        std::vector<Edge> edges;
        const auto add = [&](const PortUse& first, const PortUse& second, const PortUse& why) {
            if (exclusive(first.condition, second.condition)) return;
            Condition both = first.condition;
            both.insert(both.end(), second.condition.begin(), second.condition.end());
            edges.push_back({first.node, second.node, std::move(both), &why});
        };
        for (const auto& [name, use] : dataflow_.resources) {
            for (const PortUse& reader : use.readers) {
                if (reader.bound->previous) continue;
                for (const PortUse& writer : use.writers) add(writer, reader, reader);
                if (updates(reader.node, name)) continue;  // a second updater is an error of its own
                for (const auto& [new_name, new_use] : dataflow_.resources)
                    for (const PortUse& updater : new_use.writers)
                        if (is_updater(updater) && updated_input(updater).resource == name)
                            add(reader, updater, updater);
            }
        }
        return edges;
    }

    void check_cycles() {
        const std::vector<Edge> all = edges();
        std::vector<const Condition*> conditions;
        for (const Edge& edge : all) conditions.push_back(&edge.condition);
        const std::vector<std::string> names = facts_in(conditions);
        std::set<std::vector<size_t>> reported;  // each cycle's nodes, sorted
        for (size_t bits = size_t{1} << names.size(); bits-- > 0;) {
            const Facts facts = facts_of(names, bits);
            std::vector<std::vector<const Edge*>> next(nodes_.size());
            for (const Edge& edge : all)
                if (holds(edge.condition, facts, {})) next[edge.from].push_back(&edge);
            std::vector<bool> done = in_no_cycle(next);
            for (size_t start = 0; start < nodes_.size(); ++start) {
                if (done[start]) continue;
                const std::vector<const Edge*> cycle = shortest_cycle(next, start);
                if (cycle.empty()) continue;
                std::vector<size_t> members;
                for (const Edge* edge : cycle) members.push_back(edge->from);
                for (const size_t member : members) done[member] = true;
                std::ranges::sort(members);
                if (reported.insert(members).second) report_cycle(cycle);
            }
        }
    }

    // Nodes that can run in some order (Kahn 1962); what remains lies on a cycle or waits for one.
    static std::vector<bool> in_no_cycle(const std::vector<std::vector<const Edge*>>& next) {
        std::vector<size_t> waits_for(next.size()), ready;
        for (const auto& outgoing : next)
            for (const Edge* edge : outgoing) ++waits_for[edge->to];
        for (size_t node = 0; node < next.size(); ++node)
            if (waits_for[node] == 0) ready.push_back(node);
        for (size_t i = 0; i < ready.size(); ++i)
            for (const Edge* edge : next[ready[i]])
                if (--waits_for[edge->to] == 0) ready.push_back(edge->to);
        std::vector<bool> sorted(next.size());
        for (const size_t node : ready) sorted[node] = true;
        return sorted;
    }

    // Breadth first from `start` back to it; empty if there is no way.
    static std::vector<const Edge*> shortest_cycle(const std::vector<std::vector<const Edge*>>& next,
                                                   size_t start) {
        std::vector<const Edge*> arrived(next.size());
        std::vector<size_t> queue = {start};
        for (size_t i = 0; i < queue.size(); ++i) {
            for (const Edge* edge : next[queue[i]]) {
                if (arrived[edge->to]) continue;
                arrived[edge->to] = edge;
                queue.push_back(edge->to);
            }
        }
        std::vector<const Edge*> cycle;
        if (!arrived[start]) return cycle;
        for (const Edge* edge = arrived[start];; edge = arrived[edge->from]) {
            cycle.push_back(edge);
            if (edge->from == start) break;
        }
        std::ranges::reverse(cycle);
        return cycle;
    }

    void report_cycle(const std::vector<const Edge*>& cycle) {
        std::string ids;
        for (const Edge* edge : cycle) ids += nodes_[edge->from].id + " -> ";
        error(*cycle.back()->why, fmt::format("nodes wait for each other within one frame: {}{}", ids,
                                              nodes_[cycle.front()->from].id));
    }

    const Dataflow& dataflow_;
    const std::vector<BoundNode>& nodes_;
    Diagnostics& diagnostics_;
};

}  // namespace

void check_dataflow(const Dataflow& dataflow, Diagnostics& diagnostics) {
    DataflowChecker(dataflow, diagnostics).run();
}

}  // namespace penumbra
