// SPDX-License-Identifier: MIT
#include "app/gates/radiance_room.h"

#include <fmt/format.h>
#include <unistd.h>

#include "host/images/image_file.h"
#include "host/models/glb_writer.h"
#include "host/models/model_builder.h"

namespace penumbra::gates {
namespace {

constexpr double half_width = 4, half_depth = 3;

Material of_color(float value) {
    Material material;
    material.base_color = {value, value, value, 1};
    return material;
}

// Metal strips from left to right; with `walls` a striped one behind them and a lamp in front of it.
Model floor_of_strips(bool walls) {
    std::vector<Material> materials;
    for (const float roughness : strip_roughness) {
        Material& metal = materials.emplace_back(of_color(0.9f));
        metal.roughness = roughness;
        metal.metallic = 1;
    }
    const int dark = static_cast<int>(materials.size()), bright = dark + 1, lamp = dark + 2;
    materials.push_back(of_color(0.05f));
    materials.push_back(of_color(0.85f));
    materials.push_back(of_color(0));
    materials.back().emissive = {6, 5, 4};
    ModelBuilder builder(materials);
    const double width = 2 * half_width / double(strip_roughness.size());
    for (size_t i = 0; i < strip_roughness.size(); ++i) {
        Shape strip = ground(width / 2, half_depth, 1, 1);
        glm::dmat4 place(1);
        place[3] = {-half_width + width * (double(i) + 0.5), 0, 0, 1};
        strip.transform(place);
        builder.solid("strip", strip, static_cast<int>(i));
    }
    if (!walls) return builder.take();
    constexpr int stripes = 16;
    for (int i = 0; i < stripes; ++i) {
        const double x = -half_width + 2 * half_width * i / stripes;
        builder.solid("wall", box({x, 0, -half_depth - 0.2}, {x + 2 * half_width / stripes, 3, -half_depth}),
                      i % 2 ? dark : bright);
    }
    // Each strip has as much of it.
    builder.solid("lamp", box({-half_width, 1, -half_depth + 0.1}, {half_width, 1.3, -half_depth + 0.2}),
                  lamp);
    return builder.take();
}

}  // namespace

RadianceScenes::RadianceScenes()
    : folder_(std::filesystem::temp_directory_path() / fmt::format("penumbra_gates_{}", getpid())) {
    std::filesystem::create_directories(folder_);
    write_file(folder_ / "floor.glb", to_glb(floor_of_strips(false)));
    write_file(folder_ / "room.glb", to_glb(floor_of_strips(true)));
}

RadianceScenes::~RadianceScenes() {
    std::error_code none;
    std::filesystem::remove_all(folder_, none);
}

Shot RadianceScenes::night(const char* model, std::array<uint32_t, 2> size, uint32_t frames,
                           bool moving) const {
    Shot shot;
    shot.name = "gate";
    shot.model = folder_ / model;
    shot.size = size;
    shot.frames = frames;
    shot.camera = {{0, {0, 1.5, 3.2}, {0, 0.3, -1}, {0, 1, 0}}};
    if (moving) shot.camera.push_back({16, {0.5, 1.45, 3.1}, {0.3, 0.3, -1}, {0, 1, 0}});
    shot.sun = {{0, {0, -1, 0}}};  // none is up
    return shot;
}

Shot RadianceScenes::furnace(std::array<uint32_t, 2> size, uint32_t frames) const {
    Shot shot = night("floor.glb", size, frames, true);
    shot.environment = EnvironmentSky{true, glm::dvec3(1), glm::dvec3(1)};
    return shot;
}

Shot RadianceScenes::room(std::array<uint32_t, 2> size, uint32_t frames, bool moving) const {
    Shot shot = night("room.glb", size, frames, moving);
    shot.environment = EnvironmentSky{true, glm::dvec3(0.05), glm::dvec3(0.3)};
    return shot;
}

Shot RadianceScenes::lamp_off(std::array<uint32_t, 2> size) const {
    Shot shot = room(size, last_off_frame + 1, false);
    ObjectMotion& lamp = shot.objects["lamp"];
    lamp.keys.resize(2);
    lamp.keys[0].frame = lamp_off_frame - 1;
    lamp.keys[1].frame = lamp_off_frame;
    lamp.keys[1].translation = {0, -500, 0};
    return shot;
}

}  // namespace penumbra::gates
