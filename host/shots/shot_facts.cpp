// SPDX-License-Identifier: MIT
#include "host/shots/shot_facts.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "host/scene/scene_alpha.h"
#include "host/shots/light_choice.h"

namespace penumbra {

namespace {

// Between two keys below the horizon the sun's path, the shorter arc of a great circle, runs lower still:
// keys suffice. A sun that is a point on the horizon shines on walls.
bool sun_up(const Shot& shot) {
    const int up = shot.analytic ? 2 : 1;  // the axis; analytic receivers face +z
    const double lowest = -std::sin(glm::radians(shot.sun_angular_radius_deg));
    return std::ranges::any_of(shot.sun,
                               [&](const SunKey& key) { return glm::normalize(key.to_sun)[up] >= lowest; });
}

bool sun_moves(const Shot& shot) {
    const auto other_way = [](const SunKey& a, const SunKey& b) {
        return glm::normalize(a.to_sun) != glm::normalize(b.to_sun);
    };
    return std::ranges::adjacent_find(shot.sun, other_way) != shot.sun.end();
}

// Of triangles that are shown. What a texture holds is not looked at: it may scale a factor down to 0.
bool any_roughness(const Scene& scene, const std::function<bool(float least, float most)>& what) {
    const Model& model = scene.model();
    return std::ranges::any_of(scene.instances(), [&](const Instance& instance) {
        return std::ranges::any_of(
            model.meshes[static_cast<size_t>(instance.mesh)].parts, [&](const Part& part) {
                if (part.material < 0) return what(1, 1);
                const Material& material = model.materials[static_cast<size_t>(part.material)];
                const bool textured = material.metallic_roughness_texture >= 0;
                return what(textured ? 0 : material.roughness, material.roughness);
            });
    });
}

}  // namespace

std::map<std::string, bool> shot_facts(const Shot& shot, const Scene& scene, const ShotLight* light) {
    return {{"sun_up", light || sun_up(shot)},
            {"sun_disc", light ? has_size(*light) : shot.sun_angular_radius_deg > 0},
            {"casters", !scene.instances().empty()},
            {"alpha", has_alpha(scene)},
            {"translucent", scene.has_translucent()},
            {"moves", moves(shot) || scene.animated()},
            {"casters_move", objects_move(shot) || scene.animated()},
            {"sun_moves", (light ? light_moves(*light) : sun_moves(shot)) || scene.animated()},
            // Of images of 8 bits, which round: half a step of room.
            {"rough", any_roughness(scene, [](float, float most) { return most > 0.01f - 0.002f; })},
            {"glossy", any_roughness(scene, [](float least, float) { return least < 0.5f + 0.002f; })},
            {"tree", true}};  // the program builds it for whoever walks it
}

}  // namespace penumbra
