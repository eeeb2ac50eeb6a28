// SPDX-License-Identifier: MIT
// Which of a shot's lights masks are of, and what a frame's block says of it.
#pragma once

#include <string>

#include "host/shots/shot.h"
#include "shaders/common/blocks.h"

namespace penumbra {

// Of which lights masks may be.
enum class LightsFor { any, sun, near };

// The light that a name means, or without one the shot's only light of those that masks may be of; nullptr is
// the sun. An unknown name, and none where the shot has several, are errors.
struct ChosenLight {
    std::string name = "sun";
    const ShotLight* light = nullptr;
};
std::optional<ChosenLight> choose_light(const Shot& shot, const std::string& name, Diagnostics& diagnostics,
                                        LightsFor wanted = LightsFor::any);

// For a pipeline that takes several: the one of a name, or without one all, in their names' order; the sun is
// none of them. Empty after an error.
std::vector<std::string> choose_lights(const Shot& shot, const std::string& name, Diagnostics& diagnostics);

// Where it is as seen from `camera`, both in the world without the shot's origin.
blocks::Light light_block(const ShotLight& light, double frame, const glm::dvec3& camera);

// Whether anything of it ever changes.
bool light_moves(const ShotLight& light);
// Whether it is on at some time; one of the model is taken to be.
bool shines(const ShotLight& light);
// Whether it is more than a point.
bool has_size(const ShotLight& light);

}  // namespace penumbra
