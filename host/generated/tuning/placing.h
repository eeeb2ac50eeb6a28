// SPDX-License-Identifier: MIT
// Where the families of tuning scenes put things, and how they turn them. Whoever draws several numbers does
// so in statements of their own: compilers differ in which argument of a call comes first.
#pragma once

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "host/generated/noise.h"
#include "host/generated/tuning/setting.h"
#include "host/models/shapes.h"

namespace penumbra::tuning {

// A point of the floor that the camera sees.
inline glm::dvec3 floor_point(const Setting& setting, SceneRandom& random) {
    const glm::dvec3 forward = glm::normalize(glm::dvec3(setting.to_camera.x, 0, setting.to_camera.z));
    const glm::dvec3 right(forward.z, 0, -forward.x);
    const double across = random.in(-0.42, 0.42), along = random.in(-0.35, 0.3);
    return setting.distance_m * (across * right + along * forward);
}

// A caster's way to what it shades: from half to twice the setting's.
inline double caster_way(const Setting& setting, SceneRandom& random) {
    return setting.caster_m * std::exp2(random.in(-1, 1));
}

// Where a caster of some floor point stands.
inline glm::dvec3 caster_place(const Setting& setting, SceneRandom& random) {
    const double way = caster_way(setting, random);
    return setting.above(floor_point(setting, random), way);
}

inline double between(double low, double high, SceneRandom& random) {
    return low * std::pow(high / low, random.in(0, 1));
}

inline glm::dmat4 any_rotation(SceneRandom& random) {
    const double z = random.in(-1, 1), a = random.in(0, glm::two_pi<double>()), r = std::sqrt(1 - z * z);
    return glm::rotate(glm::dmat4(1), random.in(0, glm::two_pi<double>()),
                       glm::dvec3(r * std::cos(a), r * std::sin(a), z));
}

inline glm::dmat4 heading(double angle) {
    return glm::rotate(glm::dmat4(1), angle, glm::dvec3(0, 1, 0));
}

inline Shape moved(Shape shape, const glm::dmat4& rotation, const glm::dvec3& place) {
    shape.transform(glm::translate(glm::dmat4(1), place) * rotation);
    return shape;
}

inline Shape bar(const glm::dvec3& half_size) {
    return box(-half_size, half_size);
}

}  // namespace penumbra::tuning
