// SPDX-License-Identifier: MIT
// Numbers are rounded to what a person would write: the text is the shot, and is read back like any other.
#include "host/shots/model_shot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "host/scene/scene.h"
#include "host/shots/shot_text.h"

namespace penumbra {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr double fov_deg = 40, aspect = 16.0 / 9;
constexpr uint32_t still_frames = 16;  // one round of the jitter
constexpr double fps = 30;
constexpr uint32_t most_frames = 300;

// To six digits, and a multiple of a millionth of `size`: no 1e-17 where a zero is meant.
double rounded(double value, double size) {
    const double step = std::pow(10.0, std::floor(std::log10(std::max(size, 1e-9))) - 5);
    return std::stod(fmt::format("{:.9g}", std::round(value / step) * step));
}

OrderedJson rounded(const glm::dvec3& v, double size) {
    return {rounded(v.x, size), rounded(v.y, size), rounded(v.z, size)};
}

struct View {
    glm::dvec3 position{0}, target{0};
};

// As near as all corners of the box stay in the image, with a margin of a tenth.
View framed(const std::array<glm::dvec3, 2>& box) {
    const double azimuth = glm::radians(-30.0), elevation = glm::radians(20.0);
    const glm::dvec3 back(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                          std::cos(azimuth) * std::cos(elevation));
    const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), back)),
                     up = glm::cross(back, right);
    const double tan_y = 0.9 * std::tan(glm::radians(fov_deg / 2)), tan_x = aspect * tan_y;
    const glm::dvec3 center = 0.5 * (box[0] + box[1]);
    double distance = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 c =
            glm::dvec3(box[corner & 1].x, box[corner >> 1 & 1].y, box[corner >> 2].z) - center;
        distance = std::max({distance, glm::dot(c, back) + std::abs(glm::dot(c, right)) / tan_x,
                             glm::dot(c, back) + std::abs(glm::dot(c, up)) / tan_y});
    }
    return {center + distance * back, center};
}

// Boxes of sixteen moments, joined.
std::array<glm::dvec3, 2> bounds_of(const Scene& scene, uint32_t frames) {
    std::array<glm::dvec3, 2> bounds = scene.bounds();
    for (int i = 1; i <= 16 && scene.animated(); ++i) {
        const auto [low, high] = scene.box(double(frames - 1) * i / 16);
        bounds = {glm::min(bounds[0], low), glm::max(bounds[1], high)};
    }
    return bounds;
}

OrderedJson camera_key(uint32_t frame, const View& view, const glm::dvec3& up, double size) {
    return {{"frame", frame},
            {"position", rounded(view.position, size)},
            {"target", rounded(view.target, size)},
            {"up", rounded(up, 1)}};
}

// The file's own camera: a key per frame where its node moves.
OrderedJson camera_of(const Scene& scene, const ModelCamera& camera, uint32_t frames, double size) {
    OrderedJson keys = OrderedJson::array();
    glm::dmat4 last(0);
    for (uint32_t frame = 0; frame < frames; ++frame) {
        const glm::dmat4 world = scene.transforms(frame)[static_cast<size_t>(camera.node)];
        if (frame > 0 && world == last && keys.size() == frame) continue;
        last = world;
        const glm::dvec3 position(world[3]), ahead = -glm::normalize(glm::dvec3(world[2]));
        keys.push_back(camera_key(frame, {position, position + 0.1 * size * ahead},
                                  glm::normalize(glm::dvec3(world[1])), size));
        if (frame == 0 && !scene.animated()) break;
    }
    if (std::ranges::all_of(keys, [&](const OrderedJson& key) {
            return key["position"] == keys[0]["position"] && key["target"] == keys[0]["target"] &&
                   key["up"] == keys[0]["up"];
        }))
        keys = OrderedJson::array({keys[0]});
    return {{"vertical_fov_deg", rounded(camera.vertical_fov_deg, 100)},
            {"near", rounded(camera.near, camera.near)},
            {"keys", keys}};
}

OrderedJson framing_camera(const std::array<glm::dvec3, 2>& bounds, double size) {
    const View view = framed(bounds);
    const double near = std::max(glm::length(view.position - view.target) / 200, 1e-6);
    return {{"vertical_fov_deg", fov_deg},
            {"near", rounded(near, near)},
            {"keys", OrderedJson::array({camera_key(0, view, {0, 1, 0}, size)})}};
}

}  // namespace

ModelShot make_model_shot(const Model& model, const std::filesystem::path& file,
                          const std::filesystem::path& shot_folder, bool ground) {
    Shot shot;
    shot.fps = fps;
    uint32_t frames = still_frames;
    if (!model.animations.empty() && !model.animations[0].channels.empty()) {
        shot.animation = "0";
        frames = static_cast<uint32_t>(
            std::clamp(std::ceil(model.animations[0].duration_s * fps) + 1, 2.0, double(most_frames)));
    }
    const Scene scene(model, shot);
    ModelShot out;
    out.bounds = bounds_of(scene, frames);
    const auto& [low, high] = out.bounds;
    const double size = std::max(glm::length(high - low), 1e-6);

    OrderedJson json = {{"penumbra_shot", 1}};
    std::error_code none;
    const std::filesystem::path relative = std::filesystem::proximate(file, shot_folder, none);
    json["scene"] = (relative.empty() ? std::filesystem::absolute(file) : relative).generic_string();
    json["size"] = {1280, 720};
    json["frames"] = frames;
    json["fps"] = fps;
    json["camera"] = model.cameras.empty() ? framing_camera(out.bounds, size)
                                           : camera_of(scene, model.cameras[0], frames, size);
    glm::dvec3 to_sun(-0.6, 0.85, 0.15);  // three sides of a box that are seen are of three brightnesses
    if (!model.suns.empty())
        to_sun = glm::normalize(glm::dvec3(scene.transforms(0)[static_cast<size_t>(model.suns[0])][2]));
    json["sun"] = {{"angular_radius_deg", 0.2665},
                   {"keys", OrderedJson::array({{{"frame", 0}, {"to_sun", rounded(to_sun, 1)}}})}};
    for (const ModelLight& light : model.lights)  // of two of a name the first
        if (light.name != "sun") json["lights"][light.name] = {{"kind", "model"}, {"light", light.name}};
    if (!shot.animation.empty()) json["animation"] = 0;
    if (ground) {
        const glm::dvec3 center = 0.5 * (low + high);
        json["ground"] = {{"height", rounded(low.y, size)},
                          {"center", {rounded(center.x, size), rounded(center.z, size)}},
                          {"half_extent", rounded(20 * size, size)}};
    }
    out.text = shot_text(json);
    return out;
}

}  // namespace penumbra
