// SPDX-License-Identifier: MIT
#include "host/materials/emitters.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <tuple>

namespace penumbra {
namespace {

constexpr size_t most_bodies = 32;
constexpr double least_fill = 1.0 / 16;  // of the sphere's surface

double luminance(const std::array<float, 3>& color) {
    return 0.2126 * double(color[0]) + 0.7152 * double(color[1]) + 0.0722 * double(color[2]);
}

// Per triangle the first corner of those that hang together with it, at places that are equal to the bit.
std::vector<uint32_t> bodies_of(const Part& part) {
    std::vector<uint32_t> parent(part.positions.size());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](uint32_t i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];
        return i;
    };
    std::map<std::tuple<float, float, float>, uint32_t> places;
    // Corners alone: what no triangle uses may be no number, which cannot be ordered.
    for (const uint32_t i : std::set<uint32_t>(part.indices.begin(), part.indices.end())) {
        const glm::vec3& p = part.positions[i];
        parent[i] = places.try_emplace({p.x, p.y, p.z}, i).first->second;
    }
    for (size_t i = 0; i < part.indices.size(); i += 3)
        for (size_t k = 1; k < 3; ++k) parent[root(part.indices[i + k])] = root(part.indices[i]);
    std::vector<uint32_t> out;
    for (size_t i = 0; i < part.indices.size(); i += 3) out.push_back(root(part.indices[i]));
    return out;
}

struct Extent {
    glm::dvec3 low{std::numeric_limits<double>::max()}, high{std::numeric_limits<double>::lowest()};
    double area = 0;

    void add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
        low = glm::min(low, glm::min(a, glm::min(b, c)));
        high = glm::max(high, glm::max(a, glm::max(b, c)));
        area += 0.5 * glm::length(glm::cross(b - a, c - a));
    }
};

}  // namespace

Emitters::Emitters(const Scene& scene) : scene_(&scene) {
    for (const Instance& instance : scene.instances())
        for (const Part& part : scene.model().meshes[static_cast<size_t>(instance.mesh)].parts)
            add(scene, instance, part);
    if (bodies_.size() <= most_bodies) return;
    std::ranges::stable_sort(bodies_, std::greater{}, [](const Body& b) { return b.area * b.luminance; });
    bodies_.resize(most_bodies);
}

void Emitters::add(const Scene& scene, const Instance& instance, const Part& part) {
    if (part.material < 0 || scene.deforms(instance, part) || scene.translucent(part)) return;
    const Material& material = scene.model().materials[static_cast<size_t>(part.material)];
    const double brightness = luminance(material.emissive);
    if (!(brightness > 0) || material.emissive_texture >= 0 || material.alpha_cutoff) return;
    const std::vector<uint32_t> bodies = bodies_of(part);
    const auto corner = [&](size_t i) { return part.origin + glm::dvec3(part.positions[part.indices[i]]); };
    std::map<uint32_t, Extent> extents;
    for (size_t t = 0; t < bodies.size(); ++t)
        extents[bodies[t]].add(corner(3 * t), corner(3 * t + 1), corner(3 * t + 2));
    std::map<uint32_t, double> radii;
    for (size_t i = 0; i < part.indices.size(); ++i) {
        const Extent& extent = extents.at(bodies[i / 3]);
        double& radius = radii[bodies[i / 3]];
        radius = std::max(radius, glm::distance(corner(i), 0.5 * (extent.low + extent.high)));
    }
    for (const auto& [body, extent] : extents) {
        const double radius = radii.at(body);
        if (extent.area > least_fill * 4 * std::numbers::pi * radius * radius)
            bodies_.push_back({static_cast<size_t>(instance.node), 0.5 * (extent.low + extent.high), radius,
                               extent.area, brightness});
    }
}

std::vector<Texel> Emitters::texels(double frame, const glm::dvec3& camera) const {
    if (bodies_.empty()) return {};
    const std::vector<glm::dmat4> world = scene_->transforms(frame);
    const auto bits = [](double value) { return std::bit_cast<uint32_t>(static_cast<float>(value)); };
    std::vector<Texel> out;
    for (const Body& body : bodies_) {
        const glm::dmat4& matrix = world[body.node];
        const glm::dvec3 center = glm::dvec3(matrix * glm::dvec4(body.center, 1)) - camera;
        const double scale =
            std::max({glm::length(matrix[0]), glm::length(matrix[1]), glm::length(matrix[2])});
        out.push_back({bits(center.x), bits(center.y), bits(center.z), bits(scale * body.radius)});
        out.push_back({bits(body.luminance), bits(0.25 * scale * scale * body.area), 0, 0});
    }
    return out;
}

}  // namespace penumbra
