// SPDX-License-Identifier: MIT
#include "tests/plan_mutants.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/lifetimes.h"

namespace penumbra::test {
namespace {

class Maker {
  public:
    Maker(const Plan& plan, const DeviceTable& device) : plan_(plan), device_(device) {}

    std::vector<Mutant> run() {
        for (uint32_t parity = 0; parity < 2; ++parity) {
            for (size_t p = 0; p < plan_.passes.size(); ++p) of_pass(p, parity);
            if (plan_.end[parity].src_stages)
                add(Fault::end_dropped, fmt::format("parity {}", parity)).end[parity] = {};
        }
        for (size_t r = 0; r < plan_.resources.size(); ++r) of_lifetime(r);
        return std::move(mutants_);
    }

  private:
    Plan& add(Fault fault, std::string what) {
        return mutants_.emplace_back(Mutant{fault, std::move(what), plan_}).plan;
    }

    // Where earlier reads are all that a dependency waits for, and an activation beside it waits for them,
    // too: barriers order stages whatever their images, so that without it nothing is wrong.
    static bool is_said_twice(const Dependency& d) {
        return d.src_access == 0 && std::ranges::any_of(d.activations, [&](const Activation& a) {
                   return (a.src_stages & d.src_stages) == d.src_stages &&
                          (a.dst_stages & d.dst_stages) == d.dst_stages;
               });
    }

    void of_pass(size_t p, uint32_t parity) {
        const PlanPass& pass = plan_.passes[p];
        const std::string what = fmt::format("{}, parity {}", pass.node, parity);
        if (pass.before[parity].src_stages && !is_said_twice(pass.before[parity])) {
            Dependency& d = add(Fault::dependency_dropped, what).passes[p].before[parity];
            d.src_stages = d.dst_stages = 0;
            d.src_access = d.dst_access = 0;
        }
        if (!pass.after_clears[parity].empty())
            add(Fault::clear_unordered, what).passes[p].after_clears[parity] = {};
        for (size_t a = 0; a < pass.before[parity].activations.size(); ++a) {
            const Activation& whole = pass.before[parity].activations[a];
            const std::string of = plan_.resources[whole.resource].names.front() + " in " + what;
            const auto activations = [&](Fault fault) -> std::vector<Activation>& {
                return add(fault, of).passes[p].before[parity].activations;
            };
            std::vector<Activation>& fewer = activations(Fault::activation_dropped);
            fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(a));
            activations(Fault::activation_unseen)[a].dst_access = 0;
            if (whole.src_stages != VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT)
                activations(Fault::activation_unordered)[a].src_stages = VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT;
        }
    }

    void of_lifetime(size_t r) {
        const PlanResource& resource = plan_.resources[r];
        if (resource.slot) return;  // the host's memory
        const std::string what = resource.names.front();
        --add(Fault::lifetime_short, what).resources[r].length;
        if (resource.length == 1) return;
        Plan& packed = add(Fault::lifetime_short_packed, what);
        --packed.resources[r].length;
        packed.heaps.clear();
        packed.memory = {};
        place_memory(packed, device_, false, 0);
    }

    const Plan& plan_;
    const DeviceTable& device_;
    std::vector<Mutant> mutants_;
};

}  // namespace

const char* name_of(Fault fault) {
    switch (fault) {
        case Fault::dependency_dropped:
            return "dependency dropped";
        case Fault::clear_unordered:
            return "clear not waited for";
        case Fault::end_dropped:
            return "dependency at the frame's end dropped";
        case Fault::activation_dropped:
            return "activation dropped";
        case Fault::activation_unordered:
            return "activation waits for nothing";
        case Fault::activation_unseen:
            return "activation not visible to the first use";
        case Fault::lifetime_short:
            return "lifetime a pass short";
        case Fault::lifetime_short_packed:
            return "lifetime a pass short, memory packed anew";
    }
    return "";
}

std::vector<Mutant> mutants(const Plan& plan, const DeviceTable& device) {
    return Maker(plan, device).run();
}

}  // namespace penumbra::test
