// SPDX-License-Identifier: MIT
// Sun directions: the exact cap map (as shaders/common/sun_sample.glsl) of a Kronecker sequence with the
// plastic number's two steps, turned per pixel, so that 64 rays see a sliver of one percent of the sun in two
// pixels of three.
#include "host/scene/scene_facts.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/packing.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <map>
#include <numeric>

#include "host/generated/noise.h"
#include "host/scene/scene_alpha.h"

namespace penumbra {

namespace {

constexpr uint32_t rays_per_pixel = 64, frame_step = 21;
constexpr double history_tolerance = 0.01;  // of the view depth

struct Basis {
    glm::dvec3 x, y;
};

Basis across(const glm::dvec3& axis) {
    const glm::dvec3 x =
        glm::normalize(glm::cross(axis, std::abs(axis.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0)));
    return {x, glm::cross(axis, x)};
}

// The narrow side of the thinnest rectangle round the points, over directions 3 degrees apart.
double narrow_extent(const std::vector<glm::dvec2>& points) {
    double narrowest = std::numeric_limits<double>::infinity();
    for (int degrees = 0; degrees < 180; degrees += 3) {
        const double angle = glm::radians(double(degrees));
        const glm::dvec2 d(std::cos(angle), std::sin(angle));
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (const glm::dvec2& p : points) {
            low = std::min(low, glm::dot(p, d));
            high = std::max(high, glm::dot(p, d));
        }
        narrowest = std::min(narrowest, high - low);
    }
    return narrowest;
}

// One frame's G-buffer on the CPU.
struct Frame {
    uint32_t width = 0, height = 0;
    std::vector<float> depth;  // reverse Z
    std::vector<glm::vec4> normal, motion;
};

template <class T>
std::vector<T> values(const std::vector<std::byte>& bytes) {
    std::vector<T> out(bytes.size() / sizeof(T));
    std::memcpy(out.data(), bytes.data(), bytes.size());
    return out;
}

std::vector<glm::vec4> halves(const std::vector<std::byte>& bytes) {
    std::vector<glm::vec4> out(bytes.size() / 8);
    for (size_t i = 0; i < out.size(); ++i) {
        uint64_t word = 0;
        std::memcpy(&word, &bytes[i * 8], 8);
        out[i] = glm::unpackHalf4x16(word);
    }
    return out;
}

Frame render(Device& device, StandaloneHost& host, uint32_t index) {
    const StandaloneFrame description = host.frame(index, index == 0);
    device.run([&](VkCommandBuffer commands) { host.record(commands, description); });
    const GBufferImages& images = host.images();
    const auto read = [&](const GpuImage& image) {
        return read_image(device, image.get(), image.format, image.extent, GBuffer::final_layout);
    };
    return {images.depth.extent.width, images.depth.extent.height, values<float>(read(images.depth)),
            values<glm::vec4>(read(images.normal)), halves(read(images.motion))};
}

// Whether the previous frame saw the point: inside its image, and one of the four texels around it at the
// depth expected there.
bool has_history(const Frame& previous, double near, const glm::dvec2& uv, double expected) {
    if (!(uv.x > 0 && uv.x < 1 && uv.y > 0 && uv.y < 1)) return false;
    const double px = uv.x * previous.width - 0.5, py = uv.y * previous.height - 0.5;
    for (int k = 0; k < 4; ++k) {
        const int x = std::clamp(int(std::floor(px)) + (k & 1), 0, int(previous.width) - 1);
        const int y = std::clamp(int(std::floor(py)) + (k >> 1), 0, int(previous.height) - 1);
        const float d = previous.depth[size_t(y) * previous.width + size_t(x)];
        if (d > 0 && std::abs(near / d - expected) <= history_tolerance * expected) return true;
    }
    return false;
}

struct Tally {
    size_t pixels = 0, receivers = 0, penumbra = 0, disoccluded = 0;
};

class Measurer {
  public:
    Measurer(Device& device, StandaloneHost& host) : device_(device), host_(host) {}

    void frame(uint32_t index, Tally& tally) {
        const Frame previous = render(device_, host_, index - 1), now = render(device_, host_, index);
        const FrameDescription description = host_.frame(index, false).description;
        const std::vector<Triangle> triangles = host_.scene().triangles(index);
        const Bvh bvh = build_bvh(triangles);
        const SceneAlpha alpha = make_scene_alpha(host_.scene());
        const auto leaf_words = alpha_leaf_words(alpha, bvh, triangles);
        const Casters casters{bvh, has_alpha(host_.scene()) ? alpha_test(alpha, leaf_words) : AlphaTest{}};
        const SunState sun = sun_at(host_.shot(), index);
        const glm::dmat3 world_from_view = glm::make_mat3(description.camera.world_from_view.data());
        const auto& clip = description.camera.clip_from_view;
        const glm::dvec3 camera = glm::make_vec3(description.camera.position.data()) - host_.shot().origin -
                                  host_.scene().bvh_origin();
        tally.pixels += now.depth.size();
        for (uint32_t y = 0; y < now.height; ++y)
            for (uint32_t x = 0; x < now.width; ++x) {
                const size_t i = size_t(y) * now.width + x;
                if (!(now.depth[i] > 0)) continue;
                ++tally.receivers;
                const double z = description.camera.near_m / now.depth[i];
                const glm::dvec2 uv((x + 0.5) / now.width, (y + 0.5) / now.height);
                const glm::dvec4 motion(now.motion[i]);
                tally.disoccluded +=
                    !has_history(previous, description.camera.near_m, uv + glm::dvec2(motion), z + motion.z);
                const glm::dvec3 view(z * (2 * uv.x - 1) / clip[0], z * (2 * uv.y - 1) / clip[5], -z);
                const glm::dvec3 n = glm::normalize(glm::dvec3(now.normal[i]));
                tally.penumbra += in_penumbra(casters, camera + world_from_view * view, n, z, sun,
                                              static_cast<uint32_t>(i));
            }
    }

  private:
    struct Casters {
        const Bvh& bvh;
        AlphaTest alpha;
    };

    static bool in_penumbra(const Casters& casters, const glm::dvec3& point, const glm::dvec3& n, double z,
                            const SunState& sun, uint32_t pixel) {
        const glm::dvec3 o =
            point +
            n * (z * 2e-5 + 16 * 0x1p-23 * (std::abs(point.x) + std::abs(point.y) + std::abs(point.z)));
        const Basis basis = across(sun.to_sun);
        const double turn_u = pcg(pixel) * 0x1p-32, turn_v = pcg(pixel ^ 0x9e3779b9u) * 0x1p-32;
        uint32_t blocked = 0;
        for (uint32_t k = 0; k < rays_per_pixel; ++k) {
            const double u = glm::fract(turn_u + 0.7548776662 * k), v = glm::fract(turn_v + 0.5698402910 * k);
            const double half = std::sin(0.5 * sun.angular_radius), rise = 2 * u * half * half;  // 1 - cos
            const double side = std::sqrt(rise * (2 - rise)), angle = glm::two_pi<double>() * v;
            const glm::dvec3 d =
                (1 - rise) * sun.to_sun + side * (std::cos(angle) * basis.x + std::sin(angle) * basis.y);
            blocked += glm::dot(d, n) <= 0 || occluded(casters.bvh,
                                                       {{float(o.x), float(o.y), float(o.z)},
                                                        {float(d.x), float(d.y), float(d.z)},
                                                        0,
                                                        std::numeric_limits<float>::infinity()},
                                                       nullptr, casters.alpha);
        }
        return blocked > 0 && blocked < rays_per_pixel;
    }

    Device& device_;
    StandaloneHost& host_;
};

}  // namespace

CasterWidths caster_widths(const std::vector<Triangle>& triangles, const std::vector<uint32_t>& objects,
                           const glm::dvec3& to_sun) {
    std::vector<uint32_t> parent(triangles.size());
    std::iota(parent.begin(), parent.end(), 0u);
    std::vector<uint32_t> casting = parent;
    std::erase_if(casting, [&](uint32_t t) { return !usable(triangles[t]); });
    const auto root = [&](uint32_t i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];
        return i;
    };
    std::map<std::array<float, 4>, uint32_t> first_at;  // object and position -> a triangle there
    for (const uint32_t t : casting)
        for (const auto& v : triangles[t].v) {
            const auto [found, fresh] = first_at.try_emplace({float(objects[t]), v[0], v[1], v[2]}, t);
            if (!fresh) parent[root(t)] = root(found->second);
        }
    const Basis basis = across(to_sun);
    std::map<uint32_t, std::vector<glm::dvec2>> pieces;
    for (const uint32_t t : casting)
        for (const auto& v : triangles[t].v) {
            const glm::dvec3 p(v[0], v[1], v[2]);
            pieces[root(t)].emplace_back(glm::dot(p, basis.x), glm::dot(p, basis.y));
        }
    CasterWidths out;
    for (const auto& [first, points] : pieces) out.width_m.push_back(narrow_extent(points));
    return out;
}

SceneFacts scene_facts(Device& device, StandaloneHost& host) {
    SceneFacts facts;
    const std::vector<Triangle> triangles = host.scene().triangles(0);
    const CasterWidths casters =
        caster_widths(triangles, host.scene().triangle_objects(), sun_at(host.shot(), 0).to_sun);
    const auto& bounds = host.scene().bounds();
    facts.triangles = triangles.size() - host.scene().translucent_triangles(0).size();
    facts.texel_m = glm::distance(bounds[0], bounds[1]) / 2048;
    facts.casters = casters.width_m.size();
    facts.sub_texel = static_cast<size_t>(
        std::ranges::count_if(casters.width_m, [&](double w) { return w < facts.texel_m; }));

    Tally tally;
    Measurer measurer(device, host);
    for (uint32_t frame = 1; frame < host.shot().frames; frame += frame_step, ++facts.frames)
        measurer.frame(frame, tally);
    const auto share = [](size_t part, size_t whole) { return whole ? double(part) / double(whole) : 0; };
    facts.receivers = share(tally.receivers, tally.pixels);
    facts.penumbra = share(tally.penumbra, tally.receivers);
    facts.disoccluded = share(tally.disoccluded, tally.receivers);
    facts.rays = rays_per_pixel;
    return facts;
}

}  // namespace penumbra
