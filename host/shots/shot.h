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
#include <string_view>
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
    glm::dvec3 to_sun{0, 1, 0};  // any length but zero, which says nothing: unit vectors are interpolated
};

struct ObjectKey {
    double frame = 0;
    glm::dvec3 translation{0}, rotation_deg{0};
};

struct ObjectMotion {
    Place place;  // of the object's name in the shot
    std::vector<ObjectKey> keys;
};

// A light that is near, with what it is called in the shot.
// One of the model's is a point or a spot once place_model_lights() has found it.
enum class LightKind { point, sphere, disc, rectangle, tube, spot, model };
const char* name_of(LightKind kind);

// Directions are of any length but zero; `along` is a rectangle's width or a tube's axis.
struct LightKey {
    double frame = 0;
    glm::dvec3 position{0}, direction{0, -1, 0}, along{1, 0, 0};
    double size = 1, power = 1;  // factors of the light's own; no power: it is off
};

inline constexpr size_t most_lights = 256;  // of a shot: each is looked at in every frame

struct ShotLight {
    Place place;  // of its name in the shot
    LightKind kind = LightKind::point;
    std::string in_model;                  // the name of a light of the model, which says the rest
    double radius = 0, length = 0;         // metres; of a rectangle the length is its width
    double height = 0;                     // of a rectangle
    double strength = 100;                 // candelas of points and spots, else candelas per square metre
    glm::dvec3 color{1};                   // linear
    double range = 1e9;                    // metres
    double inner_deg = 0, outer_deg = 45;  // of a spot's cone, from its axis
    std::vector<LightKey> keys;
};

// A horizontal square that is no part of the model: something for its shadow to fall on.
struct Ground {
    double height = 0;               // y
    std::array<double, 2> center{};  // x, z
    double half_extent = 1;          // metres
};
inline constexpr const char* ground_name = "ground";  // of its node

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

// One of several models: moved to where its place says, and known by its name: of its node "lid" the name
// is "NAME/lid" then, and NAME that of a node above all of it.
struct PlacedModel {
    std::filesystem::path file;  // glTF, resolved against the shot's folder
    std::string name;            // no two of a shot's are the same
    ObjectKey place;
    double scale = 1;
};

struct Shot {
    std::string name;  // shot_name() of its file
    std::filesystem::path file;
    std::filesystem::path model;            // glTF, resolved against the shot's folder
    std::vector<PlacedModel> models;        // instead of one model
    std::optional<AnalyticScene> analytic;  // instead of a model and a camera
    std::array<uint32_t, 2> size{1280, 720};
    uint32_t frames = 1;
    std::vector<uint32_t> cuts;  // frames that have no history, rising
    double fps = 60;
    double vertical_fov_deg = 60, near = 0.05;
    std::vector<CameraKey> camera;
    double sun_angular_radius_deg = 0.2665;  // the sun as seen from the Earth, mean over the year
    std::vector<SunKey> sun;
    bool has_sun = true;                          // else there are only lights
    std::map<std::string, ShotLight> lights;      // by their names
    std::map<std::string, ObjectMotion> objects;  // by the name of a glTF node
    std::string
        animation;  // of the model: its name or number; empty: none is played. Frame 0 is its second 0
    std::optional<Ground> ground;
    std::variant<EnvironmentSky, EnvironmentFile> environment;
    glm::dvec3 origin{0};
    uint32_t seed = 0;
};

// A file as a shot, or another JSON, that stands in `folder` (empty: the current one) names it.
std::filesystem::path from_folder(const std::filesystem::path& folder, const std::string& file);

// A file's name without ".shot.json".
std::string shot_name(const std::filesystem::path& file);

// Reads and checks a shot; the scene file itself is not opened.
std::optional<Shot> read_shot(const std::filesystem::path& path, Diagnostics& diagnostics);
// The same from a text that is to become the file `path`.
std::optional<Shot> parse_shot(std::string_view text, const std::filesystem::path& path,
                               Diagnostics& diagnostics);

// Every object must name one node of the model.
bool check_objects(const Shot& shot, const Model& model, Diagnostics& diagnostics);

// The model's animation of that name, or else of that number; -1 for "". Throws std::runtime_error, with the
// names that there are, where there is none.
int find_animation(const Model& model, const std::string& animation);

struct SunState {
    glm::dvec3 to_sun{0, 1, 0};  // unit, world axes
    double angular_radius = 0;   // radians
};

// The shot at a frame number (between frames too). The camera's position has the shot's origin added.
Camera camera_at(const Shot& shot, double frame, double aspect);
SunState sun_at(const Shot& shot, double frame);
LightKey light_at(const ShotLight& light, double frame);  // axes unit and at right angles
ObjectKey object_at(const ObjectMotion& motion, double frame);

// Whether anything that a motion vector sees ever changes (the fact `moves`).
bool moves(const Shot& shot);
bool camera_moves(const Shot& shot);
bool objects_move(const Shot& shot);  // without the camera

// Halton(2, 3), 16 phases, centred, one pixel wide: the sub-pixel offset of a frame's raster in uv units.
std::array<double, 2> halton_jitter(uint32_t frame, std::array<uint32_t, 2> size);

}  // namespace penumbra
