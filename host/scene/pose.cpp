// SPDX-License-Identifier: MIT
// glTF 2.0, appendix C: step, linear (rotations along the shorter arc), cubic Hermite with tangents per
// second.
#include "host/scene/pose.h"

#include <algorithm>
#include <glm/gtc/quaternion.hpp>

namespace penumbra {
namespace {

using Path = AnimationChannel::Path;
using Interpolation = AnimationChannel::Interpolation;

// A key's numbers: `part` 0 the value; of cubic channels 0 the tangent before it, 1 the value, 2 the one
// after.
std::vector<double> numbers(const AnimationChannel& channel, size_t key, size_t width, size_t part) {
    const size_t parts = channel.interpolation == Interpolation::cubic ? 3 : 1;
    const auto first = channel.values.begin() + static_cast<ptrdiff_t>((key * parts + part) * width);
    return {first, first + static_cast<ptrdiff_t>(width)};
}

glm::dquat quaternion(const std::vector<double>& v) {
    return {v[3], v[0], v[1], v[2]};
}

std::vector<double> value_at(const AnimationChannel& channel, double seconds) {
    const bool cubic = channel.interpolation == Interpolation::cubic;
    const size_t width = channel.values.size() / channel.times.size() / (cubic ? 3 : 1),
                 value = cubic ? 1 : 0;
    const auto after = std::ranges::upper_bound(channel.times, seconds);
    if (after == channel.times.begin()) return numbers(channel, 0, width, value);
    const auto a = static_cast<size_t>(after - channel.times.begin()) - 1;
    std::vector<double> from = numbers(channel, a, width, value);
    if (after == channel.times.end() || channel.interpolation == Interpolation::step) return from;
    const std::vector<double> to = numbers(channel, a + 1, width, value);
    const double span = double(channel.times[a + 1]) - channel.times[a],
                 t = (seconds - channel.times[a]) / span;
    if (!cubic && channel.path == Path::rotation) {
        const glm::dquat q = glm::slerp(glm::normalize(quaternion(from)), glm::normalize(quaternion(to)), t);
        return {q.x, q.y, q.z, q.w};
    }
    if (!cubic) {
        for (size_t i = 0; i < width; ++i) from[i] += t * (to[i] - from[i]);
        return from;
    }
    const std::vector<double> out_of = numbers(channel, a, width, 2),
                              into = numbers(channel, a + 1, width, 0);
    const double t2 = t * t, t3 = t2 * t;
    for (size_t i = 0; i < width; ++i)
        from[i] = (2 * t3 - 3 * t2 + 1) * from[i] + span * (t3 - 2 * t2 + t) * out_of[i] +
                  (3 * t2 - 2 * t3) * to[i] + span * (t3 - t2) * into[i];
    return from;
}

void apply(const AnimationChannel& channel, double seconds, NodePose& node) {
    const std::vector<double> v = value_at(channel, seconds);
    switch (channel.path) {
        case Path::translation:
            node.translation = {v[0], v[1], v[2]};
            break;
        case Path::scale:
            node.scale = {v[0], v[1], v[2]};
            break;
        case Path::rotation:
            if (const glm::dquat q = quaternion(v); glm::length(q) > 1e-9) node.rotation = glm::normalize(q);
            break;
        case Path::weights:
            node.weights = v;
    }
}

}  // namespace

std::vector<NodePose> pose_at(const Model& model, int animation, double seconds) {
    std::vector<NodePose> pose;
    pose.reserve(model.nodes.size());
    for (const Node& node : model.nodes)
        pose.push_back({node.translation, node.rotation, node.scale, node.weights});
    if (animation >= 0)
        for (const AnimationChannel& channel : model.animations[static_cast<size_t>(animation)].channels)
            apply(channel, seconds, pose[static_cast<size_t>(channel.node)]);
    for (size_t i = 0; i < pose.size(); ++i)
        if (const int of = model.nodes[i].weights_of; of >= 0)
            pose[i].weights = pose[static_cast<size_t>(of)].weights;
    return pose;
}

std::vector<glm::vec3> deformed_positions(const Part& part, const std::vector<double>& weights,
                                          const std::vector<glm::dmat4>& joints) {
    std::vector<glm::vec3> out;
    out.reserve(part.positions.size());
    const size_t targets = std::min(part.targets.size(), weights.size());
    for (size_t i = 0; i < part.positions.size(); ++i) {
        glm::dvec3 p(part.positions[i]);
        for (size_t k = 0; k < targets; ++k)
            if (weights[k] != 0) p += weights[k] * glm::dvec3(part.targets[k][i]);
        if (!joints.empty() && !part.joints.empty()) {
            glm::dvec3 sum(0);
            for (int k = 0; k < 4; ++k)
                if (const double weight = part.weights[i][k]; weight > 0)
                    sum += weight *
                           glm::dvec3(joints[part.joints[i][static_cast<size_t>(k)]] * glm::dvec4(p, 1));
            p = sum;
        }
        out.emplace_back(p);
    }
    return out;
}

}  // namespace penumbra
