// SPDX-License-Identifier: MIT
#include "host/shots/light_choice.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

namespace penumbra {
namespace {

blocks::vec3 to_block(const glm::dvec3& v) {
    return {{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}};
}

uint32_t block_kind(LightKind kind) {
    switch (kind) {
        case LightKind::disc:
            return blocks::LIGHT_DISC;
        case LightKind::rectangle:
            return blocks::LIGHT_RECTANGLE;
        case LightKind::tube:
            return blocks::LIGHT_TUBE;
        default:
            return blocks::LIGHT_SPHERE;
    }
}

}  // namespace

std::optional<ChosenLight> choose_light(const Shot& shot, const std::string& name, Diagnostics& diagnostics,
                                        LightsFor lights) {
    std::vector<std::string> names, fitting;
    if (shot.has_sun) names.emplace_back("sun");
    if (shot.has_sun && lights != LightsFor::near) fitting.emplace_back("sun");
    for (const auto& [key, light] : shot.lights) {
        names.push_back(key);
        if (lights != LightsFor::sun) fitting.push_back(key);
    }
    if (names.empty()) {
        diagnostics.add({shot.file.string(), 0, 0}, "--light", "the shot has no light");
        return std::nullopt;
    }
    if (fitting.empty()) fitting = names;  // whoever asks for such a light is told which there are
    const std::string wanted = name.empty() && fitting.size() == 1 ? fitting.front() : name;
    if (wanted.empty()) {
        diagnostics.add(
            {shot.file.string(), 0, 0}, "--light",
            fmt::format("the shot has several lights, and a mask is of one: {}", fmt::join(fitting, ", ")));
        return std::nullopt;
    }
    if (std::ranges::find(names, wanted) == names.end()) {
        diagnostics.add({shot.file.string(), 0, 0}, "--light",
                        fmt::format("the shot has no light named \"{}\"{}; it has {}", wanted,
                                    did_you_mean(wanted, names), fmt::join(names, ", ")));
        return std::nullopt;
    }
    if (wanted == "sun") return ChosenLight{};
    return ChosenLight{wanted, &shot.lights.at(wanted)};
}

std::vector<std::string> choose_lights(const Shot& shot, const std::string& name, Diagnostics& diagnostics) {
    std::vector<std::string> names;
    for (const auto& [key, light] : shot.lights) names.push_back(key);
    if (names.empty()) {
        diagnostics.add({shot.file.string(), 0, 0}, "lights",
                        "the pipeline takes lights that are near, and the shot has none");
        return {};
    }
    if (name.empty()) return names;
    if (std::ranges::find(names, name) != names.end()) return {name};
    diagnostics.add({shot.file.string(), 0, 0}, "--light",
                    fmt::format("the shot has no light named \"{}\"{} that is near; it has {}", name,
                                did_you_mean(name, names), fmt::join(names, ", ")));
    return {};
}

blocks::Light light_block(const ShotLight& light, double frame, const glm::dvec3& camera) {
    const LightKey key = light_at(light, frame);
    const bool round =
        light.kind == LightKind::point || light.kind == LightKind::sphere || light.kind == LightKind::spot;
    const bool laid = light.kind == LightKind::rectangle || light.kind == LightKind::tube;
    const double radius = light.radius * key.size;
    blocks::Light block{};
    block.centre = to_block(key.position - camera);
    block.kind = block_kind(light.kind);
    block.u = to_block(round  ? glm::dvec3(radius, 0, 0)
                       : laid ? key.along * (0.5 * light.length * key.size)
                              : key.along * radius);
    block.range = static_cast<float>(light.range);
    block.v = to_block(light.kind == LightKind::tube ? glm::dvec3(radius, 0, 0)
                       : round                       ? glm::dvec3(0)
                       : laid ? glm::cross(key.direction, key.along) * (0.5 * light.height * key.size)
                              : glm::cross(key.direction, key.along) * radius);
    const bool spot = light.kind == LightKind::spot;
    block.cos_outer = spot ? static_cast<float>(std::cos(glm::radians(light.outer_deg))) : -1;
    block.cos_inner = spot ? static_cast<float>(std::cos(glm::radians(light.inner_deg))) : -1;
    block.facing = to_block(key.direction);
    // A sphere of radius r and luminance L shows a disc of r^2 pi to everybody.
    const double shown = light.kind == LightKind::sphere ? glm::pi<double>() * radius * radius : 1;
    block.color = to_block(light.color * (light.strength * key.power * shown));
    block.on = light.strength * key.power > 0;
    return block;
}

bool light_moves(const ShotLight& light) {
    const auto other = [](const LightKey& a, const LightKey& b) {
        return a.position != b.position || a.direction != b.direction || a.along != b.along ||
               a.size != b.size || (a.power > 0) != (b.power > 0);
    };
    return std::ranges::adjacent_find(light.keys, other) != light.keys.end();
}

bool shines(const ShotLight& light) {
    return light.kind == LightKind::model || std::ranges::any_of(light.keys, [&](const LightKey& key) {
               return light.strength * key.power > 0;
           });
}

bool has_size(const ShotLight& light) {
    return light.radius > 0 || light.length > 0;
}

}  // namespace penumbra
