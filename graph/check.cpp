// SPDX-License-Identifier: MIT
// Resolves a pipeline's names against a node set: types, parameters, ports, resources. Whether both ends of a
// wire fit is check_wires.cpp's part, what conditions come to check_conditions.cpp's, what depends on facts
// and on order check_dataflow.cpp's.
#include "penumbra/check.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/check_conditions.h"
#include "graph/check_dataflow.h"
#include "graph/instances.h"
#include "graph/json_reader.h"
#include "graph/suggestions.h"
#include "penumbra/plan.h"

namespace penumbra {

namespace {

class Checker {
  public:
    Checker(const Pipeline& pipeline, const NodeSet& set, Diagnostics& diagnostics)
        : errors_(diagnostics.size()),
          written_out_(write_out_instances(pipeline, set, diagnostics)),
          set_(set),
          diagnostics_(diagnostics) {}

    std::optional<CheckedPipeline> run() {
        result_.name = pipeline_.name;
        result_.doc = pipeline_.doc;
        result_.file = pipeline_.file;
        result_.domain = set_.domain();
        result_.inputs = pipeline_.inputs;
        for (HostInput& input : result_.inputs) find_kind(input);
        for (const PipelineNode& node : pipeline_.nodes) find_type(node);
        settle_conditions(result_, sources_, written_out_, nodes_by_id_, diagnostics_);
        bind_outputs();
        bind_inputs();
        for (const auto& [name, id] : ids_) flow_.by_name.push_back(id);
        flow_.ids = &ids_;
        for (const uint32_t id : flow_.by_name)
            for (const PortUse& reader : flow_.resources[id].readers) check_name(flow_.resources[id], reader);
        check_settings();
        check_outputs();
        check_wires(flow_, result_.inputs, result_.resources, diagnostics_);
        result_.edges = check_dataflow(flow_, diagnostics_);
        if (diagnostics_.size() != errors_) return std::nullopt;
        return std::move(result_);
    }

  private:
    void error(const Place& place, std::string path, std::string message) {
        diagnostics_.add(place, std::move(path), std::move(message));
    }
    void error(const PortUse& use, std::string message) {
        error(use.bound->place, use.path, std::move(message));
    }

    uint32_t id_of(const std::string& name) {
        const auto [at, added] = ids_.try_emplace(name, static_cast<uint32_t>(ids_.size()));
        if (added) {
            result_.resources.push_back({.name = name});
            flow_.resources.push_back({.name = name});
        }
        return at->second;
    }
    const ResourceUse* find_use(const std::string& name) const {
        const auto found = ids_.find(name);
        return found == ids_.end() ? nullptr : &flow_.resources[found->second];
    }

    void find_kind(HostInput& input) {
        const std::string path = "inputs." + input.name;
        if (input.kind_word.empty()) return;
        const std::vector<std::string> words = kind_words(*result_.domain);
        const auto found = std::ranges::find(words, input.kind_word) - words.begin();
        constexpr auto bundles = static_cast<std::ptrdiff_t>(PortKind::bundle);
        if (found < std::ssize(words)) input.kind = static_cast<PortKind>(std::min(found, bundles));
        if (input.kind == PortKind::bundle)
            input.bundle = &result_.domain->bundles[static_cast<size_t>(found - bundles)];
        if (!input.kind)
            return error(input.kind_place, path + ".kind",
                         fmt::format("no value \"{}\" (values: {}){}", input.kind_word, join(words),
                                     did_you_mean(input.kind_word, words)));
        const auto refuse = [&](const char* key, const std::optional<Place>& place) {
            if (place && !vocabulary::input.find(key, {.kinds = bit(*input.kind)}))
                error(*place, path + "." + key, "does not apply to kind " + input.kind_word);
        };
        refuse("format", input.format_place);
        refuse("extent", input.extent_place);
    }

    void find_type(const PipelineNode& node) {
        const std::string path = "nodes." + node.id;
        std::shared_ptr<const NodeEntry> entry = set_.share(node.type);
        auto& bound_as = nodes_by_id_[node.id];
        if (!entry) {
            error(node.type_place, path + ".type",
                  fmt::format("no node type \"{}\"{}", node.type, did_you_mean(node.type, set_.names())));
            unknown_type_ = true;
            return;
        }
        BoundNode bound{.id = node.id, .entry = entry, .place = node.place};
        const auto number = static_cast<size_t>(&node - pipeline_.nodes.data());
        if (const auto* of = written_out_.of[number]) {
            bound.family = of->family;
            bound.member = of->name;
            bound.hands_on = written_out_.hands_on[number];
        }
        bind_params(node, bound);
        find_with(node, bound);
        check_ports(node, entry->type, node.in, false);
        check_ports(node, entry->type, node.out, true);
        for (const Port& port : entry->type.ports)
            bound.ports.push_back({.port = &port, .place = node.place});
        bound_as = result_.nodes.size();
        result_.nodes.push_back(std::move(bound));
        sources_.push_back(&node);
    }

    void bind_params(const PipelineNode& node, BoundNode& bound) {
        std::vector<std::string> names;
        for (const Param& param : bound.type().params) {
            names.push_back(param.name);
            bound.params.push_back(param.default_value);
            bound.set.push_back(false);
        }
        for (const JsonMember& member : node.params) {
            const std::string path = fmt::format("nodes.{}.params.{}", node.id, member.key);
            const auto name = std::ranges::find(names, member.key);
            if (name == names.end()) {
                error(member.key_place, path,
                      fmt::format("node type \"{}\" has no parameter \"{}\"{}", node.type, member.key,
                                  did_you_mean(member.key, names)));
                continue;
            }
            const auto i = static_cast<size_t>(name - names.begin());
            bound.set[i] = true;
            if (const auto value =
                    parse_param_value(bound.type().params[i], member.value, path, diagnostics_))
                bound.params[i] = *value;
        }
    }

    void find_with(const PipelineNode& node, BoundNode& bound) {
        if (node.with.empty()) return;
        const std::string path = "nodes." + node.id + ".with";
        const auto input = std::ranges::find(result_.inputs, node.with, &HostInput::name);
        if (input == result_.inputs.end())
            return error(node.with_place, path,
                         fmt::format("no input \"{}\"{}", node.with, nearest_optional(node.with)));
        bound.with = static_cast<uint32_t>(input - result_.inputs.begin());
        if (!input->optional)
            error(node.with_place, path,
                  fmt::format("the host never leaves out \"{}\": give the input \"optional\": true",
                              node.with));
    }

    std::string nearest_optional(const std::string& name) {
        if (!near_optional_) {
            std::vector<std::string> names;
            for (const HostInput& input : result_.inputs)
                if (input.optional) names.push_back(input.name);
            near_optional_.emplace(std::move(names));
        }
        return near_optional_->nearest(name);
    }

    void check_ports(const PipelineNode& node, const NodeType& type, const std::vector<Wire>& wires,
                     bool output) {
        std::vector<std::string> names;
        for (const Port& port : type.ports)
            if (port.output == output) names.push_back(port.name);
        for (const Wire& wire : wires) {
            const std::string path = fmt::format("nodes.{}.{}.{}", node.id, output ? "out" : "in", wire.port);
            const Port* port = type.port(wire.port);
            if (port && port->output == output) continue;
            error(wire.port_place, path,
                  port ? fmt::format("\"{}\" is an {}; wire it in \"{}\"", wire.port,
                                     output ? "input" : "output", output ? "in" : "out")
                       : fmt::format("node type \"{}\" has no {} \"{}\"{}", node.type,
                                     output ? "output" : "input", wire.port, did_you_mean(wire.port, names)));
        }
    }

    static const Wire* wire_of(const PipelineNode& node, const Port& port) {
        const std::vector<Wire>& wires = port.output ? node.out : node.in;
        const auto found = std::ranges::find(wires, port.name, &Wire::port);
        return found == wires.end() ? nullptr : &*found;
    }

    PortUse use_of(size_t node, const BoundPort& bound) const {
        return {node, &bound,
                fmt::format("nodes.{}.{}.{}", result_.nodes[node].id, bound.port->output ? "out" : "in",
                            bound.port->name)};
    }

    // Every port that its node's parameters and facts do not rule out. A node that runs under no facts is
    // checked all the same.
    template <typename Visit>
    void each_port(bool outputs, Visit visit) {
        for (size_t i = 0; i < result_.nodes.size(); ++i)
            for (BoundPort& bound : result_.nodes[i].ports) {
                const FactCases both = bound.cases & result_.nodes[i].cases;
                const bool ruled_out = bound.cases.none() || (both.none() && result_.nodes[i].cases.any());
                if (bound.port->output == outputs && !ruled_out)
                    visit(i, bound, wire_of(*sources_[i], *bound.port));
            }
    }

    // Of a node, which of the pipeline's it is.
    size_t written(size_t node) const { return static_cast<size_t>(sources_[node] - pipeline_.nodes.data()); }

    // What a port is called: as it is wired, else by its own name.
    std::string name_at(size_t node, const BoundPort& bound, const Wire* wire) const {
        return wire ? wire->resource : written_out_.name(written(node), bound.port->name);
    }

    // The names that inputs and the pipeline's outputs ask for: an optional output exists if its name is
    // among them.
    std::map<std::string, std::vector<size_t>> wanted_names() {
        std::map<std::string, std::vector<size_t>> wanted;  // name -> asking nodes
        for (const OutputName& output : pipeline_.outputs)
            wanted[output.name].push_back(result_.nodes.size());
        each_port(false, [&](size_t node, const BoundPort& bound, const Wire* wire) {
            wanted[name_at(node, bound, wire)].push_back(node);
        });
        return wanted;
    }

    void bind_outputs() {
        for (uint32_t i = 0; i < result_.inputs.size(); ++i) {
            const uint32_t id = id_of(result_.inputs[i].name);
            result_.resources[id].input = i;
            flow_.resources[id].host = &result_.inputs[i];
        }
        const auto wanted = wanted_names();
        const auto asked_by_another = [&](const std::string& name, size_t node) {
            const auto found = wanted.find(name);
            return found != wanted.end() &&
                   std::ranges::any_of(found->second, [&](size_t n) { return n != node; });
        };
        each_port(true, [&](size_t node, BoundPort& bound, const Wire* wire) {
            if (wire) bound.place = wire->place;
            std::string name = name_at(node, bound, wire);
            if (!wire && bound.port->optional && !asked_by_another(name, node)) name.clear();
            if (name.empty()) {
                if (!bound.port->optional)
                    error(use_of(node, bound), "only an optional port may be unbound (null)");
                return;
            }
            bound.resource = id_of(name);
            flow_.resources[bound.resource].writers.push_back(use_of(node, bound));
        });
    }

    void bind_inputs() {
        each_port(false, [&](size_t node, BoundPort& bound, const Wire* wire) {
            const Port& port = *bound.port;
            std::string name = name_at(node, bound, wire);
            if (wire) {
                bound.place = wire->place;
                bound.previous = wire->previous;
            } else if (port.previous || (port.optional && !exists_beside(name, node))) {
                name.clear();
            }
            if (!name.empty()) bound.resource = id_of(name);
            const PortUse use = use_of(node, bound);
            const bool unbound = name.empty() && port.optional;
            if (port.previous && !bound.previous && !unbound)
                error(use, "must be wired to the previous frame's value of a name, as in \"NAME@-1\"");
            else if (name.empty() && !port.optional)
                error(use, "only an optional port may be unbound (null)");
            if (!name.empty()) flow_.resources[bound.resource].readers.push_back(use);
        });
        for (BoundNode& node : result_.nodes)
            for (BoundPort& bound : node.ports) bound.cases &= node.cases;
        each_port(false, [&](size_t node, const BoundPort& bound, const Wire*) {
            if (bound.resource != no_resource) return;
            for (const uint32_t other : bound.port->with)
                if (const BoundPort& beside = result_.nodes[node].ports[other];
                    beside.resource != no_resource)
                    error(use_of(node, bound),
                          fmt::format("unbound, and beside \"{}\" the port is not optional",
                                      beside.port->name));
        });
    }

    // Whether somebody else than this node provides the name.
    bool exists_beside(const std::string& name, size_t node) const {
        const ResourceUse* use = find_use(name);
        return use && (use->host || std::ranges::any_of(use->writers, [&](const PortUse& writer) {
                           return writer.node != node;
                       }));
    }

    // Of the names that exist, which are known once everything is bound.
    std::string nearest_name(const std::string& wanted, bool written_only = false) {
        std::optional<Suggestions>& near = written_only ? near_written_ : near_names_;
        if (!near) {
            std::vector<std::string> names;
            for (const auto& [name, id] : ids_) {
                const ResourceUse& use = flow_.resources[id];
                if (!use.writers.empty() || (use.host && !written_only)) names.push_back(name);
            }
            near.emplace(std::move(names));
        }
        return near->nearest(wanted);
    }

    void check_name(const ResourceUse& use, const PortUse& reader) {
        const Port& port = *reader.bound->port;
        if (!use.host && use.writers.empty()) {
            if (unknown_type_) return;  // the node of unknown type may well write it
            const bool own = !wire_of(*sources_[reader.node], port);
            if (const auto family = written_out_.own_names.find(use.name);
                family != written_out_.own_names.end())
                return error(reader, fmt::format("there is one \"{0}\" for each of \"{1}\": \"{0}_INSTANCE\"",
                                                 use.name, family->second));
            error(reader, fmt::format("no resource named \"{}\"{}{}", use.name,
                                      own ? " (the port's own name)" : "", nearest_name(use.name)));
            return;
        }
        const Dispatch& dispatch = result_.nodes[reader.node].type().dispatch;
        if (dispatch.kind == Dispatch::Kind::indirect && port.name == dispatch.indirect &&
            (use.host || reader.bound->previous))
            error(reader, "dispatch arguments must be written by a node of the same frame");
        if (!reader.bound->previous) return;
        if (port.kind == PortKind::block || port.bundle)
            error(reader, fmt::format("a {} has no previous value", kind_word(port)));
        else if (use.host && !use.host->history)
            error(reader, fmt::format("\"{}\" is a host input without history; give it \"history\": \"host\"",
                                      use.name));
        else if (is_kept(use))
            error(reader, fmt::format("\"{}\" is kept in place, so its previous value is gone", use.name));
    }

    static const char* kind_word(const Port& port) {
        return port.bundle ? port.bundle->kind.c_str() : kind_name(port.kind);
    }

    void check_settings() {
        for (const ResourceSetting& setting : pipeline_.resources) {
            const ResourceUse* use = find_use(setting.name);
            if (use && use->host)
                error(setting.place, "resources." + setting.name,
                      "a host input; its format is set in \"inputs\"");
            else if ((!use || use->writers.empty()) && !unknown_type_)
                error(setting.place, "resources." + setting.name,
                      fmt::format("no node writes \"{}\"{}", setting.name, nearest_name(setting.name, true)));
            else if (use)
                result_.resources[ids_.at(setting.name)].first = setting.first;
        }
    }

    void check_outputs() {
        for (size_t i = 0; i < pipeline_.outputs.size(); ++i) {
            const OutputName& output = pipeline_.outputs[i];
            const std::string path = fmt::format("outputs[{}]", i);
            const ResourceUse* use = find_use(output.name);
            if (use && use->host)
                error(output.place, path,
                      fmt::format("\"{}\" is a host input; an output is written by a node", output.name));
            else if ((!use || use->writers.empty()) && !unknown_type_)
                error(output.place, path,
                      fmt::format("no node writes \"{}\"{}", output.name, nearest_name(output.name, true)));
            result_.outputs.push_back(use ? ids_.at(output.name) : no_resource);
        }
    }

    const size_t errors_;  // that there were before
    const WrittenOut written_out_;
    const Pipeline& pipeline_ = written_out_.pipeline;
    const NodeSet& set_;
    Diagnostics& diagnostics_;
    CheckedPipeline result_;
    std::vector<const PipelineNode*> sources_;  // of result_.nodes
    NodesById nodes_by_id_;
    std::map<std::string, uint32_t> ids_;
    std::optional<Suggestions> near_names_, near_written_, near_optional_;
    Dataflow flow_{result_, pipeline_, {}, {}, nullptr};
    bool unknown_type_ = false;
};

}  // namespace

const HostInput* CheckedPipeline::input(std::string_view input_name) const {
    const auto found = std::ranges::find(inputs, input_name, &HostInput::name);
    return found == inputs.end() ? nullptr : &*found;
}

const CheckedResource* CheckedPipeline::resource(std::string_view resource_name) const {
    const auto found = std::ranges::find(resources, resource_name, &CheckedResource::name);
    return found == resources.end() ? nullptr : &*found;
}

std::vector<std::string> CheckedPipeline::output_names() const {
    std::vector<std::string> names;
    for (const uint32_t output : outputs) names.push_back(resources[output].name);
    return names;
}

std::string CheckedPipeline::name_of(const BoundPort& bound) const {
    return resources[bound.resource].name + std::string(bound.previous ? previous_suffix : "");
}

std::optional<CheckedPipeline> check(const Pipeline& pipeline, const NodeSet& nodes,
                                     Diagnostics& diagnostics) {
    return Checker(pipeline, nodes, diagnostics).run();
}

}  // namespace penumbra
