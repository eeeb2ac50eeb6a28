// SPDX-License-Identifier: MIT
#include "app/session_lights.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/host_slots.h"

namespace penumbra {
namespace {

bool takes(const Plan& plan, const PlanPass& pass, std::string_view slot) {
    return std::ranges::any_of(pass.bindings, [&](const PlanBinding& b) {
        return b.source == BindingSource::host && plan.slots[b.index].name == slot;
    });
}

// Who reads the sun reads one of these slots, too: the sun's block is bound, and is not whom the mask is of.
void check_nodes(const Plan& plan, const std::vector<std::string>& slots, const std::string& light,
                 const Place& place, Diagnostics& diagnostics) {
    for (const PlanPass& pass : plan.passes) {
        const auto reads_it = [&](const std::string& slot) { return takes(plan, pass, slot); };
        if (reads_it("sun") && std::ranges::none_of(slots, reads_it))
            diagnostics.add(
                place, "nodes." + pass.node,
                fmt::format("\"{}\" knows the sun alone, and the shot's light is {}", pass.type, light));
    }
}

void check_chosen(const Plan& plan, const CheckedPipeline& pipeline, const ChosenLight& chosen,
                  Diagnostics& diagnostics) {
    const bool near = reads(plan, "light");
    const Place place{pipeline.file, 0, 0};
    if (!chosen.light && near)
        diagnostics.add(
            place, "inputs.light",
            fmt::format("\"{}\" takes a light that is near, and masks of this shot are of its sun",
                        pipeline.name));
    if (!chosen.light) return;
    const std::string light = fmt::format("\"{}\", a {}", chosen.name, name_of(chosen.light->kind));
    if (!near && reads(plan, "sun"))
        diagnostics.add(
            place, "inputs",
            fmt::format("\"{}\" knows the sun alone, and the shot's light is {}, which `light` and `lights` "
                        "draw; a variant of another pipeline has \"inputs\": {{ \"light\": {{}} }}",
                        pipeline.name, light));
    if (near) check_nodes(plan, {"light"}, light, place, diagnostics);
}

}  // namespace

std::optional<SessionLights> choose_session_lights(const CheckedPipeline& pipeline, const Shot& shot,
                                                   const std::string& wanted, Diagnostics& diagnostics) {
    SessionLights result;
    const bool near = pipeline.input("light");
    const HostInput* together = pipeline.input("lights");
    // A pipeline that can do without lamps is of the sun and of all lamps that there are: of the sun alone,
    // too.
    const bool beside_sun = together && together->optional && !shot.lights.empty() && wanted != "sun";
    result.together = (together && !together->optional) || beside_sun;
    for (const auto& [name, light] : shot.lights)
        if (pipeline.input(slot_of_light(name))) result.names.push_back(name);
    result.each = !result.names.empty();
    if (result.together) {
        result.names = choose_lights(shot, near ? "" : wanted, diagnostics);
        if (result.names.empty()) return std::nullopt;
    }
    const bool of_none =
        result.each || (beside_sun && !near) || (result.together && !near && !pipeline.input("sun"));
    if (of_none) return result;
    const auto chosen = choose_light(shot, result.together && !near ? "" : wanted, diagnostics,
                                     near ? LightsFor::near : LightsFor::sun);
    if (!chosen) return std::nullopt;
    result.chosen = *chosen;
    return result;
}

void check_lights(const Plan& plan, const CheckedPipeline& pipeline, const SessionLights& lights,
                  const ShotLight* light, Diagnostics& diagnostics) {
    check_chosen(plan, pipeline, {lights.chosen.name, light}, diagnostics);
    if (!lights.each) return;
    std::vector<std::string> slots;
    std::ranges::transform(lights.names, std::back_inserter(slots), slot_of_light);
    check_nodes(plan, slots, "one of several", {pipeline.file, 0, 0}, diagnostics);
}

}  // namespace penumbra
