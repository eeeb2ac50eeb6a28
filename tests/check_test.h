// SPDX-License-Identifier: MIT
// What tests of check() share: pipelines of toy nodes in a few words.
#pragma once

#include <gtest/gtest.h>

#include "penumbra/check.h"
#include "tests/toy_nodes.h"

namespace penumbra::test {

// A pipeline of these inputs, outputs and nodes ("more" may add keys).
inline std::string pipeline(const std::string& inputs, const std::string& outputs, const std::string& nodes,
                            const std::string& more = "") {
    return R"({"penumbra": 1, "name": "p", "inputs": {)" + inputs + R"(}, "outputs": [)" + outputs +
           R"(], "nodes": {)" + nodes + "}" + more + "}";
}

inline const char* const sum_nodes = R"("f": {"type": "fill", "out": {"value": "s0"}},
    "a": {"type": "accumulate", "in": {"sum": "s0"}, "out": {"total": "s1"}},
    "b": {"type": "accumulate", "in": {"sum": "s1"}, "out": {"total": "s2"}})";

// A pipeline that is checked, with its errors.
class Check : public ::testing::Test {
  protected:
    std::optional<CheckedPipeline> run(const std::string& text,
                                       const std::vector<std::string>& settings = {}) {
        diagnostics_ = {};
        const auto parsed = parse_pipeline(text, "p.json", settings, diagnostics_);
        EXPECT_TRUE(parsed) << diagnostics_.text();
        if (!parsed) return std::nullopt;
        const auto checked = check(*parsed, nodes_, diagnostics_);
        EXPECT_EQ(checked.has_value(), diagnostics_.empty());
        return checked;
    }
    // The one error's message, or all the text where there is not exactly one.
    std::string error(const std::string& text, const std::vector<std::string>& settings = {}) {
        EXPECT_FALSE(run(text, settings)) << text;
        if (diagnostics_.size() != 1) return diagnostics_.text();
        return diagnostics_.list()[0].path + ": " + diagnostics_.list()[0].message;
    }
    void expect_valid(const std::string& text) { EXPECT_TRUE(run(text)) << diagnostics_.text(); }

    static const BoundPort& port(const CheckedPipeline& checked, const std::string& node,
                                 const std::string& name) {
        for (const BoundNode& bound : checked.nodes)
            if (bound.id == node)
                for (const BoundPort& p : bound.ports)
                    if (p.port->name == name) return p;
        throw std::runtime_error("no port " + node + "." + name);
    }

    static size_t param_index(const CheckedPipeline& checked, size_t node, const std::string& name) {
        const NodeType& type = checked.nodes[node].type();
        return static_cast<size_t>(type.param(name) - type.params.data());
    }
    static const ParamValue& param(const CheckedPipeline& checked, size_t node, const std::string& name) {
        return checked.nodes[node].params[param_index(checked, node, name)];
    }
    static bool is_set(const CheckedPipeline& checked, size_t node, const std::string& name) {
        return checked.nodes[node].set[param_index(checked, node, name)];
    }
    // The name that a port reads or writes; empty: unbound.
    static std::string bound_to(const CheckedPipeline& checked, const std::string& node,
                                const std::string& name) {
        const BoundPort& bound = port(checked, node, name);
        return bound.resource == no_resource ? "" : checked.resources[bound.resource].name;
    }

    NodeSet nodes_ = toy_nodes();
    Diagnostics diagnostics_;
};

}  // namespace penumbra::test
