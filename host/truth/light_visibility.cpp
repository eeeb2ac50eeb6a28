// SPDX-License-Identifier: MIT
#include "host/truth/light_visibility.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/truth/concentric_disc.h"
#include "host/truth/sun_visibility.h"

namespace penumbra {
namespace {

using std::numbers::pi;

glm::dvec3 vector(const blocks::vec3& v) {
    return {v.v[0], v.v[1], v.v[2]};
}

double cross(const glm::dvec2& a, const glm::dvec2& b) {
    return a.x * b.y - a.y * b.x;
}

double area(std::span<const glm::dvec2> polygon) {
    double twice = 0;
    for (size_t i = 0; i < polygon.size(); ++i) twice += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
    return 0.5 * twice;
}

// Signed area between the unit disc's centre and what of a segment lies in the disc, and of the sectors
// before and behind it.
double disc_part(const glm::dvec2& p, const glm::dvec2& q) {
    const auto sector = [](const glm::dvec2& a, const glm::dvec2& b) {
        return 0.5 * std::atan2(cross(a, b), glm::dot(a, b));
    };
    const glm::dvec2 d = q - p;
    const double a = glm::dot(d, d), b = glm::dot(p, d), c = glm::dot(p, p) - 1, root = b * b - a * c;
    if (!(a > 0)) return 0;
    if (!(root > 0)) return sector(p, q);
    const double in = (-b - std::sqrt(root)) / a, out = (-b + std::sqrt(root)) / a;
    if (in >= 1 || out <= 0) return sector(p, q);
    const glm::dvec2 from = in > 0 ? p + in * d : p, to = out < 1 ? p + out * d : q;
    return (in > 0 ? sector(p, from) : 0) + 0.5 * cross(from, to) + (out < 1 ? sector(to, q) : 0);
}

}  // namespace

double disc_share(std::span<const glm::dvec2> polygon) {
    double sum = 0;
    for (size_t i = 0; i < polygon.size(); ++i)
        sum += disc_part(polygon[i], polygon[(i + 1) % polygon.size()]);
    return std::abs(sum) / pi;
}

double square_share(std::span<const glm::dvec2> polygon) {
    std::vector<glm::dvec2> left(polygon.begin(), polygon.end());
    for (int side = 0; side < 4; ++side) {  // Sutherland and Hodgman 1974
        const int axis = side / 2;
        const double sign = side % 2 ? -1 : 1;
        const auto height = [&](const glm::dvec2& p) { return 1 - sign * p[axis]; };
        std::vector<glm::dvec2> clipped;
        for (size_t i = 0; i < left.size(); ++i) {
            const glm::dvec2 &a = left[i], &b = left[(i + 1) % left.size()];
            if (height(a) >= 0) clipped.push_back(a);
            if ((height(a) >= 0) != (height(b) >= 0))
                clipped.push_back(a + (b - a) * (height(a) / (height(a) - height(b))));
        }
        left = std::move(clipped);
    }
    return std::abs(area(left)) / 4;
}

NearLight::NearLight(const blocks::Light& block)
    : kind_(block.kind),
      centre_(vector(block.centre)),
      u_(vector(block.u)),
      v_(vector(block.v)),
      facing_(vector(block.facing)),
      range_(block.range),
      cos_outer_(block.cos_outer),
      on_(block.on != 0) {}

bool NearLight::reaches(const glm::dvec3& receiver) const {
    const glm::dvec3 d = receiver - centre_;
    const double distance = glm::length(d), height = glm::dot(d, facing_);
    if (!on_ || !(distance < range_)) return false;
    if (kind_ == blocks::LIGHT_DISC || kind_ == blocks::LIGHT_RECTANGLE)
        return height > blocks::LIGHT_EDGE_ON * (distance + std::max(glm::length(u_), glm::length(v_)));
    if (kind_ != blocks::LIGHT_SPHERE) return true;
    return distance > u_.x && (cos_outer_ <= -1 || height > cos_outer_ * distance);
}

glm::dvec3 NearLight::across(const glm::dvec3& receiver) const {
    if (kind_ != blocks::LIGHT_TUBE) return v_;
    const glm::dvec3 side = glm::cross(u_, centre_ - receiver);
    return v_.x / std::max(glm::length(side), 1e-15) * side;
}

glm::dvec3 NearLight::target(const glm::dvec3& receiver, const glm::dvec2& u) const {
    const bool square = kind_ == blocks::LIGHT_RECTANGLE || kind_ == blocks::LIGHT_TUBE;
    const glm::dvec2 point = square ? 2.0 * u - 1.0 : concentric_disc(u.x, u.y);
    if (kind_ != blocks::LIGHT_SPHERE) return centre_ + point.x * u_ + point.y * across(receiver);
    // Evenly over the cap that the receiver sees: 1 - cos grows with the square of the disc's radius.
    const glm::dvec3 to_centre = centre_ - receiver;
    const double distance = glm::length(to_centre), radius = u_.x;
    const glm::dvec3 axis = to_centre / distance;
    const glm::dvec3 helper = std::abs(axis.z) < 0.7 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
    const glm::dvec3 x = glm::normalize(glm::cross(helper, axis)), y = glm::cross(axis, x);
    const double half = std::sin(0.5 * std::asin(std::min(radius / distance, 1.0)));
    const double r2 = glm::dot(point, point), versine = 2 * half * half * r2;
    const double per_radius = half * std::sqrt(2 * (2 - versine));
    const glm::dvec3 direction = per_radius * (point.x * x + point.y * y) + (1 - versine) * axis;
    const double along = glm::dot(direction, to_centre), off2 = distance * distance - along * along;
    return receiver + (along - std::sqrt(std::max(radius * radius - off2, 0.0))) * direction;
}

double NearLight::visibility(const glm::dvec3& receiver, std::span<const glm::dvec3> polygon) const {
    std::vector<glm::dvec3> seen;
    for (const glm::dvec3& p : polygon) seen.push_back(p - receiver);
    const glm::dvec3 to_centre = centre_ - receiver;
    if (kind_ == blocks::LIGHT_SPHERE) {
        const double distance = glm::length(to_centre);
        return polygon_visibility(to_centre / distance, std::asin(std::min(u_.x / distance, 1.0)), seen);
    }
    // Seen from the receiver, the polygon's shadow on the light's plane, in units of its half axes.
    const glm::dvec3 w = across(receiver), n = glm::cross(u_, w);
    std::vector<glm::dvec2> shadow;
    for (const glm::dvec3& p : seen) {
        const glm::dvec3 on_light = p * (glm::dot(n, to_centre) / glm::dot(n, p)) - to_centre;
        shadow.emplace_back(glm::dot(on_light, u_) / glm::dot(u_, u_),
                            glm::dot(on_light, w) / glm::dot(w, w));
    }
    return 1 - (kind_ == blocks::LIGHT_DISC ? disc_share(shadow) : square_share(shadow));
}

}  // namespace penumbra
