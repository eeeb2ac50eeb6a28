// SPDX-License-Identifier: MIT
#include "app/mask_passes.h"

#include <algorithm>
#include <set>
#include <string>

namespace penumbra {

std::vector<bool> passes_of_mask(const Plan& plan, const std::string& signal) {
    std::vector<bool> needed(plan.passes.size());
    std::set<std::string> names{signal};
    for (bool grown = true; grown;) {
        grown = false;
        for (size_t p = 0; p < plan.passes.size(); ++p) {
            const PlanPass& pass = plan.passes[p];
            if (needed[p] || pass.kind == PassKind::capture || pass.type == "validate" ||
                std::none_of(pass.writes.begin(), pass.writes.end(),
                             [&](const std::string& name) { return names.contains(name); }))
                continue;
            needed[p] = grown = true;
            for (const std::string& name : pass.reads) names.emplace(without_previous(name));
        }
    }
    return needed;
}

bool has_history(const Plan& plan) {
    return std::ranges::any_of(plan.resources, [](const PlanResource& r) { return r.lasts() && !r.memo; }) ||
           std::ranges::any_of(plan.slots, [](const HostSlot& slot) { return is_previous(slot.name); });
}

}  // namespace penumbra
