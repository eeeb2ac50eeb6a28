// SPDX-License-Identifier: MIT
// The second part of check(): writers, updates and order under every combination of facts.
// A condition is the set of cases in which it holds (condition.h), so that "is there a writer?" is a
// difference of sets, and "is there a cycle?" is asked once for each set of edges that some case has.
#include "graph/check_dataflow.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <string_view>

#include "graph/condition.h"

namespace penumbra {

namespace {

// Facts in the order of their names, in which an error lists them; bit i of a case is fact_names[i].
std::vector<size_t> facts_by_name() {
    std::vector<size_t> order(fact_names.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::ranges::sort(order, {}, [](size_t fact) { return std::string_view(fact_names[fact]); });
    return order;
}

// The shortest condition, dropping facts greedily, that holds in bad cases only. The example that it starts
// from has as many facts true as can be, the last names first: true is the default, and the least surprising
// counterexample.
Condition describe(const FactCases& bad) {
    const std::vector<size_t> order = facts_by_name();
    FactCases left = bad;
    for (auto fact = order.rbegin(); fact != order.rend(); ++fact) {
        const FactCases with = left & cases_of(fact_names[*fact], false);
        if (with.any()) left = with;
    }
    size_t example = 0;
    while (!left[example]) ++example;

    std::vector<bool> kept(fact_names.size(), true);
    const auto condition = [&] {
        Condition literals;
        for (const size_t fact : order)
            if (kept[fact]) literals.push_back({fact_names[fact], (example >> fact & 1) == 0, std::nullopt});
        return literals;
    };
    for (const size_t fact : order) {
        kept[fact] = false;
        if ((cases_of(condition()) & ~bad).any()) kept[fact] = true;
    }
    return condition();
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
                if ((use.writers[i].cases & use.writers[j].cases).any())
                    error(
                        use.writers[i],
                        fmt::format(
                            "\"{}\" is also written by {}; two writers of one name need conditions (\"if\") "
                            "that exclude each other",
                            name, use.writers[j].path));
        }
    }

    // When something is needed and nobody writes it.
    static std::optional<std::string> missing_writer(const ResourceUse& use, FactCases needed) {
        for (const PortUse& writer : use.writers) needed &= ~writer.cases;
        if (needed.none()) return std::nullopt;
        const Condition facts = describe(needed);
        return facts.empty() ? "with these parameters" : "where " + to_string(facts);
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
            if (const auto when = missing_writer(use, reader.cases))
                error(reader,
                      fmt::format("nobody writes \"{}\" {}, and the port is not optional", name, *when));
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
                if ((updater.cases & updaters[j]->cases).any())
                    error(updater, fmt::format("\"{}\" is also updated by {}; a name has one updater", name,
                                               updaters[j]->path));
            for (const PortUse& reader : use.readers)
                if (reader.bound->previous && !updated_input(updater).previous && !use.host &&
                    (reader.cases & updater.cases).any())
                    error(reader,
                          fmt::format("\"{}\" does not last to the next frame: {} updates it to \"{}\"; read "
                                      "\"{}@-1\"",
                                      name, updater.path, updater.bound->resource,
                                      last_of_chain(updater.bound->resource)));
            const auto output = std::ranges::find(dataflow_.outputs, name, &OutputName::name);
            if (output != dataflow_.outputs.end() && !updated_input(updater).previous && updater.cases.any())
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
            if (const auto when = missing_writer(found->second, all_cases()))
                diagnostics_.add(output.place, output_path(output),
                                 fmt::format("nobody writes \"{}\" {}", output.name, *when));
        }
    }

    struct Edge {
        size_t from, to;
        FactCases cases;     // both ends exist
        const PortUse* why;  // the port that asks for this order
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
            const FactCases both = first.cases & second.cases;
            if (both.any()) edges.push_back({first.node, second.node, both, &why});
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
        std::set<std::vector<bool>> seen;        // which edges exist together
        std::set<std::vector<size_t>> reported;  // each cycle's nodes, sorted
        for (size_t c = all_cases().size(); c-- > 0;) {
            std::vector<bool> exists;
            for (const Edge& edge : all) exists.push_back(edge.cases[c]);
            if (!seen.insert(exists).second) continue;
            std::vector<std::vector<const Edge*>> next(nodes_.size());
            for (size_t i = 0; i < all.size(); ++i)
                if (exists[i]) next[all[i].from].push_back(&all[i]);
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
