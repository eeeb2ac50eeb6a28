// SPDX-License-Identifier: MIT
// The shot at a point in time. Rotations of objects are interpolated by their angles, directions by their
// vectors.
#include "host/shots/shot.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <limits>
#include <map>
#include <stdexcept>

#include "host/models/model.h"
#include "host/truth/analytic.h"

namespace penumbra {

namespace {

// The two keys around `frame` and the weight of the second; both the same outside the keys.
template <class Key>
struct Between {
    const Key& a;
    const Key& b;
    double t;
};

template <class Key>
Between<Key> around(const std::vector<Key>& keys, double frame) {
    const auto after = std::ranges::upper_bound(keys, frame, {}, &Key::frame);
    if (after == keys.begin()) return {keys.front(), keys.front(), 0};
    if (after == keys.end()) return {keys.back(), keys.back(), 0};
    const Key& a = *(after - 1);
    return {a, *after, (frame - a.frame) / (after->frame - a.frame)};
}

// The unit vector along `v`, or NaN where `v` is too short to have a direction: read_shot() looks for that.
glm::dvec3 direction(const glm::dvec3& v) {
    const double length = glm::length(v);
    return v / (length > 1e-9 ? length : std::numeric_limits<double>::quiet_NaN());
}

double radical_inverse(uint32_t base, uint32_t i) {
    double result = 0, digit = 1.0 / base;
    for (; i > 0; i /= base, digit /= base) result += (i % base) * digit;
    return result;
}

template <class Key>
bool any_differs(const std::vector<Key>& keys, auto same) {
    return std::ranges::adjacent_find(keys, [&](const Key& a, const Key& b) { return !same(a, b); }) !=
           keys.end();
}

}  // namespace

Camera camera_at(const Shot& shot, double frame, double aspect) {
    if (shot.analytic) return analytic_camera(shot);
    const auto [a, b, t] = around(shot.camera, frame);
    const glm::dvec3 position = glm::mix(a.position, b.position, t);
    const glm::dvec3 back = direction(position - glm::mix(a.target, b.target, t));
    const glm::dvec3 up = direction(glm::mix(a.up, b.up, t));
    const glm::dvec3 right = direction(glm::cross(up, back));

    Camera camera;
    const glm::dmat3 world_from_view(right, glm::cross(back, right), back);
    std::copy_n(glm::value_ptr(world_from_view), 9, camera.world_from_view.begin());
    for (int i = 0; i < 3; ++i) camera.position[static_cast<size_t>(i)] = shot.origin[i] + position[i];
    camera.clip_from_view = perspective(glm::radians(shot.vertical_fov_deg), aspect, shot.near);
    camera.near_m = shot.near;
    return camera;
}

SunState sun_at(const Shot& shot, double frame) {
    // Unit vectors are interpolated, so that a key's length has no say in how fast the sun passes it.
    const auto [a, b, t] = around(shot.sun, frame);
    return {.to_sun = direction(glm::mix(glm::normalize(a.to_sun), glm::normalize(b.to_sun), t)),
            .angular_radius = glm::radians(shot.sun_angular_radius_deg)};
}

LightKey light_at(const ShotLight& light, double frame) {
    const auto [a, b, t] = around(light.keys, frame);
    const glm::dvec3 facing =
        direction(glm::mix(glm::normalize(a.direction), glm::normalize(b.direction), t));
    const glm::dvec3 along = glm::mix(glm::normalize(a.along), glm::normalize(b.along), t);
    // A tube faces nowhere, and a disc or a spot has no width to be laid along.
    const bool free = light.kind != LightKind::rectangle && light.kind != LightKind::tube;
    const glm::dvec3 helper = std::abs(facing.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 wanted = free ? helper : along;
    return {.frame = frame,
            .position = glm::mix(a.position, b.position, t),
            .direction = facing,
            .along = light.kind == LightKind::tube ? direction(along)
                                                   : direction(wanted - glm::dot(wanted, facing) * facing),
            .size = glm::mix(a.size, b.size, t),
            .power = glm::mix(a.power, b.power, t)};
}

ObjectKey object_at(const ObjectMotion& motion, double frame) {
    const auto [a, b, t] = around(motion.keys, frame);
    return {.frame = frame,
            .translation = glm::mix(a.translation, b.translation, t),
            .rotation_deg = glm::mix(a.rotation_deg, b.rotation_deg, t)};
}

bool camera_moves(const Shot& shot) {
    return any_differs(shot.camera, [](const CameraKey& a, const CameraKey& b) {
        return a.position == b.position && a.target == b.target && a.up == b.up;
    });
}

bool moves(const Shot& shot) {
    return objects_move(shot) || camera_moves(shot);
}

bool objects_move(const Shot& shot) {
    return std::ranges::any_of(shot.objects, [](const auto& object) {
        return any_differs(object.second.keys, [](const ObjectKey& a, const ObjectKey& b) {
            return a.translation == b.translation && a.rotation_deg == b.rotation_deg;
        });
    });
}

bool check_objects(const Shot& shot, const Model& model, Diagnostics& diagnostics) {
    const size_t before = diagnostics.size();
    std::map<std::string, size_t> nodes;
    for (const Node& node : model.nodes)
        if (!node.name.empty()) ++nodes[node.name];
    std::vector<std::string> names;
    for (const auto& [name, matches] : nodes) names.push_back(name);
    for (const auto& [name, motion] : shot.objects) {
        const auto found = nodes.find(name);
        const std::string path = "objects." + name;
        if (found == nodes.end()) {
            // Who gets many names wrong reads the first suggestions: each looks at all nodes.
            const bool suggest = diagnostics.size() - before < 16;
            diagnostics.add(
                motion.place, path,
                "the scene has no node named \"" + name + "\"" + (suggest ? did_you_mean(name, names) : ""));
        } else if (found->second > 1) {
            diagnostics.add(
                motion.place, path,
                "the scene has " + std::to_string(found->second) + " nodes named \"" + name + "\"");
        }
    }
    return diagnostics.size() == before;
}

int find_animation(const Model& model, const std::string& animation) {
    if (animation.empty()) return -1;
    std::vector<std::string> names;
    for (size_t i = 0; i < model.animations.size(); ++i) {
        if (model.animations[i].name == animation) return static_cast<int>(i);
        names.push_back(model.animations[i].name);
    }
    for (size_t i = 0; i < model.animations.size(); ++i)
        if (std::to_string(i) == animation) return static_cast<int>(i);
    throw std::runtime_error("the scene has " + std::to_string(names.size()) + " animations, and none is \"" +
                             animation + "\"" + did_you_mean(animation, names));
}

std::array<double, 2> halton_jitter(uint32_t frame, std::array<uint32_t, 2> size) {
    // Index 0 is (0, 0) in every base; starting at 1 leaves the corner out.
    const uint32_t phase = frame % 16 + 1;
    return {(radical_inverse(2, phase) - 0.5) / size[0], (radical_inverse(3, phase) - 0.5) / size[1]};
}

}  // namespace penumbra
