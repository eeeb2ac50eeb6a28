// SPDX-License-Identifier: MIT
#include "app/sleeping_lights.h"

#include <algorithm>

#include "app/host_slots.h"

namespace penumbra {

std::vector<size_t> lights_that_may_sleep(const Plan& plan, const std::vector<std::string>& names) {
    std::vector<size_t> lights;
    for (size_t i = 0; i < names.size(); ++i) {
        const auto resets = [&](const ResetAction& action) {
            const PlanPass& writer = plan.passes[plan.resources[action.resource].first_pass];
            return !action.clear && writer.rests && plan.members[*writer.member] == names[i];
        };
        if (std::ranges::find(plan.members, names[i]) != plan.members.end() &&
            reads(plan, slot_of_light(names[i])) && std::ranges::none_of(plan.reset, resets))
            lights.push_back(i);
    }
    return lights;
}

}  // namespace penumbra
