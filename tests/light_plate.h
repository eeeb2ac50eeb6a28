// SPDX-License-Identifier: MIT
// A floor below a plate that hangs before a light of any kind, and what each pixel shows of the floor: closed
// forms say what the plate hides of the light.
#pragma once

#include <cmath>
#include <glm/gtc/type_ptr.hpp>

#include "app/light_truth.h"
#include "host/models/glb_writer.h"
#include "host/models/shapes.h"
#include "host/truth/light_visibility.h"
#include "penumbra/shadow_nodes.h"
#include "tests/gpu_test.h"
#include "tests/scene_file.h"
#include "tests/view_run.h"

namespace penumbra::test {

namespace fs = std::filesystem;
inline constexpr double plate_m = 1;  // its height

inline Model plate_over_floor() {
    Model model;
    model.materials = {{{0.8f, 0.8f, 0.8f, 1}, -1}};
    add(model, "floor", ground(10, 10, 4, 4), 0);
    add(model, "plate", ground(0.4, 0.3, 1, 1), 0);
    model.nodes.back().translation = {0, plate_m, 0};
    return model;
}

inline const std::array<glm::dvec3, 4> plate{
    glm::dvec3(-0.4, plate_m, -0.3), {0.4, plate_m, -0.3}, {0.4, plate_m, 0.3}, {-0.4, plate_m, 0.3}};

inline Shot shot_with(LightKind kind, std::array<uint32_t, 2> size) {
    static const SceneFile file("plate.glb", to_glb(plate_over_floor()));
    ShotLight light;
    light.kind = kind;
    light.radius = kind == LightKind::tube ? 0.1 : 0.4;
    light.length = kind == LightKind::rectangle ? 1 : 1.5;
    light.height = 0.5;
    light.outer_deg = 60;
    light.range = 3.4;
    light.keys = {{0, {0.2, 2.6, 0.1}, {0.1, -1, 0.1}, {1, 0.1, 0.3}, 1, 1}};
    Shot shot;
    shot.name = "plate";
    shot.model = file.path();
    shot.size = size;
    shot.frames = 4;
    shot.camera = {{0, {0, 0.9, 2.6}, {0, 0, 0}, {0, 1, 0}}};
    shot.has_sun = false;
    shot.sun = {{0, {0, 1, 0}}};
    shot.lights["lamp"] = light;
    return shot;
}

// What each pixel shows of the floor; nothing elsewhere.
inline std::vector<std::optional<glm::dvec3>> floor_points(const Shot& shot) {
    const Camera camera = camera_at(shot, 0, double(shot.size[0]) / shot.size[1]);
    const glm::dmat3 axes = glm::make_mat3(camera.world_from_view.data());
    const glm::dvec3 eye = glm::make_vec3(camera.position.data());
    std::vector<std::optional<glm::dvec3>> points;
    for (uint32_t y = 0; y < shot.size[1]; ++y)
        for (uint32_t x = 0; x < shot.size[0]; ++x) {
            const double u = 2 * (x + 0.5) / shot.size[0] - 1, v = 2 * (y + 0.5) / shot.size[1] - 1;
            const glm::dvec3 way =
                axes * glm::dvec3(u / camera.clip_from_view[0], v / camera.clip_from_view[5], -1);
            const double t = -eye.y / way.y, at_plate = (plate_m - eye.y) / way.y;
            const glm::dvec3 p = eye + t * way, q = eye + at_plate * way;
            const bool behind = at_plate > 0 && at_plate < t && std::abs(q.x) < 0.41 && std::abs(q.z) < 0.31;
            const bool floor = t > 0 && std::abs(p.x) < 9 && std::abs(p.z) < 9 && !behind;
            points.push_back(floor ? std::optional(p) : std::nullopt);
        }
    return points;
}

inline std::unique_ptr<Session> open(const Shot& shot, const char* name,
                                     const std::vector<std::string>& settings, Diagnostics& diagnostics) {
    const auto pipeline = load_pipeline(
        fs::path(PENUMBRA_SOURCE_DIR) / "pipelines" / (std::string(name) + ".json"), settings, diagnostics);
    const auto checked = pipeline ? check(*pipeline, test_nodes(), diagnostics) : std::nullopt;
    if (!checked) return nullptr;
    SessionOptions options;
    options.size = shot.size;
    options.jitter = false;
    options.captures = checked->output_names();
    options.light = "lamp";
    std::vector<std::string> warnings;
    return Session::open(gpu(), test_nodes(), *checked, shot, options, diagnostics, warnings);
}

}  // namespace penumbra::test
