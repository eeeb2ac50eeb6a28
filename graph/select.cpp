// SPDX-License-Identifier: MIT
// Conditions choose the producers, reachability from the outputs (through previous values too) does the rest.
// The order is check()'s edges; among nodes that are ready the file's order decides, so that a plan reads
// like its pipeline, but that a family's members wait for who reads them. Nodes without outputs watch: they
// follow what they read and decide nothing.
#include "graph/select.h"

#include <algorithm>
#include <map>
#include <set>

namespace penumbra {
namespace {

constexpr size_t nobody = ~size_t{0};

class Selector {
  public:
    Selector(const CheckedPipeline& pipeline, size_t facts, const std::vector<bool>& left_out,
             Diagnostics& diagnostics)
        : pipeline_(pipeline), facts_(facts), left_out_(left_out), diagnostics_(diagnostics) {}

    std::optional<Selection> run(const std::vector<std::string>& captures) {
        runs_.resize(pipeline_.nodes.size());
        sources_.resize(pipeline_.nodes.size());
        for (size_t i = 0; i < runs_.size(); ++i) {
            runs_[i] = pipeline_.nodes[i].cases[facts_];
            if (!runs_[i] && !pipeline_.nodes[i].added)
                selection_.culled.push_back({pipeline_.nodes[i].id, "if", pipeline_.nodes[i].condition});
            if (const auto with = pipeline_.nodes[i].with; runs_[i] && with && left_out_[*with]) {
                runs_[i] = false;
                selection_.culled.push_back({pipeline_.nodes[i].id, "with", pipeline_.inputs[*with].name});
            }
        }
        index_producers([](const BoundPort& bound, Source) { return bound.resource != no_resource; });
        for (size_t i = 0; i < runs_.size(); ++i)
            for (const BoundPort& bound : pipeline_.nodes[i].ports) sources_[i].push_back(source_of(bound));
        if (!find_captures(captures)) return std::nullopt;
        keep(needed());
        drop_unread_optional_outputs();
        index_producers([](const BoundPort&, Source source) { return source == Source::internal; });
        keep(with_something_to_watch());
        order();
        return std::move(selection_);
    }

  private:
    bool watches(size_t node) const { return pipeline_.nodes[node].type().watches(); }

    Source source_of(const BoundPort& bound) const {
        if (bound.resource == no_resource || !bound.cases[facts_]) return Source::none;
        if (producer_[bound.resource] != nobody) return Source::internal;
        const std::optional<uint32_t> input = pipeline_.resources[bound.resource].input;
        return input && !left_out_[*input] && !bound.port->output ? Source::host : Source::none;
    }

    template <class Counts>
    void index_producers(Counts&& counts) {
        producer_.assign(pipeline_.resources.size(), nobody);
        for (size_t i = 0; i < runs_.size(); ++i)
            for (size_t p = 0; runs_[i] && p < pipeline_.nodes[i].ports.size(); ++p) {
                const BoundPort& bound = pipeline_.nodes[i].ports[p];
                const Source source = sources_[i].empty() ? Source::none : sources_[i][p];
                if (bound.port->output && bound.cases[facts_] && counts(bound, source))
                    producer_[bound.resource] = i;
            }
    }

    bool find_captures(const std::vector<std::string>& captures) {
        bool good = true;
        for (const std::string& name : captures) {
            const CheckedResource* resource = pipeline_.resource(name);
            const auto id =
                resource ? static_cast<uint32_t>(resource - pipeline_.resources.data()) : no_resource;
            if (resource && producer_[id] != nobody) {
                if (std::ranges::find(captures_, id) == captures_.end()) captures_.push_back(id);
                continue;
            }
            std::vector<std::string> known;
            for (size_t r = 0; r < producer_.size(); ++r)
                if (producer_[r] != nobody) known.push_back(pipeline_.resources[r].name);
            diagnostics_.add({pipeline_.file}, "captures",
                             "no node of this plan writes \"" + name + "\"" + did_you_mean(name, known));
            good = false;
        }
        return good;
    }

    // Whatever the outputs and captures follow from, and watchers.
    std::vector<bool> needed() const {
        std::vector<bool> needed(runs_.size());
        std::vector<size_t> queue;
        const auto need = [&](uint32_t resource) {
            const size_t node = producer_[resource];
            if (node == nobody || needed[node]) return;
            needed[node] = true;
            queue.push_back(node);
        };
        for (const uint32_t output : pipeline_.outputs) need(output);
        for (const uint32_t capture : captures_) need(capture);
        while (!queue.empty()) {
            const size_t node = queue.back();
            queue.pop_back();
            for (size_t p = 0; p < sources_[node].size(); ++p) {
                const BoundPort& bound = pipeline_.nodes[node].ports[p];
                if (sources_[node][p] == Source::internal && !bound.port->output) need(bound.resource);
            }
        }
        for (size_t i = 0; i < runs_.size(); ++i) needed[i] = needed[i] || watches(i);
        return needed;
    }

    void keep(const std::vector<bool>& wanted) {
        for (size_t i = 0; i < runs_.size(); ++i) {
            if (!runs_[i] || wanted[i]) continue;
            runs_[i] = false;
            if (!pipeline_.nodes[i].added) selection_.culled.push_back({pipeline_.nodes[i].id, "unused", ""});
        }
    }

    // Calls `visit` with every input port that is connected, of nodes that run.
    template <class Visit>
    void each_input(Visit&& visit) const {
        for (size_t i = 0; i < runs_.size(); ++i)
            for (size_t p = 0; runs_[i] && p < sources_[i].size(); ++p) {
                const BoundPort& bound = pipeline_.nodes[i].ports[p];
                if (!bound.port->output && sources_[i][p] != Source::none) visit(i, bound, sources_[i][p]);
            }
    }

    // An optional output that nobody asks for does not exist: it costs no memory and no store.
    void drop_unread_optional_outputs() {
        std::vector<bool> read(pipeline_.resources.size());
        for (const uint32_t output : pipeline_.outputs) read[output] = true;
        for (const uint32_t capture : captures_) read[capture] = true;
        each_input([&](size_t node, const BoundPort& bound, Source) {
            if (!watches(node)) read[bound.resource] = true;
        });
        for (size_t i = 0; i < runs_.size(); ++i)
            for (size_t p = 0; p < sources_[i].size(); ++p) {
                const BoundPort& bound = pipeline_.nodes[i].ports[p];
                if (bound.port->output && bound.port->optional && sources_[i][p] == Source::internal &&
                    !read[bound.resource])
                    sources_[i][p] = Source::none;
            }
    }

    // A watcher changes nothing about what else runs, so all that it reads must be there without it.
    std::vector<bool> with_something_to_watch() const {
        std::set<std::pair<uint32_t, bool>> slots;  // that others read
        each_input([&](size_t node, const BoundPort& bound, Source source) {
            if (source == Source::host && !watches(node)) slots.emplace(bound.resource, bound.previous);
        });
        std::vector<bool> wanted(runs_.size(), true);
        for (size_t i = 0; i < runs_.size(); ++i) {
            if (!watches(i)) continue;
            bool any = false, all = true;
            for (size_t p = 0; p < sources_[i].size(); ++p) {
                const BoundPort& bound = pipeline_.nodes[i].ports[p];
                if (bound.resource == no_resource || !bound.cases[facts_]) continue;
                const bool there = sources_[i][p] == Source::host
                                       ? slots.contains({bound.resource, bound.previous})
                                   : sources_[i][p] == Source::internal ? producer_[bound.resource] != nobody
                                                                        : false;
                any = any || there;
                all = all && there;
            }
            wanted[i] = any && all;
        }
        return wanted;
    }

    // Captures come last of what may run, after the writer and before whoever takes the memory over.
    void order() {
        const size_t nodes = runs_.size();
        std::vector<std::set<size_t>> next(nodes + captures_.size());
        for (const Edge& edge : pipeline_.edges)
            if (edge.cases[facts_] && runs_[edge.from] && runs_[edge.to] && edge.from != edge.to)
                next[edge.from].insert(edge.to);
        for (size_t c = 0; c < captures_.size(); ++c) {
            next[producer_[captures_[c]]].insert(nodes + c);
            for (size_t i = 0; i < nodes; ++i)
                for (size_t p = 0; runs_[i] && p < sources_[i].size(); ++p)
                    if (const auto input = pipeline_.nodes[i].ports[p].port->updated_input;
                        input && sources_[i][p] == Source::internal &&
                        pipeline_.nodes[i].ports[*input].resource == captures_[c])
                        next[nodes + c].insert(i);
        }
        std::vector<size_t> waiting(next.size());
        for (const std::set<size_t>& targets : next)
            for (const size_t to : targets) ++waiting[to];
        std::set<size_t> ready;
        for (size_t i = 0; i < waiting.size(); ++i)
            if (waiting[i] == 0 && (i >= nodes || runs_[i])) ready.insert(i);
        std::vector<size_t> sequence;
        while (!ready.empty()) {
            const size_t i = *ready.begin();
            ready.erase(ready.begin());
            for (const size_t to : next[i])
                if (--waiting[to] == 0) ready.insert(to);
            sequence.push_back(i);
        }
        let_members_wait(next, sequence);
        for (const size_t i : sequence)
            if (i < nodes)
                selection_.nodes.push_back({&pipeline_.nodes[i], no_resource, std::move(sources_[i])});
            else
                selection_.nodes.push_back({nullptr, captures_[i - nodes], {}});
    }

    // A family's members do the same in turn. What one of them makes long before it is wanted would lie
    // beside the same of all others, so it is made just before its first reader, where nothing lives longer
    // by that. Watchers look as late as they can, so that the others' order is what it is without them.
    void let_members_wait(const std::vector<std::set<size_t>>& next, std::vector<size_t>& sequence) const {
        std::vector<size_t> place(next.size());  // of who waits, its first reader's
        for (size_t at = 0; at < sequence.size(); ++at) place[sequence[at]] = at;
        std::map<std::pair<uint32_t, bool>, size_t> last_read;
        each_input([&](size_t node, const BoundPort& bound, Source) {
            if (watches(node)) return;
            size_t& last = last_read[{bound.resource, bound.previous}];
            last = std::max(last, place[node]);
        });
        for (auto at = sequence.rbegin(); at != sequence.rend(); ++at) {
            const size_t i = *at;
            if (i >= runs_.size()) continue;
            size_t first = sequence.size();
            for (const size_t to : next[i]) first = std::min(first, place[to]);
            if (watches(i)) place[i] = first;
            if (watches(i) || pipeline_.nodes[i].family.empty() || next[i].empty()) continue;
            bool lives_on = true;
            for (size_t p = 0; p < sources_[i].size(); ++p) {
                const BoundPort& bound = pipeline_.nodes[i].ports[p];
                if (!bound.port->output && sources_[i][p] == Source::internal)
                    lives_on = lives_on && last_read.at({bound.resource, bound.previous}) >= first;
            }
            if (lives_on) place[i] = first;
        }
        std::ranges::stable_sort(sequence, {}, [&](size_t i) { return place[i]; });
    }

    const CheckedPipeline& pipeline_;
    const size_t facts_;
    const std::vector<bool>& left_out_;
    Diagnostics& diagnostics_;
    Selection selection_;
    std::vector<bool> runs_;
    std::vector<std::vector<Source>> sources_;  // by node and port
    std::vector<size_t> producer_;              // by resource
    std::vector<uint32_t> captures_;
};

}  // namespace

std::optional<Selection> select(const CheckedPipeline& pipeline, size_t facts,
                                const std::vector<bool>& left_out, const std::vector<std::string>& captures,
                                Diagnostics& diagnostics) {
    return Selector(pipeline, facts, left_out, diagnostics).run(captures);
}

}  // namespace penumbra
