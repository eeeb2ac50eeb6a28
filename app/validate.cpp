// SPDX-License-Identifier: MIT
// A watcher stands right behind the node whose output it looks at, so that it lengthens no lifetime by more
// than itself. One per writer, not per name: writers of one name exclude each other and may promise different
// ranges.
#include "app/validate.h"

#include <algorithm>
#include <cfloat>

#include "penumbra/node_set.h"

namespace penumbra {
namespace {

constexpr const char* type_name = "validate";

std::shared_ptr<const NodeEntry> find_type(const NodeSet& nodes) {
    std::shared_ptr<const NodeEntry> entry = nodes.share(type_name);
    if (!entry || !entry->type.watches()) return nullptr;
    const auto has = [&](const char* name, ParamType type) {
        const Param* param = entry->type.param(name);
        return param && param->type == type;
    };
    const bool params = has("of", ParamType::enumeration) && has("least", ParamType::vec4) &&
                        has("greatest", ParamType::vec4);
    return params ? entry : nullptr;
}

class Validator {
  public:
    Validator(const CheckedPipeline& pipeline, std::shared_ptr<const NodeEntry> entry)
        : pipeline_(pipeline), entry_(std::move(entry)), type_(entry_->type) {}

    CheckedPipeline run() {
        result_ = pipeline_;
        result_.nodes.clear();
        result_.edges.clear();
        std::vector<uint32_t> moved;  // where each node of the pipeline is now
        for (const HostInput& input : pipeline_.inputs) watch_input(input);
        for (const BoundNode& node : pipeline_.nodes) {
            moved.push_back(static_cast<uint32_t>(result_.nodes.size()));
            result_.nodes.push_back(node);
            for (const BoundPort& bound : node.ports) watch_output(node, bound);
        }
        for (Edge edge : pipeline_.edges) {
            edge.from = moved[edge.from];
            edge.to = moved[edge.to];
            result_.edges.push_back(edge);
        }
        for (uint32_t i = 0; i < result_.nodes.size(); ++i)
            if (result_.nodes[i].added) order_watcher(i);
        return std::move(result_);
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

    void watch_input(const HostInput& input) {
        const auto id = static_cast<uint32_t>(pipeline_.resource(input.name) - pipeline_.resources.data());
        for (const BoundNode& node : pipeline_.nodes)
            for (const BoundPort& bound : node.ports) {
                if (bound.port->output || bound.resource != id) continue;
                if (const Port* port = port_for(*bound.port, bound.port->formats))
                    add_watcher(id, *port, all_cases(), input.place, {}, 4);
                return;
            }
    }

    void watch_output(const BoundNode& node, const BoundPort& bound) {
        if (!bound.port->output || bound.resource == no_resource) return;
        const Port* origin = origin_of(bound);
        if (!origin || origin->writes == Writes::tiles) return;
        std::vector<Format> formats;
        if (!origin->formats.empty()) formats = {pipeline_.resources[bound.resource].format};
        const Port* port = port_for(*origin, formats);
        if (!port) return;
        const uint32_t channels = !formats.empty()          ? info(formats.front()).channels
                                  : port->element == "vec4" ? 4
                                                            : 1;
        add_watcher(bound.resource, *port, bound.cases, node.place, bound.port->ranges, channels);
    }

    // An update's memory is that of the name that it takes over, and so on.
    const Port* origin_of(const BoundPort& output) const {
        const BoundPort* at = &output;
        for (size_t steps = 0; at && at->port->updated_input && steps <= pipeline_.nodes.size(); ++steps) {
            const BoundPort* writer = nullptr;
            for (const BoundNode& node : pipeline_.nodes) {
                if (at < node.ports.data() || at >= node.ports.data() + node.ports.size()) continue;
                const uint32_t taken = node.ports[*at->port->updated_input].resource;
                for (const BoundNode& other : pipeline_.nodes)
                    for (const BoundPort& port : other.ports)
                        if (!writer && port.port->output && port.resource == taken) writer = &port;
            }
            at = writer;
        }
        return at ? at->port : nullptr;
    }

    void add_watcher(uint32_t resource, const Port& port, const FactCases& cases, const Place& place,
                     const std::vector<std::array<double, 2>>& ranges, uint32_t channels) {
        BoundNode node{
            .id = pipeline_.resources[resource].name + "@" + type_name,  // no id of a pipeline's has an @
            .entry = entry_,
            .cases = cases,
            .place = place,
            .added = true};
        // Channels that the format lacks read as 0, 0, 0, 1, which no range is about.
        std::vector<float> least(4, -FLT_MAX), greatest(4, FLT_MAX);
        for (size_t c = 0; c < ranges.size() && c < channels; ++c) {
            least[c] = static_cast<float>(std::clamp<double>(ranges[c][0], -FLT_MAX, FLT_MAX));
            greatest[c] = static_cast<float>(std::clamp<double>(ranges[c][1], -FLT_MAX, FLT_MAX));
        }
        for (const Param& param : type_.params) {
            node.params.push_back(param.name == "of"         ? ParamValue(port.name)
                                  : param.name == "least"    ? ParamValue(least)
                                  : param.name == "greatest" ? ParamValue(greatest)
                                                             : param.default_value);
            node.set.push_back(false);
        }
        for (const Port& p : type_.ports)
            node.ports.push_back(
                {&p, &p == &port ? resource : no_resource, false, &p == &port ? cases : FactCases(), place});
        node.tables.resize(type_.tables.size());
        result_.nodes.push_back(std::move(node));
    }

    // After every writer of what it looks at, before whoever takes the memory over.
    void order_watcher(uint32_t watcher) {
        const BoundNode& node = result_.nodes[watcher];
        const auto watched =
            std::ranges::find_if(node.ports, [](const BoundPort& p) { return p.resource != no_resource; });
        for (uint32_t i = 0; i < result_.nodes.size(); ++i)
            for (const BoundPort& bound : result_.nodes[i].ports) {
                const FactCases both = bound.cases & node.cases;
                if (!bound.port->output || both.none()) continue;
                const std::optional<uint32_t> input = bound.port->updated_input;
                if (bound.resource == watched->resource) result_.edges.push_back({i, watcher, both});
                if (input && result_.nodes[i].ports[*input].resource == watched->resource)
                    result_.edges.push_back({watcher, i, both});
            }
    }

    const CheckedPipeline& pipeline_;
    std::shared_ptr<const NodeEntry> entry_;
    const NodeType& type_;
    CheckedPipeline result_;
};

}  // namespace

std::optional<CheckedPipeline> with_validation(const CheckedPipeline& pipeline, const NodeSet& nodes,
                                               Diagnostics& diagnostics) {
    if (auto entry = find_type(nodes)) return Validator(pipeline, std::move(entry)).run();
    diagnostics.add({pipeline.file}, "",
                    "validation needs a node type \"validate\" without outputs and with parameters \"of\", "
                    "\"least\" and \"greatest\"");
    return std::nullopt;
}

std::vector<ValidatePass> validate_passes(const Plan& plan) {
    const auto origin_of = [&](const PlanBinding& read, const std::string& resource, size_t before) {
        std::string origin = "inputs." + resource;
        if (read.source == BindingSource::host) return origin;
        const std::string name = resource.substr(0, resource.find('@'));
        for (size_t p = 0; p < (read.previous ? plan.passes.size() : before); ++p)
            for (size_t w = 0, o = 0; o < plan.passes[p].bindings.size(); ++o) {
                const PlanBinding& b = plan.passes[p].bindings[o];
                if (!b.output || b.level == PlanBinding::Level::finer) continue;
                if (b.index == read.index && plan.passes[p].writes[w] == name)
                    origin = "nodes." + plan.passes[p].node + ".out." + b.port;
                ++w;
            }
        return origin;
    };
    std::vector<ValidatePass> passes;
    for (size_t p = 0; p < plan.passes.size(); ++p) {
        const PlanPass& pass = plan.passes[p];
        if (pass.type != type_name || pass.reads.empty()) continue;
        const auto read = std::ranges::find_if(pass.bindings, [](const PlanBinding& b) {
            return !b.port.empty() && b.source != BindingSource::nothing;
        });
        passes.push_back({p, pass.reads.front(), origin_of(*read, pass.reads.front(), p)});
    }
    return passes;
}

}  // namespace penumbra
