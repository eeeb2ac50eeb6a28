// SPDX-License-Identifier: MIT
// Resolves a pipeline's names against a node set: types, parameters, ports, resources. Whether both ends of a
// wire fit is check_wires.cpp's part, what depends on facts and on order check_dataflow.cpp's.
#include "graph/check.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/check_dataflow.h"
#include "graph/condition.h"
#include "graph/json_reader.h"
#include "graph/node_set.h"

namespace penumbra {

namespace {

class Checker {
  public:
    Checker(const Pipeline& pipeline, const NodeSet& set, Diagnostics& diagnostics)
        : pipeline_(pipeline), set_(set), diagnostics_(diagnostics) {}

    std::optional<CheckedPipeline> run() {
        const size_t errors = diagnostics_.size();
        result_.name = pipeline_.name;
        result_.doc = pipeline_.doc;
        result_.file = pipeline_.file;
        result_.inputs = pipeline_.inputs;
        result_.resources = pipeline_.resources;
        for (const OutputName& output : pipeline_.outputs) result_.outputs.push_back(output.name);
        for (const PipelineNode& node : pipeline_.nodes) find_type(node);
        settle_conditions();
        bind_outputs();
        bind_inputs();
        for (const auto& [name, use] : flow_.resources)
            for (const PortUse& reader : use.readers) check_name(name, use, reader);
        check_settings();
        check_outputs();
        flow_.outputs = pipeline_.outputs;
        check_wires(flow_, result_.inputs, set_, diagnostics_);
        check_dataflow(flow_, diagnostics_);
        if (diagnostics_.size() != errors) return std::nullopt;
        return std::move(result_);
    }

  private:
    void error(const Place& place, std::string path, std::string message) {
        diagnostics_.add(place, std::move(path), std::move(message));
    }
    void error(const PortUse& use, std::string message) { error(use.place, use.path, std::move(message)); }

    void find_type(const PipelineNode& node) {
        const std::string path = "nodes." + node.id;
        const NodeEntry* entry = set_.find(node.type);
        if (!entry) {
            error(node.type_place, path + ".type",
                  fmt::format("no node type \"{}\"{}", node.type, did_you_mean(node.type, set_.names())));
            unknown_type_ = true;
            return;
        }
        BoundNode bound{
            .id = node.id, .type = &entry->type, .condition = to_string(node.condition), .place = node.place};
        bind_params(node, bound);
        check_ports(node, entry->type, node.in, false);
        check_ports(node, entry->type, node.out, true);
        for (const Port& port : entry->type.ports)
            bound.ports.push_back({.port = &port, .place = node.place});
        result_.nodes.push_back(std::move(bound));
        sources_.push_back(&node);
    }

    void bind_params(const PipelineNode& node, BoundNode& bound) {
        std::vector<std::string> names;
        for (const Param& param : bound.type->params) {
            names.push_back(param.name);
            bound.params[param.name] = param.default_value;
        }
        for (const JsonMember& member : node.params) {
            const std::string path = fmt::format("nodes.{}.params.{}", node.id, member.key);
            const Param* param = bound.type->param(member.key);
            if (!param) {
                error(member.key_place, path,
                      fmt::format("node type \"{}\" has no parameter \"{}\"{}", node.type, member.key,
                                  did_you_mean(member.key, names)));
                continue;
            }
            bound.set_by_user[param->name] = true;
            if (const auto value = parse_param_value(*param, member.value, path, diagnostics_))
                bound.params[param->name] = *value;
        }
    }

    // A node that runs under no facts stays: its names and wires are checked as any other's, and it gets in
    // nobody's way.
    void settle_conditions() {
        const auto find = [&](const std::string& id, const std::string& param) {
            return find_param(id, param);
        };
        for (size_t i = 0; i < result_.nodes.size(); ++i)
            if (const auto cases =
                    settle(sources_[i]->condition, find, "nodes." + sources_[i]->id + ".if", diagnostics_))
                result_.nodes[i].cases = *cases;
    }

    KnownParam find_param(const std::string& id, const std::string& name) const {
        const auto written = std::ranges::find(pipeline_.nodes, id, &PipelineNode::id);
        if (written == pipeline_.nodes.end()) {
            std::vector<std::string> ids;
            for (const PipelineNode& node : pipeline_.nodes) ids.push_back(node.id);
            return {.problem = fmt::format("no node \"{}\"{}", id, did_you_mean(id, ids))};
        }
        const auto node = std::ranges::find(result_.nodes, id, &BoundNode::id);
        if (node == result_.nodes.end()) return {};  // of unknown type, which has been said
        const Param* param = node->type->param(name);
        if (!param) {
            std::vector<std::string> names;
            for (const Param& p : node->type->params) names.push_back(p.name);
            return {.problem = fmt::format("node \"{}\" of type \"{}\" has no parameter \"{}\"{}", id,
                                           node->type->name, name, did_you_mean(name, names))};
        }
        const bool by_class = node->type->cpu.params.contains(name) || node->type->gpu.params.contains(name);
        if (by_class && !node->set_by_user.contains(name))
            return {.problem = fmt::format(
                        "\"{}.{}\" depends on the device where the pipeline does not set it", id, name)};
        return {.param = param, .value = &node->params.at(name)};
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

    // The facts under which a port exists, or nothing where the node's parameters or facts rule it out of a
    // node that runs.
    static std::optional<FactCases> cases_of_port(const BoundNode& node, const Port& port) {
        for (const Literal& literal : port.condition)
            if (literal.value && !holds({literal}, {}, node.params)) return std::nullopt;
        const FactCases cases = node.cases & cases_of(port.condition);
        if (cases.none() && node.cases.any()) return std::nullopt;
        return cases;
    }

    static const Wire* wire_of(const PipelineNode& node, const Port& port) {
        const std::vector<Wire>& wires = port.output ? node.out : node.in;
        const auto found = std::ranges::find(wires, port.name, &Wire::port);
        return found == wires.end() ? nullptr : &*found;
    }

    PortUse use_of(size_t node, const BoundPort& bound, const FactCases& cases) const {
        const std::string path = fmt::format("nodes.{}.{}.{}", result_.nodes[node].id,
                                             bound.port->output ? "out" : "in", bound.port->name);
        return {node, &bound, cases, bound.place, path};
    }

    template <typename Visit>
    void each_port(bool outputs, Visit visit) {
        for (size_t i = 0; i < result_.nodes.size(); ++i)
            for (BoundPort& bound : result_.nodes[i].ports)
                if (bound.port->output == outputs)
                    if (const auto cases = cases_of_port(result_.nodes[i], *bound.port))
                        visit(i, bound, wire_of(*sources_[i], *bound.port), *cases);
    }

    // The names that inputs and the pipeline's outputs ask for: an optional output exists if its name is
    // among them.
    std::map<std::string, std::vector<size_t>> wanted_names() {
        std::map<std::string, std::vector<size_t>> wanted;  // name -> asking nodes
        for (const OutputName& output : pipeline_.outputs)
            wanted[output.name].push_back(result_.nodes.size());
        each_port(false, [&](size_t node, const BoundPort& bound, const Wire* wire, const FactCases&) {
            wanted[wire ? wire->resource : bound.port->name].push_back(node);
        });
        return wanted;
    }

    void bind_outputs() {
        for (const HostInput& input : result_.inputs) flow_.resources[input.name].host = &input;
        const auto wanted = wanted_names();
        const auto asked_by_another = [&](const std::string& name, size_t node) {
            const auto found = wanted.find(name);
            return found != wanted.end() &&
                   std::ranges::any_of(found->second, [&](size_t n) { return n != node; });
        };
        each_port(true, [&](size_t node, BoundPort& bound, const Wire* wire, const FactCases& cases) {
            if (wire) bound.place = wire->place;
            if (wire)
                bound.resource = wire->resource;
            else if (!bound.port->optional || asked_by_another(bound.port->name, node))
                bound.resource = bound.port->name;
            if (bound.resource.empty()) {
                if (!bound.port->optional)
                    error(use_of(node, bound, {}), "only an optional port may be unbound (null)");
                return;
            }
            flow_.resources[bound.resource].writers.push_back(use_of(node, bound, cases));
        });
    }

    void bind_inputs() {
        each_port(false, [&](size_t node, BoundPort& bound, const Wire* wire, const FactCases& cases) {
            const Port& port = *bound.port;
            if (wire) {
                bound.place = wire->place;
                bound.resource = wire->resource;
                bound.previous = wire->previous;
            } else if (!port.previous && (!port.optional || exists_beside(port.name, node))) {
                bound.resource = port.name;
            }
            const PortUse use = use_of(node, bound, cases);
            const bool unbound = bound.resource.empty() && port.optional;
            if (port.previous && !bound.previous && !unbound)
                error(use, "must be wired to the previous frame's value of a name, as in \"NAME@-1\"");
            else if (bound.resource.empty() && !port.optional)
                error(use, "only an optional port may be unbound (null)");
            if (!bound.resource.empty()) flow_.resources[bound.resource].readers.push_back(use);
        });
    }

    // Whether somebody else than this node provides the name.
    bool exists_beside(const std::string& name, size_t node) const {
        const auto found = flow_.resources.find(name);
        if (found == flow_.resources.end()) return false;
        return found->second.host || std::ranges::any_of(found->second.writers, [&](const PortUse& writer) {
                   return writer.node != node;
               });
    }

    std::vector<std::string> existing_names(bool written_only = false) const {
        std::vector<std::string> names;
        for (const auto& [name, use] : flow_.resources)
            if (!use.writers.empty() || (use.host && !written_only)) names.push_back(name);
        return names;
    }

    void check_name(const std::string& name, const ResourceUse& use, const PortUse& reader) {
        const Port& port = *reader.bound->port;
        if (!use.host && use.writers.empty()) {
            if (unknown_type_) return;  // the node of unknown type may well write it
            const bool own = !wire_of(*sources_[reader.node], port);
            error(reader,
                  fmt::format("no resource named \"{}\"{}{}", name, own ? " (the port's own name)" : "",
                              did_you_mean(name, existing_names())));
            return;
        }
        if (!reader.bound->previous) return;
        if (port.kind == PortKind::block || port.kind == PortKind::scene)
            error(reader, fmt::format("a {} has no previous value", kind_name(port.kind)));
        else if (use.host && use.host->history == HostInput::History::none)
            error(reader,
                  fmt::format(
                      "\"{}\" is a host input without history; give it \"history\": \"host\" or \"copy\"",
                      name));
        else if (is_kept(use))
            error(reader, fmt::format("\"{}\" is kept in place, so its previous value is gone", name));
    }

    void check_settings() {
        for (const ResourceSetting& setting : pipeline_.resources) {
            const auto found = flow_.resources.find(setting.name);
            const bool known = found != flow_.resources.end();
            if (known && found->second.host)
                error(setting.place, "resources." + setting.name,
                      "a host input; its format is set in \"inputs\"");
            else if ((!known || found->second.writers.empty()) && !unknown_type_)
                error(setting.place, "resources." + setting.name,
                      fmt::format("no node writes \"{}\"{}", setting.name,
                                  did_you_mean(setting.name, existing_names(true))));
        }
    }

    void check_outputs() {
        for (size_t i = 0; i < pipeline_.outputs.size(); ++i) {
            const OutputName& output = pipeline_.outputs[i];
            const std::string path = fmt::format("outputs[{}]", i);
            const auto found = flow_.resources.find(output.name);
            const bool known = found != flow_.resources.end();
            if (known && found->second.host)
                error(output.place, path,
                      fmt::format("\"{}\" is a host input; an output is written by a node", output.name));
            else if ((!known || found->second.writers.empty()) && !unknown_type_)
                error(output.place, path,
                      fmt::format("no node writes \"{}\"{}", output.name,
                                  did_you_mean(output.name, existing_names(true))));
        }
    }

    const Pipeline& pipeline_;
    const NodeSet& set_;
    Diagnostics& diagnostics_;
    CheckedPipeline result_;
    std::vector<const PipelineNode*> sources_;  // of result_.nodes
    Dataflow flow_{result_, {}, {}};
    bool unknown_type_ = false;
};

}  // namespace

std::optional<CheckedPipeline> check(const Pipeline& pipeline, const NodeSet& nodes,
                                     Diagnostics& diagnostics) {
    return Checker(pipeline, nodes, diagnostics).run();
}

}  // namespace penumbra
