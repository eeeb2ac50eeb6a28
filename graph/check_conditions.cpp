// SPDX-License-Identifier: MIT
#include "graph/check_conditions.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/suggestions.h"
#include "penumbra/condition.h"

namespace penumbra {
namespace {

class Conditions {
  public:
    Conditions(CheckedPipeline& pipeline, const WrittenOut& written_out, const NodesById& ids,
               Diagnostics& diagnostics)
        : pipeline_(pipeline), written_out_(written_out), ids_(ids), diagnostics_(diagnostics) {}

    void settle_node(BoundNode& node, const PipelineNode& source) {
        const auto written = static_cast<size_t>(&source - written_out_.pipeline.nodes.data());
        const PipelineInstance* instance = written_out_.of[written];
        const std::string path = "nodes." + node.id + ".if";
        const auto of_pipeline = [&](const Atom& atom) {
            return find_param(written_out_.node_id(written, atom.node), atom.name);
        };
        if (source.condition)
            if (const auto condition =
                    parse_condition(*source.condition, *pipeline_.domain, true, path, diagnostics_)) {
                node.condition = to_string(*condition);
                if (const auto cases = settle(*condition, of_pipeline, path, diagnostics_))
                    node.cases = of_instance(instance, *cases);
            }
        // A declaration's own conditions have been checked with it.
        const auto own = [&](const Atom& atom) -> KnownParam {
            const auto param = std::ranges::find(node.type().params, atom.name, &Param::name);
            return {.param = &*param,
                    .value = &node.params[static_cast<size_t>(param - node.type().params.begin())]};
        };
        const auto cases_of = [&](const auto& owner) {
            return of_instance(instance,
                               settle(owner.condition, own, path, diagnostics_).value_or(FactCases()));
        };
        for (BoundPort& bound : node.ports) bound.cases = cases_of(*bound.port);
        for (const Table& table : node.type().tables) node.tables.push_back(cases_of(table));
    }

  private:
    // An instance's own facts are what they are.
    FactCases of_instance(const PipelineInstance* instance, FactCases cases) const {
        if (!instance) return cases;
        const std::vector<Fact>& facts = pipeline_.domain->facts;
        for (const auto& [name, value] : instance->facts) {
            const auto fact = std::ranges::find(facts, name, &Fact::name);
            if (fact != facts.end())
                cases = cases_given(cases, static_cast<size_t>(fact - facts.begin()), value.holds);
        }
        return cases;
    }

    KnownParam find_param(const std::string& id, const std::string& name) {
        const auto found = ids_.find(id);
        if (found == ids_.end()) {
            if (!near_ids_) {
                std::vector<std::string> ids;
                for (const PipelineNode& node : written_out_.pipeline.nodes) ids.push_back(node.id);
                near_ids_.emplace(std::move(ids));
            }
            return {.problem = fmt::format("no node \"{}\"{}", id, near_ids_->nearest(id))};
        }
        if (!found->second) return {};  // of unknown type, which has been said
        const BoundNode& node = pipeline_.nodes[*found->second];
        const NodeType& type = node.type();
        const auto param = std::ranges::find(type.params, name, &Param::name);
        if (param == type.params.end()) {
            std::vector<std::string> names;
            for (const Param& p : type.params) names.push_back(p.name);
            return {.problem = fmt::format("node \"{}\" of type \"{}\" has no parameter \"{}\"{}", id,
                                           type.name, name, did_you_mean(name, names))};
        }
        const auto i = static_cast<size_t>(param - type.params.begin());
        const auto chooses = [&](const Port& port) { return port.bundle && port.bundle->param == name; };
        if (std::ranges::any_of(type.ports, chooses) && node.params[i] == ParamValue(std::string("auto")))
            return {.problem = fmt::format("\"{}.{}\" depends on the device where it is \"auto\"", id, name)};
        const bool by_class = type.cpu.params.contains(name) || type.gpu.params.contains(name);
        if (by_class && !node.set[i])
            return {.problem = fmt::format(
                        "\"{}.{}\" depends on the device where the pipeline does not set it", id, name)};
        return {.param = &*param, .value = &node.params[i]};
    }

    CheckedPipeline& pipeline_;
    const WrittenOut& written_out_;
    const NodesById& ids_;
    Diagnostics& diagnostics_;
    std::optional<Suggestions> near_ids_;
};

}  // namespace

void settle_conditions(CheckedPipeline& pipeline, const std::vector<const PipelineNode*>& sources,
                       const WrittenOut& written_out, const NodesById& ids, Diagnostics& diagnostics) {
    Conditions conditions(pipeline, written_out, ids, diagnostics);
    for (size_t i = 0; i < pipeline.nodes.size(); ++i) conditions.settle_node(pipeline.nodes[i], *sources[i]);
}

}  // namespace penumbra
