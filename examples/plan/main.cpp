// SPDX-License-Identifier: MIT
// A plan without a device: what an engine with a Vulkan layer of its own carries out by itself.
#include <cstdio>

#include "penumbra/graph.h"
#include "penumbra/shadow_nodes.h"
#include "penumbra/version.h"

int main(int argc, char** argv) {
    penumbra::Diagnostics errors;
    const char* file = argc > 1 ? argv[1] : PIPELINES "/hybrid_shadows.json";
    const auto pipeline = penumbra::load_pipeline(file, {}, errors);
    const auto checked =
        pipeline ? penumbra::check(*pipeline, penumbra::shadow_nodes(), errors) : std::nullopt;
    const auto plan =
        checked ? penumbra::compile(*checked, {.extent = {1280, 720}, .device = penumbra::reference_device()},
                                    {}, errors)
                : std::nullopt;
    if (!plan) {
        std::fputs(errors.text().c_str(), stderr);
        return 2;
    }
    std::printf("penumbra %s: %s\n", PENUMBRA_VERSION_TEXT, plan->pipeline.c_str());
    for (const penumbra::PlanPass& pass : plan->passes)
        std::printf("%-20s %6zu bytes of SPIR-V, %zu bindings, %ux%ux%u groups\n", pass.node.c_str(),
                    4 * plan->modules[*pass.module].size(), pass.bindings.size(), pass.groups[0],
                    pass.groups[1], pass.groups[2]);
    for (const penumbra::HostSlot& slot : plan->slots) std::printf("the host brings %s\n", slot.name.c_str());
    std::printf("%zu resources in %llu bytes\n", plan->resources.size(),
                static_cast<unsigned long long>(plan->memory.heap_bytes));
}
