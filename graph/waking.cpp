// SPDX-License-Identifier: MIT
// Members of families that are asleep (View::set_awake): what their passes leave undone, and how they begin
// again.
#include <algorithm>

#include "graph/view_state.h"

namespace penumbra {

bool ViewState::set_awake(std::string_view member, bool awake) {
    const auto known = std::ranges::find(plan().members, member);
    if (known == plan().members.end()) return false;
    const auto rests = asked_to_rest_.begin() + (known - plan().members.begin());
    if (*rests == !awake) return true;
    *rests = !awake;
    set_ = slept_ = true;
    return true;
}

void ViewState::record_rest(VkCommandBuffer cmd, const PlanPass& pass) const {
    if (pass.zero_at_rest.empty()) return;
    full_dependency(cmd);
    for (const uint32_t resource : pass.zero_at_rest) record_clear(cmd, resource, parity_, std::nullopt);
    full_dependency(cmd);
}

// Whether nobody has written the resource in the last frame, because its writer was asleep.
bool ViewState::rested(uint32_t resource) const {
    const PlanPass& writer = plan().passes[plan().resources[resource].first_pass];
    return writer.rests && rested_[*writer.member];
}

// Whether others read 0 of it, since its writer is asleep.
bool ViewState::is_zero_at_rest(uint32_t resource) const {
    const PlanPass& writer = plan().passes[plan().resources[resource].first_pass];
    return rests(writer) && std::ranges::find(writer.zero_at_rest, resource) != writer.zero_at_rest.end();
}

bool ViewState::wakes(uint32_t resource) const {
    return rested(resource) && !rests(plan().passes[plan().resources[resource].first_pass]);
}

void ViewState::decide_waking() {
    if (reset_.reason != Reset::Reason::none) return;
    for (const ResetAction& action : plan().reset)
        if (!action.clear && wakes(action.resource))
            reset_ = {Reset::Reason::woken, plan().resources[action.resource].names.back()};
}

void ViewState::record_waking(VkCommandBuffer cmd) const {
    bool waits = false;
    for (const ResetAction& action : plan().reset) {
        if (!wakes(action.resource)) continue;
        if (!waits) full_dependency(cmd);
        waits = true;
        record_clear(cmd, action.resource, 1 - parity_, std::nullopt);
    }
    if (waits) full_dependency(cmd);
}

}  // namespace penumbra
