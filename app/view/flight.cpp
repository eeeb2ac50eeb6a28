// SPDX-License-Identifier: MIT
#include "app/view/flight.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <numbers>

namespace penumbra::viewer {
namespace {

constexpr double steepest = 89.0 / 180 * std::numbers::pi;  // straight up, nothing says which way is up

glm::dvec3 forward(double yaw, double pitch) {
    return {std::sin(yaw) * std::cos(pitch), std::sin(pitch), -std::cos(yaw) * std::cos(pitch)};
}

// To cross what the camera looks at takes some seconds, whether that is a ring or a town.
double first_speed(const Shot& shot) {
    const CameraKey& key = shot.camera.front();
    return std::max(glm::length(key.target - key.position) / 4, 1e-6);
}

}  // namespace

Flight::Flight(const Shot& shot) : shot_(shot), plays_(shot.frames > 1), speed_(first_speed(shot)) {}

void Flight::start_over() {
    hands_.reset();
    to_sun_.reset();
    moment_ = 0;
}

void Flight::tick() {
    if (plays_) moment_ = moment_ + 1 < shot_.frames ? moment_ + 1 : 0;
}

Flight::Hands Flight::taken() const {
    const Camera camera = camera_at(shot_, moment_, 1);
    const glm::dvec3 ahead = -glm::make_vec3(camera.world_from_view.data() + 6);
    return {glm::make_vec3(camera.position.data()) - shot_.origin, std::atan2(ahead.x, -ahead.z),
            std::asin(std::clamp(ahead.y, -1.0, 1.0))};
}

void Flight::steer(const FlightInput& input) {
    speed_ = std::clamp(speed_ * input.faster, 1e-6, 1e6);
    if (input.sun != glm::dvec2(0)) {
        const glm::dvec3 now = stance().sun.to_sun;
        const double azimuth = std::atan2(now.x, now.z) + input.sun.x;
        const double elevation =
            std::clamp(std::asin(std::clamp(now.y, -1.0, 1.0)) + input.sun.y, -steepest, steepest);
        to_sun_ = glm::dvec3(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                             std::cos(azimuth) * std::cos(elevation));
    }
    if (input.move == glm::dvec3(0) && input.look == glm::dvec2(0)) return;
    if (!hands_) hands_ = taken();
    Hands& h = *hands_;
    h.yaw = std::remainder(h.yaw + input.look.x, 2 * std::numbers::pi);
    h.pitch = std::clamp(h.pitch + input.look.y, -steepest, steepest);
    const glm::dvec3 ahead = forward(h.yaw, h.pitch);
    const glm::dvec3 right(std::cos(h.yaw), 0, std::sin(h.yaw));
    glm::dvec3 way = input.move.x * right + input.move.y * glm::dvec3(0, 1, 0) + input.move.z * ahead;
    if (const double length = glm::length(way); length > 1) way /= length;
    h.position += way * (speed_ * (input.hurry ? 5 : 1) * input.seconds);
}

Stance Flight::stance() const {
    Stance stance;
    stance.moment = moment_;
    stance.sun.to_sun = to_sun_ ? *to_sun_ : sun_at(shot_, moment_).to_sun;
    if (hands_) {
        stance.camera.position = hands_->position;
        stance.camera.target = hands_->position + forward(hands_->yaw, hands_->pitch);
        return stance;
    }
    const Camera camera = camera_at(shot_, moment_, 1);
    stance.camera.position = glm::make_vec3(camera.position.data()) - shot_.origin;
    stance.camera.target = stance.camera.position - glm::make_vec3(camera.world_from_view.data() + 6);
    stance.camera.up = glm::make_vec3(camera.world_from_view.data() + 3);
    return stance;
}

}  // namespace penumbra::viewer
