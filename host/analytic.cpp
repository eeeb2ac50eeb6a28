// SPDX-License-Identifier: MIT
// Notation: s unit vector to the sun, S = sin(angular radius), m the edge's normal in the receiver's plane, t
// the edge's distance along m from a receiver point in units of the sheet's height. The plane through the
// point and the edge has the normal (m - t z) / sqrt(1 + t^2), so the sun's centre lies asin((s.m - t s.z) /
// sqrt(1 + t^2)) on the open side. The rims touch where that is +-S: (s.z^2 - S^2) t^2 - 2 s.m s.z t + s.m^2
// - S^2 = 0, whose roots bound the penumbra.
#include "host/analytic.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "host/shapes.h"

namespace penumbra {
namespace {

const HalfPlane& description(const Shot& shot) {
    return shot.half_plane.value();
}

glm::dvec2 edge_normal(const Shot& shot) {
    const double angle = glm::radians(description(shot).edge_deg);
    return {std::cos(angle), -std::sin(angle)};  // the image's y points down
}

// Middle and width of the penumbra in units of the sheet's height.
struct Penumbra {
    double middle = 0, width = 0;
};

Penumbra penumbra_of(const Shot& shot, double frame) {
    const SunState sun = sun_at(shot, frame);
    const double across = glm::dot(glm::dvec2(sun.to_sun), edge_normal(shot)), up = sun.to_sun.z;
    const double rim = std::sin(sun.angular_radius), denominator = up * up - rim * rim;
    return {across * up / denominator, 2 * rim * std::sqrt(denominator + across * across) / denominator};
}

double sheet_height(const Shot& shot) {
    return description(shot).penumbra_px * analytic_pixel_m / penumbra_of(shot, 0).width;
}

double half_diagonal_m(const Shot& shot) {
    return 0.5 * analytic_pixel_m * (std::hypot(shot.size[0], shot.size[1]) + 4);
}

// Far enough that no ray from the visible receiver passes the sheet on another side than its edge.
double sheet_reach(const Shot& shot) {
    double reach = 0;
    for (uint32_t frame = 0; frame < shot.frames; ++frame) {
        const HalfPlaneGeometry geometry = half_plane_geometry(shot, frame);
        const SunState sun = sun_at(shot, frame);
        const double tilt = std::acos(std::min(sun.to_sun.z, 1.0)) + sun.angular_radius;
        reach = std::max(reach, std::abs(geometry.edge) + geometry.height * std::tan(tilt));
    }
    return 1.5 * (reach + half_diagonal_m(shot));
}

void add_rectangle(Model& model, const char* name, const glm::dvec3& at,
                   const std::array<glm::dvec2, 4>& corners) {
    Shape shape;
    for (const glm::dvec2& corner : corners) shape.positions.emplace_back(glm::vec2(corner), 0.0f);
    shape.indices = {0, 1, 2, 0, 2, 3};
    Mesh mesh;
    mesh.parts.push_back(to_part(std::move(shape), 0));
    model.meshes.push_back(std::move(mesh));
    Node node;
    node.name = name;
    node.mesh = static_cast<int>(model.meshes.size()) - 1;
    node.translation = at;
    model.nodes.push_back(node);
}

}  // namespace

// The spherical cap's share by Gauss-Bonnet. asin's arguments leave [-1, 1] by rounding alone.
double half_plane_visibility(double distance, double radius) {
    if (distance >= radius) return 1;
    if (distance <= -radius) return 0;
    const double sine = std::clamp(std::sin(distance) / std::sin(radius), -1.0, 1.0);
    const double tangent = std::clamp(std::tan(distance) / std::tan(radius), -1.0, 1.0);
    const double half_sine = std::sin(0.5 * radius);
    const double cap =
        2 * glm::pi<double>() * half_sine * half_sine;  // pi (1 - cos radius), without cancellation
    return std::clamp(0.5 + (std::asin(sine) - std::cos(radius) * std::asin(tangent)) / cap, 0.0, 1.0);
}

HalfPlaneGeometry half_plane_geometry(const Shot& shot, double frame) {
    const HalfPlane& wanted = description(shot);
    const double last = std::max(shot.frames, 1u) - 1;  // motion is held outside of the shot, like every key
    const double shadow =
        (wanted.offset_px + wanted.speed_px * std::clamp(frame, 0.0, last)) * analytic_pixel_m;
    const double height = sheet_height(shot);
    return {edge_normal(shot), height, shadow + height * penumbra_of(shot, 0).middle};
}

void add_half_plane_motion(Shot& shot) {
    if (description(shot).speed_px == 0 || shot.frames < 2) return;
    const double last = shot.frames - 1;
    const glm::dvec2 way = description(shot).speed_px * last * analytic_pixel_m * edge_normal(shot);
    shot.objects["sheet"].keys = {{0, glm::dvec3(0), glm::dvec3(0)},
                                  {last, glm::dvec3(way, 0), glm::dvec3(0)}};
}

Model half_plane_model(const Shot& shot) {
    Model model;
    model.materials = {{{0.8f, 0.8f, 0.8f, 1}, -1}};
    const double half = half_diagonal_m(shot);
    add_rectangle(model, "receiver", glm::dvec3(0),
                  {{{-half, -half}, {half, -half}, {half, half}, {-half, half}}});

    const HalfPlaneGeometry geometry = half_plane_geometry(shot, 0);
    const glm::dvec2 m = geometry.normal, along(-m.y, m.x);
    const double reach = 2 * sheet_reach(shot);
    add_rectangle(model, "sheet", glm::dvec3(geometry.edge * m, geometry.height),
                  {{-reach * m - reach * along, -reach * along, reach * along, -reach * m + reach * along}});
    return model;
}

// Between receiver and sheet, so that the sheet lies behind it. Reverse Z, linear as orthographic depth is.
Camera half_plane_camera(const Shot& shot) {
    const double height = sheet_height(shot);
    Camera camera;
    for (int i = 0; i < 3; ++i) camera.position[static_cast<size_t>(i)] = shot.origin[i];
    camera.position[2] += 0.5 * height;
    camera.near = 0.25 * height;
    const double far = height;
    const double x = 2 / (shot.size[0] * analytic_pixel_m), y = 2 / (shot.size[1] * analytic_pixel_m);
    camera.clip_from_view = {
        x, 0, 0, 0, 0, -y, 0, 0, 0, 0, 1 / (far - camera.near), 0, 0, 0, far / (far - camera.near), 1};
    return camera;
}

std::vector<double> half_plane_image(const Shot& shot, double frame) {
    const HalfPlaneGeometry geometry = half_plane_geometry(shot, frame);
    const SunState sun = sun_at(shot, frame);
    const double across = glm::dot(glm::dvec2(sun.to_sun), geometry.normal);
    std::vector<double> image;
    image.reserve(size_t{shot.size[0]} * shot.size[1]);
    for (uint32_t y = 0; y < shot.size[1]; ++y)
        for (uint32_t x = 0; x < shot.size[0]; ++x) {
            const glm::dvec2 centre(x + 0.5 - 0.5 * shot.size[0], 0.5 * shot.size[1] - y - 0.5);
            const double t =
                (geometry.edge - glm::dot(centre, geometry.normal) * analytic_pixel_m) / geometry.height;
            const double sine = (across - t * sun.to_sun.z) / std::sqrt(1 + t * t);
            image.push_back(
                half_plane_visibility(std::asin(std::clamp(sine, -1.0, 1.0)), sun.angular_radius));
        }
    return image;
}

std::optional<std::string> half_plane_problem(const Shot& shot, double frame) {
    const SunState sun = sun_at(shot, frame);
    if (!(sun.angular_radius > 0))
        return "an analytic scene needs a sun with an angular radius: its penumbra has a width";
    // The whole sun above the receiver's plane, and the sheet within reach.
    const double lowest = glm::degrees(std::asin(std::clamp(sun.to_sun.z, -1.0, 1.0)) - sun.angular_radius);
    if (!(lowest >= 1))
        return fmt::format(
            "at frame {} the sun's lower rim stands {:.3f} degrees above the receiver z = 0; 1 is the least",
            frame, lowest);
    return std::nullopt;
}

}  // namespace penumbra
