// SPDX-License-Identifier: MIT
// A shot: what to look at, from where, under which sun, for how many frames. Keys interpolate linearly and
// are held outside; everything is double precision until it is relative to the camera.
#pragma once

#include <array>
#include <filesystem>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "host/truth/analytic_scene.h"
#include "penumbra/diagnostic.h"
#include "penumbra/frame_block.h"

namespace penumbra {

struct Model;

struct CameraKey {
    double frame = 0;
    glm::dvec3 position{0}, target{0}, up{0, 1, 0};
};

struct SunKey {
    double frame = 0;
    glm::dvec3 to_sun{0, 1, 0};  // any length but zero
};

struct ObjectKey {
    double frame = 0;
    glm::dvec3 translation{0}, rotation_deg{0};
};

struct ObjectMotion {
    Place place;  // of the object's name in the shot
    std::vector<ObjectKey> keys;
};

// What is seen beyond the scene, in radiance. A sky depends on the height of a direction alone: linear in it,
// from `low` straight down to `high` straight up; else as `shade` draws it, from the horizon, in the square
// root of the height.
struct EnvironmentSky {
    bool linear = false;
    glm::dvec3 low{0.512, 0.6612, 0.912}, high{0.1408, 0.3192, 0.72};
};
struct EnvironmentFile {
    std::filesystem::path path;  // EXR, resolved against the shot's folder
    double scale = 1;
};

struct Shot {
    std::string name;  // the file's name without ".shot.json"
    std::filesystem::path file;
    std::filesystem::path model;            // glTF, resolved against the shot's folder
    std::optional<AnalyticScene> analytic;  // instead of a model and a camera
    std::array<uint32_t, 2> size{1280, 720};
    uint32_t frames = 1;
    std::vector<uint32_t> cuts;  // frames that have no history, rising
    double fps = 60;
    double vertical_fov_deg = 60, near = 0.05;
    std::vector<CameraKey> camera;
    double sun_angular_radius_deg = 0.2665;  // the sun as seen from the Earth, mean over the year
    std::vector<SunKey> sun;
    std::map<std::string, ObjectMotion> objects;  // by the name of a glTF node
    std::variant<EnvironmentSky, EnvironmentFile> environment;
    glm::dvec3 origin{0};
    uint32_t seed = 0;
};

// Reads and checks a shot; the scene file itself is not opened.
std::optional<Shot> read_shot(const std::filesystem::path& path, Diagnostics& diagnostics);

// Every object must name a node of the model, and that node's transform must be translate * rotate * scale.
bool check_objects(const Shot& shot, const Model& model, Diagnostics& diagnostics);

struct SunState {
    glm::dvec3 to_sun{0, 1, 0};  // unit, world axes
    double angular_radius = 0;   // radians
};

// The shot at a frame number (between frames too). The camera's position has the shot's origin added.
Camera camera_at(const Shot& shot, double frame, double aspect);
SunState sun_at(const Shot& shot, double frame);
ObjectKey object_at(const ObjectMotion& motion, double frame);

// Whether anything that a motion vector sees ever changes (the fact `moves`).
bool moves(const Shot& shot);

// Halton(2, 3), 16 phases, centred, one pixel wide: the sub-pixel offset of a frame's raster in uv units.
std::array<double, 2> halton_jitter(uint32_t frame, std::array<uint32_t, 2> size);

}  // namespace penumbra
