// SPDX-License-Identifier: MIT
#include "host/generated/tuning/setting.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host/generated/noise.h"

namespace penumbra::tuning {

namespace {

constexpr double least_sun_deg = 0.1, most_sun_deg = 3;
constexpr double least_width_px = 0.4, most_width_px = 20;
constexpr double least_speed_px = 0.15, most_speed_px = 5;

// The powers of 1 / 1.13472, the root of x^6 = x + 1, in 2^-32: their multiples fill five dimensions evenly.
constexpr std::array<uint32_t, 5> steps{3785032107u, 3335640777u, 2939605023u, 2590590015u, 2283013049u};
enum Dimension { width, way, camera_speed, object_speed, elevation };

double evenly(uint32_t turn, Dimension dimension) {
    return (turn * steps[dimension] + pcg(dimension)) * 0x1p-32;
}

double between(double low, double high, double t) {
    return low * std::pow(high / low, t);
}

glm::dvec3 direction(double azimuth_deg, double elevation_deg) {
    const double a = glm::radians(azimuth_deg), e = glm::radians(elevation_deg);
    return {std::cos(e) * std::sin(a), std::sin(e), std::cos(e) * std::cos(a)};
}

std::string camera_key(double frame, const glm::dvec3& position, const glm::dvec3& target,
                       const glm::dvec3& up) {
    return fmt::format(R"(      {{ "frame": {}, "position": {}, "target": {}, "up": {} }})", frame,
                       vector_text(position), vector_text(target), vector_text(up));
}

glm::dvec3 turned(const glm::dvec3& v, const glm::dvec3& axis, double angle) {
    return v * std::cos(angle) + glm::cross(axis, v) * std::sin(angle) +
           axis * glm::dot(axis, v) * (1 - std::cos(angle));
}

std::string camera_keys(const Setting& setting) {
    const glm::dvec3 up(0, 1, 0), middle(0, 0.04 * setting.distance_m, 0);
    const glm::dvec3 away = setting.distance_m * setting.to_camera;
    const glm::dvec3 right = glm::normalize(glm::cross(up, setting.to_camera));
    const double metres = setting.camera_px * setting.distance_m / focal_px * (frames - 1);
    // The motion's middle is the setting's view; a turn is cut into pieces, for keys are joined by straight
    // lines.
    std::string text;
    const auto add = [&](double frame, const glm::dvec3& position, const glm::dvec3& target,
                         const glm::dvec3& top) {
        text += (text.empty() ? "" : ",\n") + camera_key(frame, position, target, top);
    };
    constexpr int pieces = 4;
    for (int i = 0; i <= pieces; ++i) {
        const double t = double(i) / pieces - 0.5, frame = std::floor(i * (frames - 1.0) / pieces);
        switch (setting.camera_motion) {
            case CameraMotion::pan: {
                const glm::dvec3 step = std::min(metres, 0.6 * setting.distance_m) * t * right;
                add(frame, middle + away + step, middle + step, up);
                break;
            }
            case CameraMotion::orbit: {
                const double angle = std::min(metres / setting.distance_m, 0.6) * t;
                add(frame, middle + turned(away, up, angle), middle, up);
                break;
            }
            // A point at the image's border, 160 pixels from the middle, moves that fast.
            case CameraMotion::dolly: {
                const double share = std::min(setting.camera_px * (frames - 1) / 160, 0.5) * t;
                add(frame, middle + away * (1 - share), middle, up);
                break;
            }
            case CameraMotion::roll: {
                const double angle = std::min(setting.camera_px * (frames - 1) / 160, 0.5) * t;
                add(frame, middle + away, middle, turned(up, setting.to_camera, angle));
                break;
            }
            case CameraMotion::still:
                if (i == 0) add(0, middle + away, middle, up);
                break;
            case CameraMotion::cut:
                if (i != 0) break;
                add(cut_frame - 1, middle + turned(away, up, 0.9) * 0.9, middle + 0.1 * away, up);
                add(cut_frame, middle + away, middle, up);
                break;
        }
    }
    return text;
}

std::string sun_keys(const Setting& setting) {
    const auto key = [&](double frame, double angle) {
        return fmt::format(R"(      {{ "frame": {}, "to_sun": {} }})", frame,
                           vector_text(turned(setting.to_sun, {0, 1, 0}, angle)));
    };
    if (setting.sun_px == 0) return key(0, 0);
    const double angle = setting.sun_px * setting.distance_m / focal_px / setting.caster_m * (frames - 1);
    return key(0, -0.5 * angle) + ",\n" + key(frames - 1, 0.5 * angle);
}

// Objects travel across the light and turn so that a point a twentieth of the distance off the axis is as
// fast.
std::string object_keys(const Setting& setting, const std::vector<std::string>& movable) {
    if (setting.object_px == 0) return "";
    SceneRandom random(setting.seed ^ 0x51c3u);
    const double metres = setting.object_px * setting.distance_m / focal_px * (frames - 1);
    const double degrees = glm::degrees(metres / (0.05 * setting.distance_m));
    std::string text;
    for (size_t i = 0; i < movable.size(); ++i) {
        // Drawn one by one: compilers differ in which argument of a call comes first.
        glm::dvec3 any;
        for (const int axis : {2, 1, 0}) any[axis] = axis == 1 ? random.in(-0.3, 0.3) : random.in(-1, 1);
        const glm::dvec3 way = glm::normalize(glm::cross(setting.to_sun, any));
        const double share = i % 3 == 1 ? 0 : std::min(metres, 0.5 * setting.distance_m) * 0.5;
        glm::dvec3 turn(0, i % 3 == 0 ? 0 : degrees, 0);
        for (const int axis : {2, 0})
            if (i % 3 != 0) turn[axis] = degrees * random.in(-0.2, 0.2);
        text += fmt::format(R"({}    "{}": {{
      "keys": [
        {{ "frame": 0, "translation": {}, "rotation_deg": [0, 0, 0] }},
        {{ "frame": {}, "translation": {}, "rotation_deg": {} }}
      ]
    }})",
                            text.empty() ? "" : ",\n", movable[i], vector_text(-share * way), frames - 1,
                            vector_text(share * way), vector_text(turn));
    }
    return fmt::format("  \"objects\": {{\n{}\n  }},\n", text);
}

}  // namespace

std::string vector_text(const glm::dvec3& v) {
    return fmt::format("[{:.5f}, {:.5f}, {:.5f}]", v.x, v.y, v.z);
}

Setting make_setting(const Ranges& ranges, uint32_t seed) {
    const uint32_t turn = ranges.family + families * seed;
    SceneRandom random(pcg(turn) ^ seed);
    Setting out;
    out.seed = pcg(turn ^ 0x7e57u);
    out.distance_m = ranges.distance_m;

    // The width comes first; caster and sun share it as their ranges allow.
    const double wanted = between(least_width_px, most_width_px, evenly(turn, width));
    const auto share_under = [&](double sun_deg) {
        return wanted / (2 * focal_px * std::tan(glm::radians(sun_deg)));
    };
    const auto in_range = [&](double share) {
        return std::clamp(share, ranges.caster_share.x, ranges.caster_share.y);
    };
    const double share =
        between(in_range(share_under(most_sun_deg)), in_range(share_under(least_sun_deg)), evenly(turn, way));
    out.caster_m = share * ranges.distance_m;
    out.sun_radius_deg =
        std::clamp(glm::degrees(std::atan(wanted / (2 * focal_px * share))), least_sun_deg, most_sun_deg);
    out.width_px = 2 * focal_px * share * std::tan(glm::radians(out.sun_radius_deg));

    // The sun stands beyond what is looked at or beside it, so that casters high above do not cover it.
    const double camera_azimuth = random.in(-180, 180);
    const double aside = random.in(70, 170), beside = random.in(-1, 1) < 0 ? -aside : aside;
    out.to_camera = direction(camera_azimuth, glm::mix(ranges.camera_elevation_deg.x,
                                                       ranges.camera_elevation_deg.y, random.in(0, 1)));
    out.to_sun =
        direction(camera_azimuth + beside,
                  glm::mix(ranges.sun_elevation_deg.x, ranges.sun_elevation_deg.y, evenly(turn, elevation)));

    out.camera_motion = static_cast<CameraMotion>(turn % camera_motions);
    out.camera_px = between(least_speed_px, most_speed_px, evenly(turn, camera_speed));
    if (turn % 4 == 3) out.sun_px = between(0.02, 0.3, evenly(turn, object_speed));
    if (turn % 2 == 0 || out.camera_motion == CameraMotion::still)
        out.object_px = between(least_speed_px, most_speed_px, evenly(turn, object_speed));
    return out;
}

std::string shot_head(const std::string& model_file, const std::string& camera_keys) {
    return fmt::format(R"({{
  "penumbra_shot": 1,
  "scene": "{}",
  "size": [640, 360],
  "frames": {},
  "fps": {},
  "camera": {{
    "vertical_fov_deg": {},
    "near": 0.05,
    "keys": [
{}
    ]
  }},
)",
                       model_file, frames, fps, vertical_fov_deg, camera_keys);
}

std::string shot_text(const Setting& setting, const std::string& model_file,
                      const std::vector<std::string>& movable) {
    return shot_head(model_file, camera_keys(setting)) +
           fmt::format(R"(  "sun": {{
    "angular_radius_deg": {:.5f},
    "keys": [
{}
    ]
  }},
{}  "origin": [0, 0, 0],
  "seed": 0
}}
)",
                       setting.sun_radius_deg, sun_keys(setting), object_keys(setting, movable));
}

}  // namespace penumbra::tuning
