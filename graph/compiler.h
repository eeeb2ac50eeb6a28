// SPDX-License-Identifier: MIT
// Inside compile(): the state that one compilation builds up. Resources are made first
// (compile_resources.cpp), then each node is lowered to a pass: what it binds and how it uses that
// (compile_bindings.cpp), its shader, constants and dispatch (compile_passes.cpp).
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "graph/host_inputs.h"
#include "graph/interface.h"
#include "graph/select.h"
#include "penumbra/compile.h"

namespace penumbra {

inline uint32_t ceil_div(uint32_t a, uint32_t b) {
    return a / b + (a % b != 0);
}

class Compiler {
  public:
    Compiler(const CheckedPipeline& pipeline, const Target& target, const CompileOptions& options,
             Diagnostics& diagnostics)
        : pipeline_(pipeline), target_(target), options_(options), diagnostics_(diagnostics) {}

    std::optional<Plan> run();

  private:
    struct Size {
        Extent extent;
        uint32_t layers = 1;
        std::optional<Follows> follows;
    };

    void error(const Place& place, const std::string& path, const std::string& message);
    const std::string& name(uint32_t resource) const { return pipeline_.resources[resource].name; }

    void check_limits(const Selection& selection);

    // Facts and outputs, by the host's names.
    void read_facts();
    std::optional<Selection> select_nodes(const std::vector<bool>& left_out);
    // Says whether the plan jitters, and what holds because of that; whether something did not before.
    bool take_for_jittered(const Selection& selection);
    void lend_outputs();
    void read_outputs();

    // Resources. `made_` has, by name, the plan's resource and who makes it; sizes may follow what comes
    // later in the frame.
    struct Made {
        uint32_t resource = no_resource;
        const SelectedNode* by = nullptr;
        uint32_t port = 0;
        std::optional<Size> size;
    };
    void make_resources();
    void make_resource(const SelectedNode& selected, uint32_t port, uint32_t pass);
    Size size_of(const SelectedNode& selected, const SizeOf& of);
    Size size_of(uint32_t name);
    void size_resource(PlanResource& r, const Made& made);
    First first_of(const BoundPort& bound) const;
    static void clear_on_reset(PlanResource& r);

    // Bindings and uses of the pass that is last.
    void bind(const SelectedNode& selected);
    void bind_input(const SelectedNode& selected, uint32_t port, uint32_t binding);
    void bind_output(const SelectedNode& selected, uint32_t port, uint32_t binding);
    bool exists(const Bundle::Part& part) const;
    void bind_bundle(const BoundNode& node, const BoundPort& bound, uint32_t binding, bool present);
    void bind_tables(const BoundNode& node);
    void bind_resource(const Port& port, uint32_t resource, bool previous, uint32_t binding);
    void bind_slot(const BoundNode& node, const Port& port, HostSlot slot, uint32_t binding);
    void bind_nothing(const NodeType& type, const Port& port, uint32_t binding);
    void use_input(const Port& port, uint32_t resource, bool previous);
    void check_readable(const PlanResource& r, const Port& port);

    // Passes.
    void lower(const SelectedNode& selected);
    void lower_capture(uint32_t captured);
    void check_needs(const BoundNode& node);
    std::optional<std::string> problem_of(const Bundle::Backend& backend) const;
    void check_backend(const Bundle::Backend& backend, const Place& place, const std::string& path);
    const std::string& backend_of_port(const BoundNode& node, const Bundle& bundle);
    const ClassOverrides& overrides(const BoundNode& node) const;
    const ParamValue& value_of(const BoundNode& node, size_t param) const;
    void fill_constants(const SelectedNode& selected);
    void fill_dispatch(const SelectedNode& selected);
    bool lay_in_rows(const SelectedNode& selected);
    void find_module(const SelectedNode& selected);

    const CheckedPipeline& pipeline_;
    const Target& target_;
    const CompileOptions& options_;
    Diagnostics& diagnostics_;
    Plan plan_;
    size_t facts_ = 0;  // the case that the target is
    std::vector<HostResource> inputs_;
    std::vector<Made> made_;                   // by name
    std::map<std::string, uint32_t> members_;  // of Plan::members
    Variant variant_;                          // of the pass that is last
    std::map<std::pair<const NodeEntry*, std::string>, std::optional<uint32_t>> modules_;  // none: reported
};

}  // namespace penumbra
