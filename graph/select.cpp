// SPDX-License-Identifier: MIT
// Conditions choose the producers, reachability from the outputs (through @-1 too) does the rest. The order
// is the dataflow's; among nodes that are ready the file's order decides, so that a plan reads like its
// pipeline. Nodes without outputs watch: they follow what they read and decide nothing.
#include "graph/select.h"

#include <algorithm>
#include <map>
#include <set>

namespace penumbra {
namespace {

class Selector {
  public:
    Selector(const CheckedPipeline& pipeline, const NodeSet& nodes, const Facts& facts,
             const std::set<std::string>& left_out, Diagnostics& diagnostics)
        : pipeline_(pipeline), nodes_(nodes), facts_(facts), left_out_(left_out), diagnostics_(diagnostics) {}

    std::optional<Selection> run(const std::vector<std::string>& captures) {
        const size_t errors = diagnostics_.size();
        for (const BoundNode& node : pipeline_.nodes) consider(node);
        add_history_copies();
        for (Candidate& candidate : candidates_) connect(candidate);
        for (const std::string& name : captures) add_capture(name);
        mark_needed();
        if (diagnostics_.size() != errors) return std::nullopt;
        drop_unneeded();
        return order();
    }

  private:
    struct Candidate {
        SelectedNode selected;
        bool needed = false;
        bool is_copy = false;
    };

    bool exists(const BoundNode& node, const Port& port) const {
        return holds(port.condition, facts_, node.params);
    }

    void consider(const BoundNode& node) {
        if (!contains(node.cases, facts_)) {
            if (!node.added) selection_.culled.push_back({node.id, "if", node.condition});
            return;
        }
        add(node, false);
    }

    void add(const BoundNode& node, bool is_copy) {
        const size_t index = candidates_.size();
        candidates_.push_back({{&node, {}, {}}, false, is_copy});
        for (const BoundPort& port : node.ports)
            if (port.port->output && exists(node, *port.port) && !port.resource.empty())
                producer_[port.resource] = index;
    }

    // Nothing where the host leaves an optional input out.
    const HostInput* host_input(const std::string& name) const {
        for (const HostInput& input : pipeline_.inputs)
            if (input.name == name && !(input.optional && left_out_.contains(name))) return &input;
        return nullptr;
    }

    // A host input with `history: copy` that somebody reads at @-1 gets a node that keeps its value.
    void add_history_copies() {
        std::set<std::string> wanted;
        for (const Candidate& candidate : candidates_)
            for (const BoundPort& port : candidate.selected.node->ports)
                if (port.previous && exists(*candidate.selected.node, *port.port)) {
                    const HostInput* input = host_input(port.resource);
                    if (input && input->history == HostInput::History::copy) wanted.insert(port.resource);
                }
        for (const std::string& name : wanted) {
            const NodeEntry* copy = nodes_.find("copy");
            if (!copy || !copy->type.port("source") || !copy->type.port("copied")) {
                diagnostics_.add({pipeline_.file}, "inputs." + name + ".history",
                                 "\"copy\" needs a node type \"copy\" with ports \"source\" and \"copied\"");
                continue;
            }
            BoundNode& node = selection_.made.emplace_back();
            node.id = kept_copy(name);
            node.type = &copy->type;
            for (const Param& param : copy->type.params) node.params[param.name] = param.default_value;
            for (const Port& port : copy->type.ports)
                node.ports.push_back({&port, port.output ? kept_copy(name) : name, false, {pipeline_.file}});
            add(node, true);
        }
    }

    void connect(Candidate& candidate) {
        for (const BoundPort& bound : candidate.selected.node->ports)
            candidate.selected.ports.push_back(connection(*candidate.selected.node, bound));
    }

    Connection connection(const BoundNode& node, const BoundPort& bound) {
        Connection c{&bound, Source::none, bound.resource, bound.previous};
        if (bound.resource.empty() || !exists(node, *bound.port)) return c;
        if (producer_.contains(bound.resource)) {
            c.source = Source::internal;
            return c;
        }
        const HostInput* input = host_input(bound.resource);
        if (!input || bound.port->output) return c;
        if (bound.previous && input->history == HostInput::History::copy) {
            c.source = Source::internal;
            c.resource = kept_copy(bound.resource);
        } else {
            c.source = Source::host;
            if (bound.previous) c.resource += "@-1";
        }
        return c;
    }

    void add_capture(const std::string& name) {
        if (!producer_.contains(name)) {
            std::vector<std::string> known;
            for (const auto& [resource, index] : producer_) known.push_back(resource);
            diagnostics_.add({}, "capture",
                             "no node of this plan writes \"" + name + "\"" + did_you_mean(name, known));
            return;
        }
        candidates_.push_back({{nullptr, name, {{nullptr, Source::internal, name, false}}}, true, false});
    }

    void mark_needed() {
        std::vector<size_t> queue;
        const auto need = [&](const std::string& name) {
            const auto found = producer_.find(name);
            if (found == producer_.end() || candidates_[found->second].needed) return;
            candidates_[found->second].needed = true;
            queue.push_back(found->second);
        };
        for (const std::string& output : pipeline_.outputs) need(output);
        for (const Candidate& candidate : candidates_)
            if (!candidate.selected.node) need(candidate.selected.capture);
        while (!queue.empty()) {
            const size_t index = queue.back();
            queue.pop_back();
            for (const Connection& c : candidates_[index].selected.ports)
                if (c.source == Source::internal && !c.bound->port->output) need(c.resource);
        }
    }

    void drop_unneeded() {
        keep([](const Candidate& candidate) { return candidate.needed || watches(candidate); });
        drop_unread_optional_outputs();
        index_producers();
        const std::set<std::string> host_slots = read_host_slots();
        keep([&](const Candidate& candidate) {
            return !watches(candidate) || has_something_to_watch(candidate, host_slots);
        });
        index_producers();
    }

    template <class Wanted>
    void keep(Wanted&& wanted) {
        std::vector<Candidate> kept;
        for (Candidate& candidate : candidates_)
            if (wanted(candidate))
                kept.push_back(std::move(candidate));
            else if (!candidate.is_copy && !candidate.selected.node->added)
                selection_.culled.push_back({candidate.selected.node->id, "unused", ""});
        candidates_ = std::move(kept);
    }

    void index_producers() {
        producer_.clear();
        for (size_t i = 0; i < candidates_.size(); ++i)
            for (const Connection& c : candidates_[i].selected.ports)
                if (c.bound && c.bound->port->output && c.source == Source::internal)
                    producer_[c.resource] = i;
    }

    static bool watches(const Candidate& candidate) {
        return candidate.selected.node && candidate.selected.node->type->watches();
    }

    std::set<std::string> read_host_slots() const {
        std::set<std::string> slots;
        for (const Candidate& candidate : candidates_)
            for (const Connection& c : candidate.selected.ports)
                if (c.source == Source::host && !watches(candidate)) slots.insert(c.resource);
        return slots;
    }

    // A watcher changes nothing about what else runs, so all that it reads must be there without it.
    bool has_something_to_watch(const Candidate& candidate, const std::set<std::string>& host_slots) const {
        bool something = false;
        for (const Connection& c : candidate.selected.ports) {
            if (c.bound->resource.empty() || !exists(*candidate.selected.node, *c.bound->port)) continue;
            something = c.source == Source::host       ? host_slots.contains(c.resource)
                        : c.source == Source::internal ? producer_.contains(c.resource)
                                                       : false;
            if (!something) return false;
        }
        return something;
    }

    // An optional output that nobody asks for does not exist: it costs no memory and no store.
    void drop_unread_optional_outputs() {
        std::set<std::string> read(pipeline_.outputs.begin(), pipeline_.outputs.end());
        for (const Candidate& candidate : candidates_)
            for (const Connection& c : candidate.selected.ports)
                if (c.source == Source::internal && (!c.bound || !c.bound->port->output) &&
                    !watches(candidate))
                    read.insert(c.resource);
        for (Candidate& candidate : candidates_)
            for (Connection& c : candidate.selected.ports)
                if (c.bound && c.bound->port->output && c.bound->port->optional && !read.contains(c.resource))
                    c.source = Source::none;
    }

    // Edges first -> second of the frame's order.
    std::vector<std::set<size_t>> successors() const {
        std::vector<std::set<size_t>> edges(candidates_.size());
        const auto edge = [&](size_t from, size_t to) {
            if (from != to) edges[from].insert(to);
        };
        std::map<std::string, size_t> updater;  // name -> the node that turns it into the next name
        for (size_t i = 0; i < candidates_.size(); ++i)
            for (const Connection& c : candidates_[i].selected.ports)
                if (c.bound && c.source == Source::internal && c.bound->port->output &&
                    !c.bound->port->updates.empty())
                    for (const Connection& in : candidates_[i].selected.ports)
                        if (in.bound->port->name == c.bound->port->updates) updater[in.resource] = i;
        for (size_t i = 0; i < candidates_.size(); ++i)
            for (const Connection& c : candidates_[i].selected.ports) {
                if (c.bound && c.bound->port->output) continue;
                if (c.previous) {
                    keep_after_reader(i, c, edge);
                    continue;
                }
                if (c.source != Source::internal) continue;
                edge(producer_.at(c.resource), i);
                if (const auto next = updater.find(c.resource); next != updater.end()) edge(i, next->second);
            }
        return edges;
    }

    // A kept copy is taken after the last reader of the kept value, so that the two placements hardly
    // overlap.
    template <class Edge>
    void keep_after_reader(size_t reader, const Connection& c, Edge&& edge) const {
        const auto writer = producer_.find(c.resource);
        if (writer != producer_.end() && candidates_[writer->second].is_copy) edge(reader, writer->second);
    }

    Selection order() {
        const std::vector<std::set<size_t>> edges = successors();
        std::vector<size_t> waiting(candidates_.size(), 0);
        for (const auto& targets : edges)
            for (const size_t to : targets) ++waiting[to];
        std::set<size_t> ready;
        for (size_t i = 0; i < waiting.size(); ++i)
            if (waiting[i] == 0) ready.insert(i);
        while (!ready.empty()) {
            const size_t i = *ready.begin();
            ready.erase(ready.begin());
            for (const size_t to : edges[i])
                if (--waiting[to] == 0) ready.insert(to);
            selection_.nodes.push_back(std::move(candidates_[i].selected));
        }
        return std::move(selection_);
    }

    const CheckedPipeline& pipeline_;
    const NodeSet& nodes_;
    const Facts& facts_;
    const std::set<std::string>& left_out_;
    Diagnostics& diagnostics_;
    Selection selection_;
    std::vector<Candidate> candidates_;
    std::map<std::string, size_t> producer_;
};

}  // namespace

std::string kept_copy(const std::string& input) {
    return input + "@copy";
}

std::optional<Selection> select(const CheckedPipeline& pipeline, const NodeSet& nodes, const Facts& facts,
                                const std::set<std::string>& left_out,
                                const std::vector<std::string>& captures, Diagnostics& diagnostics) {
    return Selector(pipeline, nodes, facts, left_out, diagnostics).run(captures);
}

}  // namespace penumbra
