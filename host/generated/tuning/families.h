// SPDX-License-Identifier: MIT
// Scenes that constants are tuned on, and that no report shows: each family builds one from a seed, always
// the same bytes. docs/scenes.md says what each is for.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "host/generated/tuning/setting.h"
#include "host/models/model_builder.h"

namespace penumbra::tuning {

// What a family adds to: the model, and the names of the nodes that may move.
struct Stage {
    ModelBuilder builder;
    std::vector<std::string> movable{};

    // One that may move, or turn about `place`: the shape is about the origin.
    void add_movable(Shape shape, int material, const glm::dvec3& place);
};

struct Family {
    const char* name;
    Ranges ranges;
    void (*build)(const Setting& setting, Stage& stage);
};

void build_edges(const Setting& setting, Stage& stage);
void build_fences(const Setting& setting, Stage& stage);
void build_leaves(const Setting& setting, Stage& stage);
void build_cards(const Setting& setting, Stage& stage);
void build_spheres(const Setting& setting, Stage& stage);
void build_hills(const Setting& setting, Stage& stage);
void build_room(const Setting& setting, Stage& stage);

inline constexpr std::array<Family, families> all_families{
    {{"edges", {.family = 0}, build_edges},
     {"fences", {.family = 1}, build_fences},
     {"leaves", {.family = 2}, build_leaves},
     {"cards", {.family = 3}, build_cards},
     {"spheres", {.family = 4, .distance_m = 6}, build_spheres},
     {"hills",
      {.family = 5,
       .distance_m = 60,
       .caster_share = {0.04, 0.5},
       .sun_elevation_deg = {6, 18},
       .camera_elevation_deg = {10, 25}},
      build_hills},
     {"room",
      {.family = 6,
       .distance_m = 5,
       .caster_share = {0.25, 0.9},
       .sun_elevation_deg = {20, 45},
       .camera_elevation_deg = {15, 28}},
      build_room}}};

// Those that scenes/tuning/ holds, of each family: far apart in width, unlike in what moves. Every other seed
// gives a shot that nothing was tuned on.
inline constexpr std::array<uint32_t, 2> committed_seeds{1, 4};

struct TuningScene {
    std::string name;  // FAMILY_SEED: of the model's file and of the shot's
    Setting setting;
    Model model;
    std::string shot;
};

// Rounds what a model's triangles stand on, so that its bytes are the same on every machine.
void snap(Model& model);

TuningScene make_tuning_scene(const Family& family, uint32_t seed);

}  // namespace penumbra::tuning
