// SPDX-License-Identifier: MIT
// What a host binds to a plan's slots for a frame, by their names.
#include <fmt/format.h>

#include <algorithm>

#include "graph/device.h"
#include "penumbra/diagnostic.h"
#include "penumbra/view.h"

namespace penumbra {

Externals::Externals(const Plan& plan) : plan_(&plan), bindings_(plan.slots.size()) {}

bool Externals::fits(const Plan& plan) const {
    return &plan == plan_ ||
           std::ranges::equal(plan.slots, plan_->slots, {}, &HostSlot::name, &HostSlot::name);
}

SlotBinding& Externals::operator[](std::string_view name) {
    if (const auto slot = plan_->slot(name)) return bindings_[*slot];
    std::vector<std::string> names;
    for (const HostSlot& slot : plan_->slots) names.push_back(slot.name);
    fail(ErrorCode::usage, plan_->pipeline,
         fmt::format("the plan has no slot \"{}\"{}", name, did_you_mean(name, names)));
}

void Externals::clear() {
    std::ranges::fill(bindings_, SlotBinding{});
}

bool Externals::has(std::string_view name) const {
    return plan_->slot(name).has_value();
}

}  // namespace penumbra
