// SPDX-License-Identifier: MIT
// The lamp is a pendulum: angle = 28 deg * cos(2 pi t / T), T = 2 pi sqrt(l / g) for l = 1 m. The walk is
// sines, with the hips as high as the lower foot wants, so that soles meet the ground. Dimensions in metres.
#include "host/generated/lamp.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <map>

#include "host/models/model_builder.h"

namespace penumbra {

namespace {

constexpr double two_pi = glm::two_pi<double>();
constexpr int frames = 64, key_step = 3;
constexpr double fps = 60;

enum MaterialIndex { paving, iron, glass, cloth, skin };

constexpr glm::dvec3 lamp_pivot(0.2, 3.55, -0.5);

// An ellipsoid-like body of revolution about y from `low` to `high`.
Shape rounded(double low, double high, double radius, int segments = 20) {
    std::vector<ProfilePoint> profile;
    constexpr int rings = 9;
    for (int i = 0; i <= rings; ++i) {
        const double t = double(i) / rings;
        profile.push_back(
            {glm::mix(low, high, t), radius * std::sqrt(std::max(1 - (2 * t - 1) * (2 * t - 1), 0.01))});
    }
    return lathe(profile, segments);
}

// A limb hanging from a joint at the origin.
Shape limb(double length, double top, double bottom) {
    const std::array<ProfilePoint, 5> profile{{{-length, bottom},
                                               {-0.9 * length, bottom * 1.05},
                                               {-0.35 * length, top * 1.06},
                                               {0, top},
                                               {0.3 * top, 0.55 * top}}};
    return lathe(profile, 16);
}

constexpr double leg = 0.45, shin = 0.46, arm = 0.30, forearm = 0.29;
constexpr double sole_y = -shin - 0.05, heel_z = -0.07, toe_z = 0.19;  // in the shin's frame
constexpr double hip_y = leg - sole_y;

struct Walker {
    glm::dvec3 start;
    double heading_deg;  // 0 walks towards +z
    double phase;        // of a turn
    double speed_m_s;
};
constexpr std::array<Walker, 3> walkers{
    {{{-2.6, 0, -0.9}, 80, 0.0, 1.45}, {{2.5, 0, 0.9}, -95, 0.35, 1.25}, {{0.9, 0, -3.4}, 20, 0.6, 1.1}}};

struct BodyMeshes {
    int trunk, thigh, shin, arm, forearm;
};

BodyMeshes add_body(ModelBuilder& builder) {
    Shape trunk = rounded(-0.14, 0.60, 0.19);
    trunk.transform(glm::scale(glm::dmat4(1), glm::dvec3(1, 1, 0.68)));
    Shape head = rounded(0.66, 0.92, 0.105);
    head.append(rod({0, 0.52, 0}, {0, 0.72, 0}, 0.05, 12));
    Shape lower = limb(shin, 0.062, 0.042);
    lower.append(box({-0.045, sole_y, heel_z}, {0.045, -shin + 0.02, toe_z}));
    Shape hand = rounded(-forearm - 0.13, -forearm + 0.02, 0.038, 12);
    BodyMeshes meshes{};
    meshes.trunk = builder.mesh({{std::move(trunk), cloth}, {std::move(head), skin}});
    meshes.thigh = builder.mesh(limb(leg, 0.088, 0.06), cloth);
    meshes.shin = builder.mesh(std::move(lower), cloth);
    meshes.arm = builder.mesh(limb(arm, 0.055, 0.042), cloth);
    meshes.forearm = builder.mesh({{limb(forearm, 0.042, 0.03), cloth}, {std::move(hand), skin}});
    return meshes;
}

// Only translations in the model: headings are keys, since a key's rotation comes after the node's own.
void add_walker(ModelBuilder& builder, const BodyMeshes& meshes, const std::string& name,
                const glm::dvec3& start) {
    const int root = builder.node(name, meshes.trunk, start + glm::dvec3(0, hip_y, 0));
    for (const double side : {-1.0, 1.0}) {
        const std::string suffix = side < 0 ? "_right" : "_left";
        const int thigh = builder.node(name + "_thigh" + suffix, meshes.thigh, {0.095 * side, 0, 0}, root);
        builder.node(name + "_shin" + suffix, meshes.shin, {0, -leg, 0}, thigh);
        const int upper = builder.node(name + "_arm" + suffix, meshes.arm, {0.225 * side, 0.50, 0}, root);
        builder.node(name + "_forearm" + suffix, meshes.forearm, {0, -arm, 0}, upper);
    }
}

Shape lamp_post() {
    constexpr std::array<ProfilePoint, 7> profile{
        {{0, 0.17}, {0.1, 0.17}, {0.16, 0.09}, {0.8, 0.075}, {0.86, 0.1}, {0.92, 0.06}, {4.0, 0.045}}};
    Shape shape = lathe(profile, 32);
    shape.transform(glm::translate(glm::dmat4(1), glm::dvec3(lamp_pivot.x - 1.3, 0, lamp_pivot.z)));
    // A curved arm from the post's top to the pivot, a stay below.
    glm::dvec3 from(lamp_pivot.x - 1.3, 3.7, lamp_pivot.z);
    for (int i = 1; i <= 8; ++i) {
        const double t = i / 8.0;
        const glm::dvec3 to(lamp_pivot.x - 1.3 + 1.3 * t,
                            3.7 - 0.15 * t + 0.35 * std::sin(glm::pi<double>() * t), lamp_pivot.z);
        shape.append(rod(from, to, 0.028, 12));
        from = to;
    }
    return shape;
}

// A chain's length of rod, a shade with a wide rim, a globe and a cage of four wires; hangs from the origin.
std::vector<std::pair<Shape, int>> lamp() {
    constexpr std::array<ProfilePoint, 6> shade{
        {{-0.98, 0.36}, {-0.96, 0.37}, {-0.90, 0.30}, {-0.76, 0.16}, {-0.70, 0.06}, {-0.66, 0.02}}};
    Shape metal = lathe(shade, 48);
    metal.append(rod({0, -0.7, 0}, {0, 0.02, 0}, 0.012, 10));
    for (int i = 0; i < 6; ++i) {
        const double angle = two_pi * i / 6, c = std::cos(angle), s = std::sin(angle);
        metal.append(rod({0.30 * c, -0.97, 0.30 * s}, {0.15 * c, -1.34, 0.15 * s}, 0.008, 8));
    }
    Shape ring = link(0.15, 0.01, 0, 32, 8);
    ring.transform(glm::rotate(glm::translate(glm::dmat4(1), glm::dvec3(0, -1.34, 0)), glm::half_pi<double>(),
                               glm::dvec3(1, 0, 0)));
    metal.append(ring);
    return {{std::move(metal), iron}, {rounded(-1.22, -0.99, 0.11, 32), glass}};
}

using Keys = std::vector<std::array<double, 7>>;  // frame, translation, rotation_deg

Keys keys(auto at) {
    Keys out;
    for (int frame = 0; frame < frames; frame += key_step) out.push_back(at(double(frame)));
    return out;
}

// Degrees about x of one side's joints; a positive turn swings what hangs down backwards (towards -z).
struct Gait {
    double thigh, shin, arm, forearm;
};

Gait gait_at(double cycle) {
    const double swing = std::cos(two_pi * cycle), lifted = std::max(-std::sin(two_pi * cycle - 0.5), 0.0);
    return {-25 * swing - 8 * lifted, 4 + 46 * lifted, 24 * swing, -18 + 10 * swing};
}

// Of the lowest corner of a foot, above the ground, while the hips are at hip_y.
double sole_height(const Gait& gait) {
    const double thigh = glm::radians(gait.thigh), foot = thigh + glm::radians(gait.shin);
    const auto below_knee = [&](double y, double z) { return y * std::cos(foot) - z * std::sin(foot); };
    return hip_y - leg * std::cos(thigh) + std::min(below_knee(sole_y, heel_z), below_knee(sole_y, toe_z));
}

std::map<std::string, Keys> motions() {
    std::map<std::string, Keys> out;
    const double period_s = two_pi * std::sqrt(1.0 / 9.81);
    out["lamp"] = keys([&](double frame) -> std::array<double, 7> {
        return {frame, 0, 0, 0, 0, 0, 28 * std::cos(two_pi * frame / fps / period_s)};
    });
    for (size_t w = 0; w < walkers.size(); ++w) {
        const Walker& walker = walkers[w];
        const std::string name = "walker_" + std::to_string(w);
        const double heading = glm::radians(walker.heading_deg);
        // One cycle is two steps of 0.7 m; the legs are half a cycle apart.
        const auto gait = [&](double frame, double side) {
            return gait_at(walker.phase + frame / fps * walker.speed_m_s / 1.4 + (side < 0 ? 0.5 : 0));
        };
        out[name] = keys([&](double frame) -> std::array<double, 7> {
            const double walked = frame / fps * walker.speed_m_s;
            const double lowest = std::min(sole_height(gait(frame, -1)), sole_height(gait(frame, 1)));
            return {frame, walked * std::sin(heading), -lowest, walked * std::cos(heading),
                    0,     walker.heading_deg,         0};
        });
        for (const double side : {-1.0, 1.0}) {
            const std::string suffix = side < 0 ? "_right" : "_left";
            const auto about_x = [&](double Gait::*angle) {
                return keys([&](double frame) -> std::array<double, 7> {
                    return {frame, 0, 0, 0, gait(frame, side).*angle, 0, 0};
                });
            };
            out[name + "_thigh" + suffix] = about_x(&Gait::thigh);
            out[name + "_shin" + suffix] = about_x(&Gait::shin);
            out[name + "_arm" + suffix] = about_x(&Gait::arm);
            out[name + "_forearm" + suffix] = about_x(&Gait::forearm);
        }
    }
    return out;
}

}  // namespace

Model make_lamp() {
    ModelBuilder builder({{{0.36f, 0.34f, 0.31f, 1}},
                          {{0.15f, 0.16f, 0.17f, 1}},
                          {{0.80f, 0.78f, 0.68f, 1}},
                          {{0.24f, 0.30f, 0.42f, 1}},
                          {{0.62f, 0.44f, 0.34f, 1}}});
    builder.solid("paving", ground(12, 12, 24, 24), paving);
    builder.solid("post", lamp_post(), iron);
    builder.node("lamp", builder.mesh(lamp()), lamp_pivot);
    const BodyMeshes meshes = add_body(builder);
    for (size_t i = 0; i < walkers.size(); ++i)
        add_walker(builder, meshes, "walker_" + std::to_string(i), walkers[i].start);
    Shape bench = box({2.0, 0.42, -2.6}, {3.8, 0.47, -2.1});
    for (int i = 0; i < 3; ++i)
        bench.append(box({2.0, 0.58 + 0.13 * i, -2.66}, {3.8, 0.66 + 0.13 * i, -2.62}));
    for (const double x : {2.15, 3.6}) bench.append(box({x, 0, -2.62}, {x + 0.06, 0.95, -2.56}));
    for (const double x : {2.15, 3.6}) bench.append(box({x, 0, -2.18}, {x + 0.06, 0.42, -2.12}));
    builder.solid("bench", std::move(bench), iron);
    return builder.take();
}

std::string make_lamp_shot() {
    std::string objects;
    for (const auto& [name, list] : motions()) {
        std::string lines;
        for (const auto& k : list) {
            lines += fmt::format(
                "{}        {{ \"frame\": {:.0f}, \"translation\": [{:.4f}, {:.4f}, {:.4f}], "
                "\"rotation_deg\": [{:.3f}, {:.3f}, {:.3f}] }}",
                lines.empty() ? "" : ",\n", k[0], k[1], k[2], k[3], k[4], k[5], k[6]);
        }
        objects += fmt::format("{}    \"{}\": {{\n      \"keys\": [\n{}\n      ]\n    }}",
                               objects.empty() ? "" : ",\n", name, lines);
    }
    return fmt::format(R"({{
  "penumbra_shot": 1,
  "scene": "lamp.glb",
  "size": [1280, 720],
  "frames": {},
  "fps": {},
  "camera": {{
    "vertical_fov_deg": 50,
    "near": 0.05,
    "keys": [{{ "frame": 0, "position": [0.9, 3.3, 5.4], "target": [0.45, 0.75, -0.3], "up": [0, 1, 0] }}]
  }},
  "sun": {{
    "angular_radius_deg": 0.2665,
    "keys": [{{ "frame": 0, "to_sun": [-0.55, 0.62, -0.5] }}]
  }},
  "objects": {{
{}
  }},
  "origin": [0, 0, 0],
  "seed": 0
}}
)",
                       frames, fps, objects);
}

}  // namespace penumbra
