// SPDX-License-Identifier: MIT
// What begins again in the middle: members of families that were asleep (View::set_awake), whose passes had
// been left out, and what is kept to spare work, once a parameter is another than it was made with.
#include <algorithm>

#include "graph/view_state.h"

namespace penumbra {
namespace {

// The passes that a resource follows from, in this frame or through others before it.
std::vector<bool> makers_of(const Plan& plan, uint32_t resource) {
    std::vector<bool> makers(plan.passes.size()), wanted(plan.resources.size());
    wanted[resource] = true;
    const auto makes = [&](const PassUse& u) { return u.use.write && wanted[u.resource]; };
    for (bool more = true; more;) {
        more = false;
        for (size_t p = 0; p < plan.passes.size(); ++p) {
            if (makers[p] || std::ranges::none_of(plan.passes[p].uses, makes)) continue;
            for (const PassUse& u : plan.passes[p].uses) wanted[u.resource] = true;
            makers[p] = more = true;
        }
    }
    return makers;
}

}  // namespace

void ViewState::find_kept_memos() {
    for (uint32_t i = 0; i < plan().resources.size(); ++i)
        if (plan().resources[i].kept && plan().resources[i].memo)
            kept_memos_.push_back({i, makers_of(plan(), i)});
}

bool ViewState::is_stale(uint32_t resource) const {
    const auto memo = std::ranges::find(kept_memos_, resource, &KeptMemo::resource);
    return memo != kept_memos_.end() && memo->stale;
}

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
            reset_for(Reset::Reason::woken, plan().resources[action.resource]);
}

void ViewState::record_waking(VkCommandBuffer cmd) const {
    bool waits = false;
    for (const ResetAction& action : plan().reset) {
        if (!wakes(action.resource) && !is_stale(action.resource)) continue;
        if (!waits) full_dependency(cmd);
        waits = true;
        record_clear(cmd, action.resource, 1 - parity_, std::nullopt);
    }
    if (waits) full_dependency(cmd);
}

}  // namespace penumbra
