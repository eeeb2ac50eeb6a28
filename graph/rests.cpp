// SPDX-License-Identifier: MIT
#include "graph/rests.h"

namespace penumbra {
namespace {

// By resource: somebody who may be awake while its first writer rests has to do with it.
std::vector<bool> wanted_by_others(const Plan& plan) {
    std::vector<bool> wanted;
    for (const PlanResource& r : plan.resources) wanted.push_back(r.output);
    for (const PlanPass& pass : plan.passes)
        for (const PassUse& use : pass.uses) {
            const PlanPass& writer = plan.passes[plan.resources[use.resource].first_pass];
            if (!pass.rests || pass.member != writer.member) wanted[use.resource] = true;
        }
    return wanted;
}

}  // namespace

void place_rests(Plan& plan) {
    const std::vector<bool> wanted = wanted_by_others(plan);
    for (uint32_t i = 0; i < plan.resources.size(); ++i) {
        PlanResource& r = plan.resources[i];
        PlanPass& writer = plan.passes[r.first_pass];
        if (!writer.rests || !wanted[i] || r.kept) continue;  // what is kept is what it was
        writer.zero_at_rest.push_back(i);
        r.image_usage |= VK_IMAGE_USAGE_TRANSFER_DST_BIT;
        r.buffer_usage |= VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    }
}

}  // namespace penumbra
