// SPDX-License-Identifier: MIT
#include "host/shots/shot_facts.h"

#include <algorithm>
#include <cmath>

#include "host/scene/scene_alpha.h"
#include "host/shots/light_choice.h"

namespace penumbra {

namespace {

// Between two keys below the horizon the sun's path, the shorter arc of a great circle, runs lower still:
// keys suffice.
bool sun_up(const Shot& shot) {
    const int up = shot.analytic ? 2 : 1;  // the axis; analytic receivers face +z
    const double lowest = -std::sin(glm::radians(shot.sun_angular_radius_deg));
    return std::ranges::any_of(shot.sun,
                               [&](const SunKey& key) { return glm::normalize(key.to_sun)[up] > lowest; });
}

bool sun_moves(const Shot& shot) {
    const auto other_way = [](const SunKey& a, const SunKey& b) {
        return glm::normalize(a.to_sun) != glm::normalize(b.to_sun);
    };
    return std::ranges::adjacent_find(shot.sun, other_way) != shot.sun.end();
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
            {"tree", true}};  // the program builds it for whoever walks it
}

}  // namespace penumbra
