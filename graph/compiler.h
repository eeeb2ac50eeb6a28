// SPDX-License-Identifier: MIT
// Inside compile(): the state that one compilation builds up, pass by pass, and the steps of lowering a node.
// Ports become slots, resources and uses (compile_ports.cpp, compile_resources.cpp); parameters become
// constants, sizes become dispatches (compile_dispatch.cpp).
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "graph/compile.h"
#include "graph/host_inputs.h"
#include "graph/select.h"

namespace penumbra {

inline uint32_t ceil_div(uint32_t a, uint32_t b) {
    return a / b + (a % b != 0);
}

class Compiler {
  public:
    Compiler(const CheckedPipeline& pipeline, const NodeSet& nodes, const Target& target,
             const CompileOptions& options, Diagnostics& diagnostics)
        : pipeline_(pipeline), nodes_(nodes), target_(target), options_(options), diagnostics_(diagnostics) {}

    std::optional<Plan> run();

  private:
    struct Size {
        Extent extent;
        uint32_t layers = 1;
    };
    struct Late {
        size_t pass, binding;
        std::string resource;
    };
    struct FormatChoice {
        const Port* port;
        std::string resource;
        Source source;
        std::string node;
    };

    void error(const Place& place, const std::string& path, const std::string& message);
    void lower(const SelectedNode& selected);
    void lower_capture(const SelectedNode& selected);
    void check_needs(const BoundNode& node);
    void finish_resources();

    // Ports.
    Size size_of(const Connection& c) const;
    std::optional<Size> size_named(const BoundNode& node, const SelectedNode& selected,
                                   const std::string& of);
    void bind_input(const BoundNode& node, const Connection& c, uint32_t binding);
    void use_input(PlanPass& pass, const Port& port, uint32_t resource, bool previous);
    void check_readable(const PlanResource& r, const Port& port);
    static Use input_use(const PlanPass& pass, const Port& port);
    std::vector<uint32_t> host_slots(const BoundNode& node, const Connection& c);
    uint32_t scene_texels(const BoundNode& node, const Connection& c, const SceneTexels& texels);
    uint32_t slot(const BoundNode& node, const std::string& name, PortKind kind, Format format,
                  const Connection& c, const std::string& element);
    void bind_output(const BoundNode& node, const SelectedNode& selected, const Connection& c,
                     uint32_t binding);

    // Resources.
    First first_of(const Port& port, const std::string& name) const;
    static void clear_on_reset(PlanResource& r);
    void make_resource(const BoundNode& node, const SelectedNode& selected, const Connection& c);

    // Variants, constants, dispatch.
    void choose_backend(const BoundNode& node);
    void choose_variant(const BoundNode& node, const SelectedNode& selected);
    const ClassOverrides& overrides(const BoundNode& node) const;
    const ParamValue& value_of(const BoundNode& node, const Param& param) const;
    void fill_constants(const BoundNode& node);
    uint32_t levels_of(const SelectedNode& selected, const Port& chain) const;
    void fill_dispatch(const BoundNode& node, const SelectedNode& selected);

    const CheckedPipeline& pipeline_;
    const NodeSet& nodes_;
    const Target& target_;
    const CompileOptions& options_;
    Diagnostics& diagnostics_;
    Plan plan_;
    ResolvedInputs inputs_;
    std::vector<uint32_t> bindings_;
    std::map<std::string, uint32_t> internal_;  // name -> resource
    std::vector<Late> late_;
    std::vector<std::vector<FormatChoice>> choices_;  // per non-capture pass
};

}  // namespace penumbra
