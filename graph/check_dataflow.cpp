// SPDX-License-Identifier: MIT
// The second part of check(): writers, updates and order under every combination of facts.
// A condition is the set of cases in which it holds (condition.h), so that "is there a writer?" is a
// difference of sets, and "is there a cycle?" is asked once for each set of edges that some case has.
#include "graph/check_dataflow.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <span>
#include <string_view>

namespace penumbra {

namespace {

// The shortest condition, dropping facts greedily, that holds in bad cases only, as text. The example that it
// starts from has as many facts true as can be, the last names first: true is the default, and the least
// surprising counterexample.
std::string describe(const FactCases& bad, const Domain& domain) {
    std::vector<size_t> order(domain.facts.size());  // by name, in which an error lists them
    std::iota(order.begin(), order.end(), size_t{0});
    std::ranges::sort(order, {}, [&](size_t fact) { return std::string_view(domain.facts[fact].name); });
    FactCases left = bad;
    for (auto fact = order.rbegin(); fact != order.rend(); ++fact) {
        const FactCases with = left & cases_of(*fact, false);
        if (with.any()) left = with;
    }
    size_t example = 0;
    while (!left[example]) ++example;

    std::vector<bool> kept(domain.facts.size(), true);
    for (const size_t fact : order) {
        kept[fact] = false;
        FactCases all = all_cases();
        for (const size_t other : order)
            if (kept[other]) all &= cases_of(other, (example >> other & 1) == 0);
        if ((all & ~bad).any()) kept[fact] = true;
    }
    std::string text;
    for (const size_t fact : order)
        if (kept[fact])
            text += (text.empty() ? "" : " & ") + std::string((example >> fact & 1) == 0 ? "!" : "") +
                    domain.facts[fact].name;
    return text;
}

class DataflowChecker {
  public:
    DataflowChecker(const Dataflow& dataflow, Diagnostics& diagnostics)
        : dataflow_(dataflow), nodes_(dataflow.pipeline.nodes), diagnostics_(diagnostics) {
        updaters_.resize(dataflow_.resources.size());
        contested_.resize(dataflow_.resources.size());
        for (const ResourceUse& use : dataflow_.resources)
            for (const PortUse& writer : use.writers)
                if (const BoundPort* updated = dataflow_.updated(writer);
                    updated && updated->resource != no_resource)
                    updaters_[updated->resource].push_back(&writer);
        for (std::vector<const PortUse*>& list : updaters_) std::ranges::sort(list, {}, &PortUse::node);
        for (const OutputName& output : dataflow_.source.outputs) outputs_.try_emplace(output.name, &output);
    }

    std::vector<Edge> run() {
        for (const uint32_t id : dataflow_.by_name) {
            const ResourceUse& use = dataflow_.resources[id];
            check_single_writer(id, use);
            check_presence(use.name, use);
            check_updates(id, use);
        }
        check_outputs();
        const std::vector<Wait> waits = order_within_frame();
        check_cycles(waits, true, "nodes wait for each other within one frame");
        check_cycles(sizes(), false, "sizes follow each other");
        std::vector<Edge> edges;
        std::map<std::pair<size_t, size_t>, std::vector<FactCases>> known;  // between these two
        for (const Wait& wait : waits) {
            std::vector<FactCases>& cases = known[{wait.from, wait.to}];
            if (std::ranges::find(cases, wait.cases) != cases.end()) continue;
            cases.push_back(wait.cases);
            edges.push_back({static_cast<uint32_t>(wait.from), static_cast<uint32_t>(wait.to), wait.cases});
        }
        return edges;
    }

  private:
    void error(const PortUse& use, std::string message) {
        diagnostics_.add(use.bound->place, use.path, std::move(message));
    }

    void check_single_writer(uint32_t id, const ResourceUse& use) {
        const std::string& name = use.name;
        for (size_t i = 0; i < use.writers.size(); ++i) {
            if (use.host)
                error(use.writers[i], fmt::format("\"{}\" is a host input; a node cannot write it", name));
            // Against the first that it meets: of ten thousand writers each pair would be fifty million
            // errors.
            for (size_t j = 0; j < i; ++j)
                if ((use.writers[i].bound->cases & use.writers[j].bound->cases).any()) {
                    contested_[id] = true;
                    error(
                        use.writers[i],
                        fmt::format(
                            "\"{}\" is also written by {}; two writers of one name need conditions (\"if\") "
                            "that exclude each other",
                            name, use.writers[j].path));
                    break;
                }
        }
    }

    std::optional<uint32_t> with(const PortUse& use) const { return nodes_[use.node].with; }

    // When something is needed and nobody writes it. Who may be left out with an input writes for those that
    // are left out with the same one: `with`.
    std::optional<std::string> missing_writer(const ResourceUse& use, FactCases needed,
                                              std::optional<uint32_t> reader_with) const {
        FactCases left_out;
        std::optional<uint32_t> input;
        for (const PortUse& writer : use.writers) {
            if (needed.none()) return std::nullopt;
            if (!with(writer) || with(writer) == reader_with) {
                needed &= ~writer.bound->cases;
                continue;
            }
            left_out |= writer.bound->cases;
            input = with(writer);
        }
        if (needed.none()) return std::nullopt;
        if (const FactCases may_be_left_out = needed & left_out; may_be_left_out == needed)
            return fmt::format("where the host leaves out \"{}\"", dataflow_.pipeline.inputs[*input].name);
        const std::string facts = describe(needed, *dataflow_.pipeline.domain);
        return facts.empty() ? "with these parameters" : "where " + facts;
    }

    // In which cases its name must be there: an optional one's beside the inputs that want it.
    FactCases needed(const PortUse& reader) const {
        if (!reader.bound->port->optional) return reader.bound->cases;
        FactCases wanted;
        for (const BoundPort* bound : bound_beside(reader)) wanted |= bound->cases;
        return reader.bound->cases & wanted;
    }

    std::string beside(const PortUse& reader) const {
        const auto bound = bound_beside(reader);
        return bound.empty() ? "" : fmt::format(" beside \"{}\"", bound.front()->port->name);
    }

    // Of the inputs that want it those that are bound.
    std::vector<const BoundPort*> bound_beside(const PortUse& reader) const {
        std::vector<const BoundPort*> beside;
        for (const uint32_t other : reader.bound->port->with)
            if (const BoundPort& bound = nodes_[reader.node].ports[other]; bound.resource != no_resource)
                beside.push_back(&bound);
        return beside;
    }

    // Whether the reader is left out where the input is.
    bool stands_with(const PortUse& reader, const HostInput& input) const {
        const auto i = with(reader);
        return i && dataflow_.pipeline.inputs[*i].name == input.name;
    }

    void check_presence(const std::string& name, const ResourceUse& use) {
        for (const PortUse& reader : use.readers) {
            const FactCases cases = needed(reader);
            if (reader.bound->port->optional && cases.none()) continue;
            if (use.host) {
                if (use.host->optional && !stands_with(reader, *use.host))
                    error(
                        reader,
                        fmt::format("the host may leave out \"{}\" (\"optional\": true), but the port is not "
                                    "optional{}",
                                    name, beside(reader)));
                continue;
            }
            if (use.writers.empty()) continue;  // reported where the name was looked up
            if (const auto when = missing_writer(use, cases, with(reader)))
                error(reader, fmt::format("nobody writes \"{}\" {}, and the port is not optional{}", name,
                                          *when, beside(reader)));
        }
    }

    // Names that take over the memory of this one, which must then be read before them and cannot outlive the
    // frame.
    void check_updates(uint32_t id, const ResourceUse& use) {
        const std::string& name = use.name;
        const std::vector<const PortUse*>& updaters = updaters_[id];
        for (size_t i = 0; i < updaters.size(); ++i) {
            const PortUse& updater = *updaters[i];
            const BoundPort& updated = *dataflow_.updated(updater);
            if (use.host)
                error(updater, fmt::format("\"{}\" is a host input, which cannot be updated", name));
            if (is_kept(use))
                error(updater, fmt::format("\"{}\" is kept for the next frame and cannot be updated", name));
            if (updated.previous)
                error(updater,
                      fmt::format("\"{}@-1\" is the previous frame's value, which cannot be updated", name));
            const auto rival = std::find_if(
                updaters.begin(), updaters.begin() + i,
                [&](const PortUse* other) { return (updater.bound->cases & other->bound->cases).any(); });
            if (rival != updaters.begin() + i) {
                contested_[id] = true;
                error(updater, fmt::format("\"{}\" is also updated by {}; a name has one updater", name,
                                           (*rival)->path));
                continue;  // what follows has been said of the rival
            }
            const std::string new_name = dataflow_.resources[updater.bound->resource].name;
            for (const PortUse& reader : use.readers)
                if (reader.bound->previous && !updated.previous && !use.host &&
                    (reader.bound->cases & updater.bound->cases).any())
                    error(reader,
                          fmt::format("\"{}\" does not last to the next frame: {} updates it to \"{}\"; read "
                                      "\"{}@-1\"",
                                      name, updater.path, new_name, last_of_chain(updater.bound->resource)));
            const auto output = outputs_.find(name);
            if (output != outputs_.end() && !updated.previous && updater.bound->cases.any())
                diagnostics_.add(
                    output->second->place, output_path(*output->second),
                    fmt::format("\"{}\" does not last to the end of the frame: {} updates it to \"{}\"", name,
                                updater.path, new_name));
        }
    }

    const std::string& last_of_chain(uint32_t id) const {
        for (size_t steps = 0; steps < updaters_.size() && !updaters_[id].empty(); ++steps)
            id = updaters_[id].front()->bound->resource;
        return dataflow_.resources[id].name;
    }

    std::string output_path(const OutputName& output) const {
        return fmt::format("outputs[{}]", &output - dataflow_.source.outputs.data());
    }

    void check_outputs() {
        for (const OutputName& output : dataflow_.source.outputs) {
            const ResourceUse* found = dataflow_.find(output.name);
            if (!found || found->host || found->writers.empty())
                continue;  // reported where the name was looked up
            if (const auto when = missing_writer(*found, all_cases(), std::nullopt))
                diagnostics_.add(output.place, output_path(output),
                                 fmt::format("nobody writes \"{}\" {}", output.name, *when));
        }
    }

    // `from` is needed for `to` in these cases: of nodes or of resources.
    struct Wait {
        size_t from, to;
        FactCases cases;     // both ends exist
        const PortUse* why;  // the port that asks for it
    };

    bool updates(size_t node, uint32_t id) const {
        return std::ranges::any_of(updaters_[id],
                                   [&](const PortUse* updater) { return updater->node == node; });
    }

    // Within a frame: a writer comes before its readers, other readers of a name before its updater.
    std::vector<Wait> order_within_frame() const {
        std::vector<Wait> waits;
        const auto add = [&](const PortUse& first, const PortUse& second, const PortUse& why) {
            const FactCases both = first.bound->cases & second.bound->cases;
            if (both.any()) waits.push_back({first.node, second.node, both, &why});
        };
        for (const uint32_t id : dataflow_.by_name) {
            const ResourceUse& use = dataflow_.resources[id];
            // Of ten thousand that are one too many, and ten thousand readers, all waits would fill the
            // memory.
            const size_t most = contested_[id] ? 1 : ~size_t{0};
            const auto writers = std::span(use.writers).first(std::min(most, use.writers.size()));
            const auto updaters = std::span(updaters_[id]).first(std::min(most, updaters_[id].size()));
            for (const PortUse& reader : use.readers) {
                if (reader.bound->previous) continue;
                for (const PortUse& writer : writers) add(writer, reader, reader);
                if (updates(reader.node, id)) continue;  // a second updater is an error of its own
                for (const PortUse* updater : updaters) add(reader, *updater, *updater);
            }
        }
        return waits;
    }

    // A resource takes its extent from the one behind the port that its rule names, of whatever frame.
    std::vector<Wait> sizes() const {
        std::vector<Wait> waits;
        for (size_t id = 0; id < dataflow_.resources.size(); ++id)
            for (const PortUse& writer : dataflow_.resources[id].writers) {
                const Port& port = *writer.bound->port;
                if (port.updated_input) continue;
                for (const SizeOf* size :
                     {port.kind == PortKind::buffer ? &port.count.of : &port.extent.of, &port.layers_of}) {
                    if (!size->port) continue;
                    const BoundPort& source = nodes_[writer.node].ports[*size->port];
                    const FactCases both = writer.bound->cases & source.cases;
                    if (source.resource != no_resource && both.any())
                        waits.push_back({first_of_chain(source.resource), id, both, &writer});
                }
            }
        return waits;
    }

    // The name that made the memory that this one has taken over.
    uint32_t first_of_chain(uint32_t id) const {
        for (size_t steps = 0; steps < dataflow_.resources.size(); ++steps) {
            const std::vector<PortUse>& writers = dataflow_.resources[id].writers;
            const BoundPort* updated = writers.empty() ? nullptr : dataflow_.updated(writers.front());
            if (!updated || updated->resource == no_resource) break;
            id = updated->resource;
        }
        return id;
    }

    void check_cycles(const std::vector<Wait>& all, bool of_nodes, const char* what) {
        const size_t count = of_nodes ? nodes_.size() : dataflow_.resources.size();
        std::set<std::vector<bool>> seen;        // which waits exist together
        std::set<std::vector<size_t>> reported;  // each cycle's members, sorted
        for (size_t c = size_t{1} << dataflow_.pipeline.domain->facts.size(); c-- > 0;) {
            std::vector<bool> exists;
            for (const Wait& wait : all) exists.push_back(wait.cases[c]);
            if (!seen.insert(exists).second) continue;
            std::vector<std::vector<const Wait*>> next(count);
            for (size_t i = 0; i < all.size(); ++i)
                if (exists[i]) next[all[i].from].push_back(&all[i]);
            std::vector<bool> done = in_no_cycle(next);
            for (size_t start = 0; start < count && reported.size() < most_cycles; ++start) {
                if (done[start]) continue;
                const std::vector<const Wait*> cycle = shortest_cycle(next, start);
                if (cycle.empty()) continue;
                std::vector<size_t> members;
                for (const Wait* wait : cycle) members.push_back(wait->from);
                for (const size_t member : members) done[member] = true;
                std::ranges::sort(members);
                if (!reported.insert(members).second) continue;
                std::string path;
                for (const Wait* wait : cycle) path += name_of(wait->from, of_nodes) + " -> ";
                error(*cycle.back()->why,
                      fmt::format("{}: {}{}", what, path, name_of(cycle.front()->from, of_nodes)));
            }
        }
    }

    // Each takes a walk through everything that hangs together with it, and nobody mends more at a time.
    static constexpr size_t most_cycles = 100;

    const std::string& name_of(size_t member, bool of_nodes) const {
        return of_nodes ? nodes_[member].id : dataflow_.resources[member].name;
    }

    // Nodes that can run in some order (Kahn 1962); what remains lies on a cycle or waits for one.
    static std::vector<bool> in_no_cycle(const std::vector<std::vector<const Wait*>>& next) {
        std::vector<size_t> waits_for(next.size()), ready;
        for (const auto& outgoing : next)
            for (const Wait* edge : outgoing) ++waits_for[edge->to];
        for (size_t node = 0; node < next.size(); ++node)
            if (waits_for[node] == 0) ready.push_back(node);
        for (size_t i = 0; i < ready.size(); ++i)
            for (const Wait* edge : next[ready[i]])
                if (--waits_for[edge->to] == 0) ready.push_back(edge->to);
        std::vector<bool> sorted(next.size());
        for (const size_t node : ready) sorted[node] = true;
        return sorted;
    }

    // Breadth first from `start` back to it; empty if there is no way.
    static std::vector<const Wait*> shortest_cycle(const std::vector<std::vector<const Wait*>>& next,
                                                   size_t start) {
        std::vector<const Wait*> arrived(next.size());
        std::vector<size_t> queue = {start};
        for (size_t i = 0; i < queue.size(); ++i) {
            for (const Wait* edge : next[queue[i]]) {
                if (arrived[edge->to]) continue;
                arrived[edge->to] = edge;
                queue.push_back(edge->to);
            }
        }
        std::vector<const Wait*> cycle;
        if (!arrived[start]) return cycle;
        for (const Wait* edge = arrived[start];; edge = arrived[edge->from]) {
            cycle.push_back(edge);
            if (edge->from == start) break;
        }
        std::ranges::reverse(cycle);
        return cycle;
    }

    const Dataflow& dataflow_;
    const std::vector<BoundNode>& nodes_;
    Diagnostics& diagnostics_;
    std::vector<std::vector<const PortUse*>> updaters_;  // by resource: who takes over its memory
    std::vector<bool> contested_;  // by resource: more write or update it than may, which has been said
    std::map<std::string_view, const OutputName*> outputs_;
};

}  // namespace

std::vector<Edge> check_dataflow(const Dataflow& dataflow, Diagnostics& diagnostics) {
    return DataflowChecker(dataflow, diagnostics).run();
}

}  // namespace penumbra
