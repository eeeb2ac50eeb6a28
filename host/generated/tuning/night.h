// SPDX-License-Identifier: MIT
// Rooms and yards at night, drawn from a seed like the families of tuning scenes: surfaces of any roughness,
// bodies that shine, some behind a shade, and lamps of every kind. For reflections, indirect light and lamps;
// no constant is tuned on any of them.
#pragma once

#include <string>

#include "host/models/model.h"

namespace penumbra::tuning {

inline constexpr const char* night_family = "night";

struct NightScene {
    std::string name;  // night_SEED
    Model model;
    std::string shot;
};

NightScene make_night_scene(uint32_t seed);

}  // namespace penumbra::tuning
