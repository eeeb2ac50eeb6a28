// SPDX-License-Identifier: MIT
// A watcher stands right behind the node whose output it looks at, so that it lengthens no lifetime by more
// than itself. One per writer, not per name: writers of one name exclude each other and may promise different
// ranges.
#include "graph/validate.h"

#include <algorithm>
#include <cfloat>

#include "graph/condition.h"
#include "graph/node_set.h"

namespace penumbra {
namespace {

constexpr const char* type_name = "validate";

const NodeType* find_type(const NodeSet& nodes) {
    const NodeEntry* entry = nodes.find(type_name);
    if (!entry || !entry->type.watches()) return nullptr;
    const auto has = [&](const char* name, ParamType type) {
        const Param* param = entry->type.param(name);
        return param && param->type == type;
    };
    const bool params = has("of", ParamType::enumeration) && has("least", ParamType::vec4) &&
                        has("greatest", ParamType::vec4);
    return params ? &entry->type : nullptr;
}

class Validator {
  public:
    Validator(const CheckedPipeline& pipeline, const NodeType& type) : pipeline_(pipeline), type_(type) {}

    CheckedPipeline run() {
        CheckedPipeline result = pipeline_;
        result.nodes.clear();
        for (const HostInput& input : pipeline_.inputs)
            if (auto watcher = watch_input(input)) result.nodes.push_back(std::move(*watcher));
        for (const BoundNode& node : pipeline_.nodes) {
            result.nodes.push_back(node);
            for (const BoundPort& bound : node.ports)
                if (auto watcher = watch_output(node, bound)) result.nodes.push_back(std::move(*watcher));
        }
        return result;
    }

  private:
    // The port of `validate` that takes such a resource, which is also the value of its parameter `of`.
    const Port* port_for(const Port& shape, const std::vector<Format>& formats) const {
        const char* of = nullptr;
        if (shape.kind == PortKind::image) of = shape.layers ? "layers" : "image";
        if (shape.kind == PortKind::texels) of = "texels";
        if (shape.kind == PortKind::buffer && shape.element == "f32") of = "floats";
        if (shape.kind == PortKind::buffer && shape.element == "vec4") of = "vectors";
        const Port* port = of ? type_.port(of) : nullptr;
        const auto accepts = [&](Format f) {
            return std::ranges::find(port->formats, f) != port->formats.end();
        };
        return port && std::ranges::all_of(formats, accepts) ? port : nullptr;
    }

    std::optional<BoundNode> watch_input(const HostInput& input) const {
        for (const BoundNode& node : pipeline_.nodes)
            for (const BoundPort& bound : node.ports) {
                if (bound.port->output || bound.resource != input.name) continue;
                const Port* port = port_for(*bound.port, bound.port->formats);
                if (!port) return std::nullopt;
                return watcher(input.name, *port, all_cases(), input.place);
            }
        return std::nullopt;
    }

    std::optional<BoundNode> watch_output(const BoundNode& node, const BoundPort& bound) const {
        if (!bound.port->output || bound.resource.empty()) return std::nullopt;
        const BoundPort* origin = origin_of(node, bound);
        if (!origin || origin->port->writes == Writes::tiles) return std::nullopt;
        std::vector<Format> formats;
        if (!origin->port->formats.empty()) formats = {format_of(*origin)};
        const Port* port = port_for(*origin->port, formats);
        if (!port) return std::nullopt;
        for (const Literal& literal : bound.port->condition)
            if (literal.value && !holds({literal}, {}, node.params)) return std::nullopt;
        const FactCases cases = node.cases & cases_of(bound.port->condition);
        BoundNode made = watcher(bound.resource, *port, cases, node.place);
        const uint32_t channels = !formats.empty()          ? info(formats.front()).channels
                                  : port->element == "vec4" ? 4
                                                            : 1;
        set_range(made, bound.port->ranges, channels);
        return made;
    }

    // An update's memory and format are those of the name that it takes over, and so on.
    const BoundPort* origin_of(const BoundNode& node, const BoundPort& bound) const {
        const BoundNode* writer = &node;
        const BoundPort* at = &bound;
        for (size_t steps = 0; at && !at->port->updates.empty() && steps <= pipeline_.nodes.size(); ++steps) {
            const auto input = std::ranges::find_if(
                writer->ports, [&](const BoundPort& p) { return p.port->name == at->port->updates; });
            at = nullptr;
            for (const BoundNode& other : pipeline_.nodes)
                for (const BoundPort& output : other.ports)
                    if (!at && output.port->output && output.resource == input->resource) {
                        writer = &other;
                        at = &output;
                    }
        }
        return at;
    }

    Format format_of(const BoundPort& output) const {
        for (const ResourceSetting& setting : pipeline_.resources)
            if (setting.name == output.resource && setting.format) return *setting.format;
        return output.port->formats.front();
    }

    BoundNode watcher(const std::string& resource, const Port& port, const FactCases& cases,
                      const Place& place) const {
        BoundNode node{.id = resource + "@" + type_name,  // no id of a pipeline's has an @
                       .type = &type_,
                       .cases = cases,
                       .place = place,
                       .added = true};
        for (const Param& param : type_.params) node.params[param.name] = param.default_value;
        node.params["of"] = port.name;
        for (const Port& p : type_.ports)
            node.ports.push_back({&p, &p == &port ? resource : "", false, place});
        return node;
    }

    // Channels that the format lacks read as 0, 0, 0, 1, which no range is about.
    static void set_range(BoundNode& node, const std::vector<std::array<double, 2>>& ranges,
                          uint32_t channels) {
        std::vector<float> least(4, -FLT_MAX), greatest(4, FLT_MAX);
        for (size_t c = 0; c < ranges.size() && c < channels; ++c) {
            least[c] = static_cast<float>(std::clamp<double>(ranges[c][0], -FLT_MAX, FLT_MAX));
            greatest[c] = static_cast<float>(std::clamp<double>(ranges[c][1], -FLT_MAX, FLT_MAX));
        }
        node.params["least"] = least;
        node.params["greatest"] = greatest;
    }

    const CheckedPipeline& pipeline_;
    const NodeType& type_;
};

}  // namespace

std::optional<CheckedPipeline> with_validation(const CheckedPipeline& pipeline, const NodeSet& nodes,
                                               Diagnostics& diagnostics) {
    if (const NodeType* type = find_type(nodes)) return Validator(pipeline, *type).run();
    diagnostics.add({pipeline.file}, "",
                    "validation needs a node type \"validate\" without outputs and with parameters \"of\", "
                    "\"least\" and \"greatest\"");
    return std::nullopt;
}

std::vector<ValidatePass> validate_passes(const Plan& plan) {
    const auto origin_of = [&](const PlanBinding& read, size_t before) {
        std::string origin = "inputs." + read.resource;
        if (read.host) return origin;
        for (size_t p = 0; p < (read.previous ? plan.passes.size() : before); ++p)
            for (const PlanBinding& b : plan.passes[p].bindings)
                if (b.port && b.port->output && !b.host && b.index == read.index &&
                    (b.resource == read.resource || b.resource + "@-1" == read.resource))
                    origin = "nodes." + plan.passes[p].node + ".out." + b.port->name;
        return origin;
    };
    std::vector<ValidatePass> passes;
    for (size_t p = 0; p < plan.passes.size(); ++p) {
        const PlanPass& pass = plan.passes[p];
        if (!pass.entry || pass.entry->type.name != type_name || pass.bindings.empty()) continue;
        const PlanBinding& read = pass.bindings.front();
        passes.push_back({p, read.resource, origin_of(read, p)});
    }
    return passes;
}

}  // namespace penumbra
