// SPDX-License-Identifier: MIT
// What a tuning shot is made for, drawn from a seed: how wide its penumbrae are, how large the sun, what
// moves and how fast. The draws of consecutive seeds are spread evenly over their ranges (multiples of
// irrational numbers), so that a few seeds cover them.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace penumbra::tuning {

enum class CameraMotion { still, pan, orbit, dolly, roll, cut };
inline constexpr uint32_t camera_motions = 6;

inline constexpr uint32_t families = 7;
inline constexpr uint32_t frames = 32, cut_frame = 14;
inline constexpr double fps = 60, vertical_fov_deg = 50;
inline constexpr double focal_px = 193;  // of an image of 320x180, for which all lengths in pixels are said

// What differs between families.
struct Ranges {
    uint32_t family = 0;               // index, so that families differ under one seed
    double distance_m = 8;             // from the camera to the middle of what it looks at
    glm::dvec2 caster_share{0.04, 1};  // way from caster to receiver, as a share of that distance
    glm::dvec2 sun_elevation_deg{25, 65};
    glm::dvec2 camera_elevation_deg{22, 45};
};

struct Setting {
    uint32_t seed = 0;      // of the family's own draws
    double distance_m = 0;  // as in Ranges
    double caster_m = 0;    // typical way from a caster to its receiver along the light
    double sun_radius_deg = 0;
    double width_px = 0;      // of a penumbra so far from its caster, across the light, in the image's middle
    glm::dvec3 to_sun{0};     // unit
    glm::dvec3 to_camera{0};  // unit, from the middle
    CameraMotion camera_motion{};
    double camera_px = 0;  // per frame
    double sun_px = 0;     // per frame, of the shadows; 0: the sun stands still
    double object_px = 0;  // per frame; 0: objects stand still

    // The point from which a caster `way_m` up the light shades `receiver`.
    glm::dvec3 above(const glm::dvec3& receiver, double way_m) const { return receiver + way_m * to_sun; }
};

Setting make_setting(const Ranges& ranges, uint32_t seed);

// Three numbers of a shot.
std::string vector_text(const glm::dvec3& v);

// A shot's text up to the end of its camera.
std::string shot_head(const std::string& model_file, const std::string& camera_keys);

// The shot's text. `movable`: names of the nodes that may move.
std::string shot_text(const Setting& setting, const std::string& model_file,
                      const std::vector<std::string>& movable);

}  // namespace penumbra::tuning
