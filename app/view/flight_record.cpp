// SPDX-License-Identifier: MIT
#include "app/view/flight_record.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "host/shots/model_shot.h"
#include "host/shots/shot_text.h"

namespace penumbra::viewer {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Json list(const glm::dvec3& v) {
    return Json::array({v.x, v.y, v.z});
}

// The frames that need a key, the first and the last among them (Ramer 1972, Douglas and Peucker 1973: where
// the farthest from the straight course is too far, the course is bent there). `miss`: by how much frame i is
// missed on the course from a to b, in units of what may be.
std::vector<size_t> keys_of(size_t frames, const std::function<double(size_t a, size_t b, size_t i)>& miss) {
    std::vector<size_t> keys{0};
    std::vector<size_t> ends{frames - 1};  // of courses that are still to be looked at, from keys.back() on
    while (!ends.empty()) {
        const size_t a = keys.back(), b = ends.back();
        double worst = 1;
        size_t at = b;
        for (size_t i = a + 1; i < b; ++i)
            if (const double m = miss(a, b, i); m > worst) {
                worst = m;
                at = i;
            }
        if (at != b) {
            ends.push_back(at);
            continue;
        }
        if (b != a) keys.push_back(b);
        ends.pop_back();
    }
    return keys;
}

double share(size_t a, size_t b, size_t i) {
    return static_cast<double>(i - a) / static_cast<double>(b - a);
}

}  // namespace

double FlightRecord::lasting(double fps) const {
    return std::floor(seconds() * fps + 1e-6);
}

std::vector<Stance> FlightRecord::frames(double fps) const {
    std::vector<Stance> stances;
    const size_t count = has_more(fps) ? most_frames : static_cast<size_t>(lasting(fps)) + 1;
    for (size_t frame = 0, after = 0; frame < count; ++frame) {
        const double time = static_cast<double>(frame) / fps;
        while (after + 1 < held_.size() && held_[after].seconds < time) ++after;
        const Held &b = held_[after], &a = held_[after > 0 ? after - 1 : 0];
        const double t =
            b.seconds > a.seconds ? std::clamp((time - a.seconds) / (b.seconds - a.seconds), 0.0, 1.0) : 1;
        Stance& s = stances.emplace_back(b.stance);
        s.camera.position = glm::mix(a.stance.camera.position, b.stance.camera.position, t);
        s.camera.target = glm::mix(a.stance.camera.target, b.stance.camera.target, t);
        s.camera.up = glm::mix(a.stance.camera.up, b.stance.camera.up, t);
        s.sun.to_sun = glm::normalize(glm::mix(a.stance.sun.to_sun, b.stance.sun.to_sun, t));
    }
    return stances;
}

std::string FlightRecord::shot_text(const std::string& base, const Shot& shot, const fs::path& folder) const {
    if (held_.empty()) throw std::logic_error("a recorded flight has a frame");
    const std::vector<Stance> stances = frames(shot.fps);
    constexpr double fine = 1e-3;
    // Hands look a metre ahead, whatever the size of the scene.
    const CameraKey& first = shot.camera.front();
    const double near = fine * std::max(glm::length(first.target - first.position), 1e-9);
    const auto missed_by_camera = [&](size_t a, size_t b, size_t i) {
        const CameraKey &p = stances[a].camera, &q = stances[b].camera, &r = stances[i].camera;
        const double t = share(a, b, i), ahead = fine * std::max(glm::length(r.target - r.position), 1e-9);
        return std::max(
            {glm::length(glm::mix(p.position, q.position, t) - r.position) / std::min(ahead, near),
             glm::length(glm::mix(p.target, q.target, t) - r.target) / ahead,
             glm::length(glm::mix(p.up, q.up, t) - r.up) / fine});
    };
    const auto missed_by_sun = [&](size_t a, size_t b, size_t i) {
        const glm::dvec3 on_course = glm::mix(stances[a].sun.to_sun, stances[b].sun.to_sun, share(a, b, i));
        return glm::length(on_course - stances[i].sun.to_sun) / fine;
    };
    Json json = Json::parse(base);
    if (shot.models.empty()) json["scene"] = seen_from(shot.model, folder);
    for (size_t i = 0; i < shot.models.size(); ++i)
        json["scene"][i]["file"] = seen_from(shot.models[i].file, folder);
    if (const auto* file = std::get_if<EnvironmentFile>(&shot.environment))
        json["environment"]["file"] = seen_from(file->path, folder);
    json.erase("cuts");
    json["frames"] = stances.size();
    Json& camera = json["camera"]["keys"] = Json::array();
    for (const size_t i : keys_of(stances.size(), missed_by_camera)) {
        const CameraKey& key = stances[i].camera;
        camera.push_back({{"frame", i}, {"position", list(key.position)}, {"target", list(key.target)}});
        if (key.up != glm::dvec3(0, 1, 0)) camera.back()["up"] = list(key.up);
    }
    if (shot.has_sun) {
        Json& sun = json["sun"]["keys"] = Json::array();
        for (const size_t i : keys_of(stances.size(), missed_by_sun))
            sun.push_back({{"frame", i}, {"to_sun", list(stances[i].sun.to_sun)}});
    }
    return penumbra::shot_text(json);
}

}  // namespace penumbra::viewer
