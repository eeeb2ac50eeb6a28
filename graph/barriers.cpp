// SPDX-License-Identifier: MIT
// The plan's frames are simulated on the two-frame circle until they repeat. Each instance (resource, parity)
// remembers its last write, the reads since, and what earlier dependencies have already ordered. Read after
// write and write after write need memory dependencies, write after read needs execution only (Vulkan
// specification, "Synchronization"). Dependencies are global memory barriers; image barriers only activate
// images in reused memory, and since their access scope covers that image alone, the previous occupants'
// writes go into the memory barrier of the same dependency. What is kept is activated once, by a reset.
#include "graph/barriers.h"

#include <algorithm>

namespace penumbra {
namespace {

// What has been done to one instance and what is already synchronised.
struct State {
    VkPipelineStageFlags2 write_stages = 0;
    VkAccessFlags2 write_access = 0;
    VkPipelineStageFlags2 visible_stages = 0;  // the write is visible to these ...
    VkAccessFlags2 visible_access = 0;         // ... with these accesses
    VkPipelineStageFlags2 read_stages = 0;     // reads since the write
    VkPipelineStageFlags2 read_ordered = 0;    // stages that already wait for those reads
};

bool contains(uint64_t set, uint64_t subset) {
    return (set & subset) == subset;
}

class Simulation {
  public:
    explicit Simulation(const Plan& plan) : plan_(plan), states_(plan.resources.size()) {}

    // Adds to `dependency` what `use` of an instance needs after its own and, on activation, its memory's
    // past.
    void require(Dependency& dependency, uint32_t resource, uint32_t parity, const Use& use, bool activates) {
        if (activates) return activate(dependency, resource, parity, use);
        require_after(dependency, state(resource, parity), use);
    }

    // The dependency is recorded: everything its source scope covers is ordered before its destination.
    void apply(const Dependency& d) {
        if (d.src_stages == 0) return;
        for (auto& pair : states_)
            for (State& s : pair) {
                if (contains(d.src_stages, s.write_stages) && contains(d.src_access, s.write_access)) {
                    s.visible_stages |= d.dst_stages;
                    s.visible_access |= d.dst_access;
                }
                if (contains(d.src_stages, s.read_stages)) s.read_ordered |= d.dst_stages;
            }
    }

    void done(uint32_t resource, uint32_t parity, const Use& use) {
        State& s = state(resource, parity);
        if (use.write) {
            s = {.write_stages = use.stages, .write_access = use.access & write_mask};
        } else {
            s.read_stages |= use.stages;
            s.read_ordered = 0;
        }
    }

  private:
    static constexpr VkAccessFlags2 write_mask = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
                                                 VK_ACCESS_2_TRANSFER_WRITE_BIT |
                                                 VK_ACCESS_2_SHADER_WRITE_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;

    // What is kept has one instance.
    State& state(uint32_t resource, uint32_t parity) {
        return states_[resource][plan_.resources[resource].kept ? 0 : parity];
    }

    static void require_after(Dependency& d, const State& s, const Use& use) {
        if (s.write_stages &&
            !(contains(s.visible_stages, use.stages) && contains(s.visible_access, use.access))) {
            d.src_stages |= s.write_stages;
            d.src_access |= s.write_access;
            d.dst_stages |= use.stages;
            d.dst_access |= use.access;
        }
        if (use.write && s.read_stages && !contains(s.read_ordered, use.stages)) {
            d.src_stages |= s.read_stages;
            d.dst_stages |= use.stages;
        }
    }

    bool shares_bytes(uint32_t a, uint32_t pa, uint32_t b, uint32_t pb) const {
        const PlanResource& x = plan_.resources[a];
        const PlanResource& y = plan_.resources[b];
        if (x.slot || y.slot) return a == b;  // the host may bring the same image every frame
        return x.heap == y.heap && x.offset[pa] < y.offset[pb] + y.bytes &&
               y.offset[pb] < x.offset[pa] + x.bytes;
    }

    void activate(Dependency& d, uint32_t resource, uint32_t parity, const Use& use) {
        VkPipelineStageFlags2 past = 0;
        for (uint32_t other = 0; other < states_.size(); ++other)
            for (uint32_t q = 0; q < 2; ++q) {
                if (!shares_bytes(resource, parity, other, q)) continue;
                const State& s = states_[other][q];
                require_after(d, s, use);
                past |= s.write_stages | s.read_stages;
            }
        if (plan_.resources[resource].kind != PortKind::image) return;
        // The transition writes the image: it waits for every past access and precedes the first use.
        d.activations.push_back(
            {resource, past ? past : VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT, use.stages, use.access});
    }

    const Plan& plan_;
    std::vector<std::array<State, 2>> states_;
};

// vkCmdFillBuffer counts as a clear in the specification and as a copy in some validation layers: ask for
// both.
constexpr Use clear_use{VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, true};

// One pass may use a resource through several ports: their scopes are joined.
std::vector<PassUse> joined(const std::vector<PassUse>& uses) {
    std::vector<PassUse> result;
    for (const PassUse& use : uses) {
        const auto same = std::find_if(result.begin(), result.end(), [&](const PassUse& other) {
            return other.resource == use.resource && other.previous == use.previous;
        });
        if (same == result.end()) {
            result.push_back(use);
        } else {
            same->use.stages |= use.use.stages;
            same->use.access |= use.use.access;
            same->use.write |= use.use.write;
        }
    }
    return result;
}

void run_frame(Plan& plan, Simulation& simulation, uint32_t parity) {
    for (uint32_t p = 0; p < plan.passes.size(); ++p) {
        PlanPass& pass = plan.passes[p];
        Dependency before, after_clears;
        const std::vector<PassUse> uses = joined(pass.uses);
        const auto cleared = [&](const PassUse& use) {
            return !use.previous &&
                   std::find(pass.clears.begin(), pass.clears.end(), use.resource) != pass.clears.end();
        };
        for (const PassUse& use : uses) {
            const PlanResource& r = plan.resources[use.resource];
            const bool activates = !use.previous && r.first_pass == p && !r.kept;
            simulation.require(before, use.resource, use.previous ? 1 - parity : parity,
                               cleared(use) ? clear_use : use.use, activates);
        }
        simulation.apply(before);
        for (const PassUse& use : uses)
            if (cleared(use)) simulation.done(use.resource, parity, clear_use);
        for (const PassUse& use : uses)
            if (cleared(use)) simulation.require(after_clears, use.resource, parity, use.use, false);
        simulation.apply(after_clears);
        for (const PassUse& use : uses)
            simulation.done(use.resource, use.previous ? 1 - parity : parity, use.use);
        pass.before[parity] = std::move(before);
        pass.after_clears[parity] = std::move(after_clears);
    }
    Dependency end;
    for (const PlanOutput& output : plan.outputs)
        simulation.require(end, output.resource, parity, output.use, false);
    simulation.apply(end);
    for (const PlanOutput& output : plan.outputs) simulation.done(output.resource, parity, output.use);
    plan.end[parity] = std::move(end);
}

}  // namespace

void place_barriers(Plan& plan) {
    Simulation simulation(plan);
    // The first circle starts from nothing; by the third every frame repeats what it did two frames before.
    for (uint32_t frame = 0; frame < 6; ++frame) run_frame(plan, simulation, frame & 1);
}

}  // namespace penumbra
