// SPDX-License-Identifier: MIT
// A past that feeds itself, directly or through others, settles when its declaration says so; one that does
// not is a frame behind what it is made of, as the host's own past is. What only spares work is not asked.
#include "graph/settling.h"

#include <algorithm>

namespace penumbra {

namespace {

// Whether what a frame makes of `resource` depends on what the frame before has made of it.
bool feeds_itself(const Plan& plan, uint32_t resource) {
    std::vector<bool> follows(plan.resources.size());
    const auto reads = [&](const PlanPass& pass) {
        return std::ranges::any_of(pass.uses, [&](const PassUse& u) {
            return (u.previous && u.resource == resource) || follows[u.resource];
        });
    };
    for (bool more = true; more;) {
        more = false;
        for (const PlanPass& pass : plan.passes) {
            if (!reads(pass)) continue;
            for (const PassUse& u : pass.uses) {
                if (!u.use.write || follows[u.resource]) continue;
                follows[u.resource] = more = true;
            }
        }
    }
    return follows[resource];
}

}  // namespace

std::optional<uint32_t> frames_to_settle(const Plan& plan) {
    uint64_t frames = std::ranges::any_of(plan.slots, &HostSlot::previous) ? 1 : 0;
    for (uint32_t i = 0; i < plan.resources.size(); ++i) {
        const PlanResource& r = plan.resources[i];
        if (r.memo || !r.lasts()) continue;
        if (r.settles)
            frames += r.settles;
        else if (r.kept || feeds_itself(plan, i))
            return std::nullopt;
        else
            ++frames;
    }
    return static_cast<uint32_t>(std::min<uint64_t>(frames, UINT32_MAX));
}

}  // namespace penumbra
