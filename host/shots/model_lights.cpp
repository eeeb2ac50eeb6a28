// SPDX-License-Identifier: MIT
#include "host/shots/model_lights.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "host/scene/scene.h"

namespace penumbra {
namespace {

void take(const ModelLight& from, ShotLight& light) {
    light.kind = from.spot ? LightKind::spot : LightKind::point;
    if (light.radius < 0) light.radius = from.radius;
    light.strength = from.intensity;
    light.color = from.color;
    if (from.range > 0) light.range = from.range;
    light.inner_deg = from.inner_deg;
    light.outer_deg = from.outer_deg;
}

bool same(const LightKey& a, const LightKey& b) {
    return a.position == b.position && a.direction == b.direction;
}

struct Found {
    ShotLight* light;
    int node;
};

// A key per frame, or one where it stands still.
void add_keys(const std::vector<Found>& lights, const Scene& scene, uint32_t frames) {
    for (uint32_t frame = 0; frame < frames; ++frame) {
        const std::vector<glm::dmat4> world = scene.transforms(frame);
        for (const auto& [light, node] : lights) {
            const glm::dmat4& at = world[static_cast<size_t>(node)];
            LightKey key;
            key.frame = frame;
            key.position = glm::dvec3(at[3]);
            if (const double length = glm::length(glm::dvec3(at[2])); length > 0)
                key.direction = -glm::dvec3(at[2]) / length;
            light->keys.push_back(key);
        }
    }
    for (const auto& [light, node] : lights) {
        auto& keys = light->keys;
        if (std::ranges::all_of(keys, [&](const LightKey& key) { return same(key, keys.front()); }))
            keys.resize(1);
    }
}

// Of a file of thousands each light that is none need not name them all.
std::string some_of(const std::vector<std::string>& names) {
    constexpr size_t most = 32;
    if (names.size() <= most) return fmt::format("{}", fmt::join(names, ", "));
    return fmt::format("{} and {} more", fmt::join(names.begin(), names.begin() + most, ", "),
                       names.size() - most);
}

}  // namespace

bool place_model_lights(Shot& shot, const Scene& scene, Diagnostics& diagnostics) {
    const size_t before = diagnostics.size();
    const std::vector<ModelLight>& lights = scene.model().lights;
    std::vector<std::string> names;
    for (const ModelLight& light : lights) names.push_back(light.name);
    std::vector<Found> placed;
    for (auto& [key, light] : shot.lights) {
        if (light.kind != LightKind::model) continue;
        const auto found = std::ranges::find(names, light.in_model);
        if (found == names.end()) {
            diagnostics.add(
                light.place, "lights." + key + ".light",
                names.empty()
                    ? fmt::format("\"{}\" has no lights but directional ones",
                                  (shot.model.empty() ? shot.file : shot.model).filename().string())
                    : fmt::format("the model has no light named \"{}\"{}; it has {}", light.in_model,
                                  did_you_mean(light.in_model, names), some_of(names)));
            continue;
        }
        const ModelLight& from = lights[static_cast<size_t>(found - names.begin())];
        take(from, light);
        light.keys.clear();
        placed.push_back({&light, from.node});
    }
    if (!placed.empty()) add_keys(placed, scene, scene.animated() || objects_move(shot) ? shot.frames : 1);
    return diagnostics.size() == before;
}

}  // namespace penumbra
