// SPDX-License-Identifier: MIT
// The shadow ray of each pixel, made anew in double precision from what the node trace reads (depth, normal,
// noise tile, sun), so that its answers can be judged ray by ray.
#pragma once

#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <vector>

#include "app/captured_values.h"
#include "tests/bvh_oracle.h"

namespace penumbra::test {

using NormalTexel = std::array<float, 2>;  // of receiver_normal

inline uint32_t hash(uint32_t v) {  // PCG, as blue_noise.glsl names its source
    const uint32_t state = v * 747796405u + 2891336453u;
    const uint32_t word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737u;
    return word >> 22 ^ word;
}

class RayMaker {
  public:
    RayMaker(const Session& session, const NodeSet& nodes, const StandaloneFrame& frame)
        : frame_(frame), size_(frame.description.size), seed_(session.seed()), noise_(16384) {
        std::memcpy(noise_.data(), nodes.find("trace")->tables[0].texels.data(), noise_.size() * 4);
    }

    Ray ray(uint32_t x, uint32_t y, float depth, NormalTexel normal_texel) const {
        return ray(x, y, depth, normal_texel, sample(x, y));
    }

    // Towards the point of the sun's disc that `u` of the unit square stands for.
    Ray ray(uint32_t x, uint32_t y, float depth, NormalTexel normal_texel, const glm::dvec2& u) const {
        const glm::dvec3 origin = start(x, y, depth, normal_texel), direction = sun_direction(u);
        Ray ray{};
        for (int c = 0; c < 3; ++c) {
            ray.origin[c] = static_cast<float>(origin[c]);
            ray.direction[c] = static_cast<float>(direction[c]);
        }
        ray.t_min = 0;
        ray.t_max = INFINITY;
        return ray;
    }

    // Where a pixel's rays start, in the scene's frame: off the surface, of a depth that is of its centre.
    glm::dvec3 start(uint32_t x, uint32_t y, float depth, NormalTexel normal_texel) const {
        const glm::dvec3 relative = relative_point(x, y, depth), n = normal(normal_texel);
        const glm::dvec3 in_scene = relative + vector(frame_.scene.camera_from_origin.v);
        const glm::dvec3 largest = glm::max(glm::abs(relative), glm::abs(in_scene));
        const double offset = 3 * 0x1p-23 * (largest.x + largest.y + largest.z + double(depth)) +
                              8 * 0x1p-24 * double(depth) * facing(n, relative);
        return in_scene + n * offset;
    }

    // The same ray from where beams and rays that ask nobody start: ahead by what a pixel may show past a
    // triangle's end.
    Ray from_ahead(Ray ray, uint32_t x, uint32_t y, float depth, NormalTexel normal_texel) const {
        const glm::dvec3 to_sun = vector(frame_.sun.to_sun.v);
        const double cosine = glm::dot(normal(normal_texel), to_sun);
        const double ahead = cosine > 0 ? std::min(0.25 / cosine, 1.0) : 0.0;
        const glm::dvec3 origin =
            start(x, y, depth, normal_texel) + ahead * beyond_edge_m(x, y, depth, normal_texel) * to_sun;
        for (int c = 0; c < 3; ++c) ray.origin[c] = static_cast<float>(origin[c]);
        return ray;
    }

    // The same ray from where what it meets no longer depends on whether the viewer looks through it
    // (common/bvh.glsl): eight times as far as the start may lie past the end of what it is on.
    Ray past_what_is_asked(Ray ray, uint32_t x, uint32_t y, float depth, NormalTexel normal_texel) const {
        ray.t_min = static_cast<float>(8 * beyond_edge_m(x, y, depth, normal_texel));
        return ray;
    }

    // Cosine between a ray and its surface's normal: one that is not positive points into the surface.
    static double slope(const Ray& ray, NormalTexel normal_texel) {
        return glm::dot(normal(normal_texel),
                        glm::dvec3(ray.direction[0], ray.direction[1], ray.direction[2]));
    }

    // The pixel's two numbers.
    glm::dvec2 sample(uint32_t x, uint32_t y) const {
        const uint32_t o = hash(seed_), first = hash(seed_ ^ 0x9E3779B9u), second = hash(first);
        const uint32_t texel = noise_[((y + (o >> 7 & 127)) & 127) * 128 + ((x + (o & 127)) & 127)];
        const uint32_t frame = frame_.description.index;
        const auto wave = [](uint32_t turns) { return turns < 1u << 31 ? turns : 0u - turns; };
        const uint32_t u = (texel << 16) + 4 * wave(x * 15793805u) + 4 * wave(y * 15348762u) + x * 2717909u +
                           y * 4291279664u + frame * 2512169321u + first,
                       v = (texel & 0xFFFF0000u) + 4 * wave(x * 14621613u) + wave(y * 80021003u) +
                           x * 4294306274u + y * 4294571354u + frame * 1316278627u + second;
        return {(u >> 8) * 0x1p-24, (v >> 8) * 0x1p-24};
    }

    // The faces of an octahedron, the lower four folded out over the square's corners.
    static glm::dvec3 normal(NormalTexel texel) {
        glm::dvec3 n(texel[0], texel[1], 1 - std::abs(double(texel[0])) - std::abs(double(texel[1])));
        const double fold = std::max(-n.z, 0.0);
        n.x -= std::copysign(fold, n.x);
        n.y -= std::copysign(fold, n.y);
        return glm::normalize(n);
    }

  private:
    static glm::dvec3 vector(const float (&v)[3]) { return {v[0], v[1], v[2]}; }

    glm::dvec3 relative_point(uint32_t x, uint32_t y, double z) const {
        const Camera& camera = frame_.description.camera;
        const glm::dmat4 clip = glm::make_mat4(camera.clip_from_view.data());
        const glm::dmat3 world = glm::make_mat3(camera.world_from_view.data());
        const glm::dvec2 uv = (glm::dvec2(x, y) + 0.5) / glm::dvec2(size_[0], size_[1]) -
                              glm::dvec2(frame_.description.jitter[0], frame_.description.jitter[1]);
        const glm::dvec2 ndc = 2.0 * uv - 1.0;
        return world * glm::dvec3(z * ndc.x / clip[0].x, z * ndc.y / clip[1].y, -z);
    }
    double beyond_edge_m(uint32_t x, uint32_t y, double depth, NormalTexel normal_texel) const {
        const double span = 2.0 * depth / (size_[1] * std::abs(frame_.description.camera.clip_from_view[5]));
        const double grid_px = std::ldexp(0.5, -int(frame_.description.sub_pixel_bits));
        return span * grid_px / std::max(facing(normal(normal_texel), relative_point(x, y, depth)), 1.0 / 64);
    }
    static double facing(const glm::dvec3& n, const glm::dvec3& relative) {
        return std::abs(glm::dot(n, -glm::normalize(relative)));
    }

    // Uniform over the cap, by polar coordinates of the disc (sources in sun_sample.glsl).
    glm::dvec3 sun_direction(const glm::dvec2& u) const {
        const glm::dvec3 s = vector(frame_.sun.to_sun.v);
        const double angle = 2 * M_PI * (u.x - 0.5);
        const glm::dvec2 disc = std::sqrt(u.y) * glm::dvec2(std::cos(angle), std::sin(angle));
        const double one_minus_cos = (1 - std::cos(static_cast<double>(frame_.sun.angular_radius))) * u.y;
        const double sine = std::sqrt(one_minus_cos * (2 - one_minus_cos));
        const double length = std::sqrt(u.y);
        const double sign = s.z >= 0 ? 1 : -1, a = -1 / (sign + s.z), b = s.x * s.y * a;
        const glm::dvec3 t1(1 + sign * s.x * s.x * a, sign * b, -sign * s.x),
            t2(b, sign + s.y * s.y * a, -s.y);
        const glm::dvec2 across = length > 0 ? disc * (sine / length) : glm::dvec2(0);
        return t1 * across.x + t2 * across.y + s * (1 - one_minus_cos);
    }

    const StandaloneFrame& frame_;
    std::array<uint32_t, 2> size_;
    uint32_t seed_;
    std::vector<uint32_t> noise_;
};

}  // namespace penumbra::test
