// SPDX-License-Identifier: MIT
// Notation: s unit vector to the sun, S = sin(angular radius), m the edge's normal in the receiver's plane, t
// the edge's distance along m from a receiver point in units of the sheet's height. The plane through the
// point and the edge has the normal (m - t z) / sqrt(1 + t^2), so the sun's centre lies asin((s.m - t s.z) /
// sqrt(1 + t^2)) on the open side. The rims touch where that is +-S: (s.z^2 - S^2) t^2 - 2 s.m s.z t + s.m^2
// - S^2 = 0, whose roots bound the penumbra.
#include "host/truth/analytic.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

namespace penumbra {
namespace {

template <class Shape>
const Shape* shape_of(const Shot& shot) {
    return std::get_if<Shape>(&shot.analytic.value().shape);
}

bool touches(const Shot& shot) {
    return shape_of<ContactPoint>(shot) || shape_of<ContactWall>(shot);
}

double tilt(const Shot& shot) {
    const auto* half_plane = shape_of<HalfPlane>(shot);
    return half_plane ? glm::radians(half_plane->tilt_deg) : 0;
}

// A point p of the receiver is seen at (p.x, p.y cos(tilt)), so an edge that the image shows across m lies
// across (m.x, m.y cos(tilt)), and its distances are those of the image divided by that vector's length.
glm::dvec2 image_normal_on_receiver(const Shot& shot) {
    const double angle = glm::radians(shot.analytic->edge_deg);
    return {std::cos(angle), -std::sin(angle) * std::cos(tilt(shot))};  // the image's y points down
}

glm::dvec2 edge_normal(const Shot& shot) {
    if (shape_of<Terminator>(shot)) return glm::normalize(glm::dvec2(sun_at(shot, 0).to_sun));
    return glm::normalize(image_normal_on_receiver(shot));
}

// Metres on the receiver across the edge per pixel of the image.
double pixel_across_edge_m(const Shot& shot) {
    return analytic_pixel_m / (tilt(shot) > 0 ? glm::length(image_normal_on_receiver(shot)) : 1);
}

// Middle and width of a straight edge's penumbra in units of the sheet's height.
struct Penumbra {
    double middle = 0, width = 0;
};

Penumbra penumbra_of(const Shot& shot, double frame) {
    const SunState sun = sun_at(shot, frame);
    const double across = glm::dot(glm::dvec2(sun.to_sun), edge_normal(shot)), up = sun.to_sun.z;
    const double rim = std::sin(sun.angular_radius), denominator = up * up - rim * rim;
    return {across * up / denominator, 2 * rim * std::sqrt(denominator + across * across) / denominator};
}

double caster_height(const Shot& shot) {
    if (const auto* wall = shape_of<ContactWall>(shot)) return wall->height;
    if (const auto* point = shape_of<ContactPoint>(shot)) return point->radius_px * analytic_pixel_m;
    if (shape_of<Terminator>(shot)) return 0;
    return shot.analytic->penumbra_px * pixel_across_edge_m(shot) / penumbra_of(shot, 0).width;
}

// A sphere at rest hides its own contact: what lies above this is cut off by the near plane, so that no more
// than a forty-fifth of its radius does.
double cut_height(const ContactPoint& point) {
    return point.radius_px * analytic_pixel_m / 4000;
}

// How far a tilted receiver reaches towards the camera and away from it, from the image's centre, and how far
// in front of it, on each pixel's line of sight, the sheet hangs. A near plane fits between the two where the
// latter is 2.25 times the former.
struct TiltedDepths {
    double reach = 0, sheet = 0;
};
TiltedDepths tilted_depths(const Shot& shot) {
    return {0.5 * (shot.size[1] + 4) * analytic_pixel_m * std::tan(tilt(shot)),
            caster_height(shot) / std::cos(tilt(shot))};
}

double lowest_of_caster(const Shot& shot) {
    const auto* sphere = shape_of<Sphere>(shot);
    return caster_height(shot) - (sphere ? sphere->radius_px * analytic_pixel_m : 0);
}

// On the receiver.
glm::dvec2 pixel_centre(const Shot& shot, size_t x, size_t y) {
    return analytic_pixel_m *
           glm::dvec2(static_cast<double>(x) + 0.5 - 0.5 * shot.size[0],
                      (0.5 * shot.size[1] - static_cast<double>(y) - 0.5) / std::cos(tilt(shot)));
}

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

// One frame's scene, asked for the visibility of points of the receiver.
struct Scenery {
    const Shot& shot;
    AnalyticGeometry geometry;
    SunState sun;
    double across = glm::dot(glm::dvec2(sun.to_sun), geometry.normal);
    SlatRange slats = shape_of<Fence>(shot) ? fence_slats(shot) : SlatRange{};

    // Share of the sun beyond an edge that stands `edge` along the normal, towards the light.
    double beyond(double edge, const glm::dvec2& at) const {
        const double t = (edge - glm::dot(at, geometry.normal)) / geometry.height;
        const double sine = (across - t * sun.to_sun.z) / std::sqrt(1 + t * t);
        return half_plane_visibility(std::asin(std::clamp(sine, -1.0, 1.0)), sun.angular_radius);
    }
    double behind_sphere(double radius, const glm::dvec2& at) const {
        const glm::dvec3 to_centre(geometry.centre - at, geometry.height);
        return sphere_visibility(angle_between(sun.to_sun, to_centre),
                                 std::asin(radius / glm::length(to_centre)), sun.angular_radius);
    }

    double of(const HalfPlane&, const glm::dvec2& at) const { return beyond(geometry.edge, at); }
    double of(const Slit& slit, const glm::dvec2& at) const {
        const double half = 0.5 * slit.width_px * analytic_pixel_m;
        return beyond(geometry.edge - half, at) - beyond(geometry.edge + half, at);
    }
    double of(const Fence& fence, const glm::dvec2& at) const {
        const double period = fence.period_px * analytic_pixel_m, half = 0.5 * fence.duty * period;
        double hidden = 0;
        for (int i = slats.first; i <= slats.last; ++i) {
            const double middle = geometry.edge + i * period;
            hidden += beyond(middle - half, at) - beyond(middle + half, at);
        }
        return std::clamp(1 - hidden, 0.0, 1.0);
    }
    double of(const Polygon& polygon, const glm::dvec2& at) const {
        std::vector<glm::dvec3> corners;
        for (const glm::dvec2& p : polygon.points)
            corners.emplace_back(geometry.centre + analytic_pixel_m * glm::dvec2(p.x, -p.y) - at,
                                 geometry.height);
        return polygon_visibility(sun.to_sun, sun.angular_radius, corners);
    }
    double of(const Sphere& sphere, const glm::dvec2& at) const {
        return behind_sphere(sphere.radius_px * analytic_pixel_m, at);
    }
    double of(const ContactPoint& point, const glm::dvec2& at) const {
        return behind_sphere(point.radius_px * analytic_pixel_m, at);
    }
    // As the half-plane, but the wall hides what lies below the plane through its top on either of its sides.
    double of(const ContactWall&, const glm::dvec2& at) const {
        const double open = beyond(geometry.edge, at);
        return glm::dot(at, geometry.normal) < geometry.edge ? 1 - open : open;
    }
    double of(const Terminator&, const glm::dvec2& at) const {
        const TerminatorStrip strip = terminator_strip(shot, glm::dot(at, geometry.normal));
        return half_plane_visibility(std::asin(std::clamp(glm::dot(strip.normal, sun.to_sun), -1.0, 1.0)),
                                     sun.angular_radius);
    }
};

}  // namespace

AnalyticGeometry analytic_geometry(const Shot& shot, double frame) {
    const AnalyticScene& wanted = shot.analytic.value();
    const double last = std::max(shot.frames, 1u) - 1;  // motion is held outside of the shot, like every key
    const double shadow =
        (wanted.offset_px + wanted.speed_px * std::clamp(frame, 0.0, last)) * pixel_across_edge_m(shot);
    AnalyticGeometry out{edge_normal(shot), caster_height(shot), shadow, {}};
    out.centre = shadow * out.normal;
    if (touches(shot) || shape_of<Terminator>(shot)) return out;
    const glm::dvec3 to_sun = sun_at(shot, 0).to_sun;
    out.edge += out.height * penumbra_of(shot, 0).middle;
    out.centre += out.height / to_sun.z * glm::dvec2(to_sun);
    return out;
}

double terminator_strip_width(const Shot& shot) {
    constexpr double strips = 8;  // over the penumbra
    return std::max(shot.analytic->penumbra_px / strips, 1.0) * analytic_pixel_m;
}

// The strips' tilts run on for half a penumbra on either side and then stay. A surface whose slope only falls
// along its way is convex: no strip shadows another, and each is dark up to its own plane.
TerminatorStrip terminator_strip(const Shot& shot, double along) {
    const double width = terminator_strip_width(shot);
    const SunState sun = sun_at(shot, 0);
    const double elevation = std::asin(std::clamp(sun.to_sun.z, -1.0, 1.0)),
                 half = 0.5 * shot.analytic->penumbra_px * analytic_pixel_m;
    const auto tilt_of = [&](double index) {
        return sun.angular_radius * std::clamp((index + 0.5) * width / half, -2.0, 2.0) - elevation;
    };
    const double index = std::floor(along / width);
    TerminatorStrip out;
    for (double i = 0; i < index; ++i) out.height -= width * std::tan(tilt_of(i));
    for (double i = index; i < 0; ++i) out.height += width * std::tan(tilt_of(i));
    out.slope = -std::tan(tilt_of(index));
    out.height += out.slope * (along - index * width);
    const double angle = tilt_of(index);
    out.normal = glm::dvec3(std::sin(angle) * edge_normal(shot), std::cos(angle));
    return out;
}

double analytic_half_diagonal(const Shot& shot) {
    const double stretch = 1 / std::cos(tilt(shot));
    return 0.5 * analytic_pixel_m * (std::hypot(shot.size[0], stretch * shot.size[1]) + 4 * stretch);
}

double analytic_reach(const Shot& shot) {
    const AnalyticGeometry first = analytic_geometry(shot, 0);
    const double height = first.height;
    double reach = 0;
    for (uint32_t frame = 0; frame < shot.frames; ++frame) {
        const SunState sun = sun_at(shot, frame);
        const glm::dvec2 footprint = height / sun.to_sun.z * glm::dvec2(sun.to_sun);
        const double tilt = std::acos(std::min(sun.to_sun.z, 1.0));
        const double spread = height * (std::tan(tilt + sun.angular_radius) - std::tan(tilt));
        const glm::dvec2 caster =
            first.centre + (analytic_geometry(shot, frame).edge - first.edge) * first.normal;
        reach = std::max(reach, glm::distance(caster, footprint) + spread);
    }
    return 1.5 * (reach + analytic_half_diagonal(shot));
}

SlatRange fence_slats(const Shot& shot) {
    const double period = shape_of<Fence>(shot)->period_px * analytic_pixel_m;
    const int most = static_cast<int>(std::ceil(std::min(analytic_reach(shot) / period, 1e6)));
    return {-most, most};
}

void add_analytic_motion(Shot& shot) {
    if (shot.analytic.value().speed_px == 0 || shot.frames < 2) return;
    const double last = shot.frames - 1;
    const glm::dvec2 way = shot.analytic->speed_px * last * pixel_across_edge_m(shot) * edge_normal(shot);
    shot.objects["caster"].keys = {{0, glm::dvec3(0), glm::dvec3(0)},
                                   {last, glm::dvec3(way, 0), glm::dvec3(0)}};
}

// Reverse Z, linear as orthographic depth is; the camera stands `above` the plane z = 0 and sees from half as
// high down to as far below it.
Camera analytic_camera(const Shot& shot) {
    double above = 0.5 * lowest_of_caster(shot), far = 2 * above;  // hanging casters lie behind the camera
    if (const auto* point = shape_of<ContactPoint>(shot)) {
        above = 2 * cut_height(*point);
        far = 2 * above;
    } else if (shape_of<ContactWall>(shot)) {
        above = 4 * caster_height(shot);  // edge-on, a wall covers no pixel
        far = 2 * above;
    } else if (tilt(shot) > 0) {
        const TiltedDepths depths = tilted_depths(shot);
        above =
            std::max(2.5 * depths.reach, 0.01 * depths.sheet);  // near: large numbers are rounded coarsely
        far = 1.5 * above;
    } else if (shape_of<Terminator>(shot)) {
        const double half = analytic_half_diagonal(shot);
        const double high = std::max(terminator_strip(shot, half).height, 0.0),
                     low = std::min(terminator_strip(shot, -half).height, 0.0);
        above = 2 * (high - low) + 1;
        far = 2 * above;
    }
    Camera camera;
    const double sine = std::sin(tilt(shot)), cosine = std::cos(tilt(shot));
    const glm::dvec3 backward(0, -sine, cosine);
    for (int i = 0; i < 3; ++i)
        camera.position[static_cast<size_t>(i)] = shot.origin[i] + above * backward[i];
    if (sine > 0) camera.world_from_view = {1, 0, 0, 0, cosine, sine, 0, -sine, cosine};
    camera.near_m = 0.5 * above;
    const double x = 2 / (shot.size[0] * analytic_pixel_m), y = 2 / (shot.size[1] * analytic_pixel_m);
    camera.clip_from_view = {
        x, 0, 0, 0, 0, -y, 0, 0, 0, 0, 1 / (far - camera.near_m), 0, 0, 0, far / (far - camera.near_m), 1};
    return camera;
}

std::vector<double> analytic_image(const Shot& shot, double frame) {
    const Scenery scenery{shot, analytic_geometry(shot, frame), sun_at(shot, frame)};
    std::vector<double> image;
    image.reserve(size_t{shot.size[0]} * shot.size[1]);
    std::visit(
        [&](const auto& shape) {
            for (uint32_t y = 0; y < shot.size[1]; ++y)
                for (uint32_t x = 0; x < shot.size[0]; ++x)
                    image.push_back(scenery.of(shape, pixel_centre(shot, x, y)));
        },
        shot.analytic->shape);
    return image;
}

std::vector<uint8_t> analytic_receivers(const Shot& shot, double frame) {
    std::vector<uint8_t> out(size_t{shot.size[0]} * shot.size[1], 1);
    const auto* point = shape_of<ContactPoint>(shot);
    if (!point) return out;
    const double radius = point->radius_px * analytic_pixel_m;
    // A pixel more for the facets that stand for the sphere there.
    const double covered = std::sqrt(2 * radius * cut_height(*point)) + analytic_pixel_m;
    const glm::dvec2 contact = analytic_geometry(shot, frame).centre;
    for (size_t p = 0; p < out.size(); ++p)
        out[p] = glm::distance(pixel_centre(shot, p % shot.size[0], p / shot.size[0]), contact) > covered;
    return out;
}

std::optional<ContactLine> analytic_contact(const Shot& shot, double frame) {
    if (!touches(shot)) return std::nullopt;
    const AnalyticGeometry geometry = analytic_geometry(shot, frame);
    const glm::dvec2 sun(sun_at(shot, frame).to_sun);
    const auto pixels = [&](const glm::dvec2& p) {
        return std::array{p.x / analytic_pixel_m + 0.5 * shot.size[0],
                          0.5 * shot.size[1] - p.y / analytic_pixel_m};
    };
    glm::dvec2 away = -sun, along(0);
    if (shape_of<ContactWall>(shot)) {
        away = glm::dot(sun, geometry.normal) > 0 ? -geometry.normal : geometry.normal;
        along = 0.25 * analytic_pixel_m * std::min(shot.size[0], shot.size[1]) *
                glm::dvec2(-geometry.normal.y, geometry.normal.x);
    }
    if (!(glm::length(away) > 1e-6)) return std::nullopt;  // the sun stands overhead: no shadow to one side
    away = glm::normalize(away);
    return ContactLine{pixels(geometry.centre - along), pixels(geometry.centre + along), {away.x, -away.y}};
}

namespace {

// Whether the open segments cross.
bool cross(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
    const auto side = [](const glm::dvec2& p, const glm::dvec2& q, const glm::dvec2& r) {
        return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
    };
    return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
}

std::optional<AnalyticProblem> polygon_problem(const Polygon& polygon) {
    const std::vector<glm::dvec2>& p = polygon.points;
    double area = 0;
    for (size_t i = 0; i < p.size(); ++i) {
        const glm::dvec2 &a = p[i], &b = p[(i + 1) % p.size()];
        area += 0.5 * (a.x * b.y - b.x * a.y);
        for (size_t j = i + 1; j < p.size(); ++j)
            if (cross(a, b, p[j], p[(j + 1) % p.size()]))
                return AnalyticProblem{"scene.points", fmt::format("edges {} and {} cross", i, j)};
    }
    if (!(std::abs(area) > 1e-6)) return AnalyticProblem{"scene.points", "the polygon has no area"};
    return std::nullopt;
}

}  // namespace

std::optional<AnalyticProblem> analytic_problem(const Shot& shot, double frame) {
    const SunState sun = sun_at(shot, frame);
    if (!(sun.angular_radius > 0))
        return AnalyticProblem{
            "sun.keys", "an analytic scene needs a sun with an angular radius: its penumbra has a width"};
    const double elevation = glm::degrees(std::asin(std::clamp(sun.to_sun.z, -1.0, 1.0)));
    if (shape_of<Terminator>(shot)) {
        if (elevation >= 0 && elevation <= 75) return std::nullopt;
        return AnalyticProblem{"sun.keys", fmt::format("at frame {} the sun stands {:.3f} degrees above z = "
                                                       "0; the terminator's receiver can be tilted "
                                                       "for "
                                                       "0 to 75",
                                                       frame, elevation)};
    }
    // The whole sun above the receiver's plane, and the sheet within reach.
    const double lowest = elevation - glm::degrees(sun.angular_radius);
    if (!(lowest >= 1))
        return AnalyticProblem{"sun.keys", fmt::format("at frame {} the sun's lower rim stands {:.3f} "
                                                       "degrees above the receiver z = 0; 1 is the least",
                                                       frame, lowest)};
    if (shape_of<Sphere>(shot) && !(lowest_of_caster(shot) > 0))
        return AnalyticProblem{
            "scene",
            fmt::format(
                "the sphere would reach {:.3g} m below the receiver: a wider penumbra hangs it higher",
                -lowest_of_caster(shot))};
    if (const TiltedDepths depths = tilted_depths(shot); !(depths.sheet > 2.25 * depths.reach))
        return AnalyticProblem{
            "scene",
            fmt::format("the tilted receiver would reach past the sheet over it: {:.3g} m of {:.3g}; a "
                        "wider penumbra hangs it higher",
                        2.25 * depths.reach, depths.sheet)};
    if (const auto* polygon = shape_of<Polygon>(shot)) return polygon_problem(*polygon);
    if (shape_of<Fence>(shot) && frame == 0) {
        const SlatRange slats = fence_slats(shot);
        constexpr int most = 20000;
        if (slats.last - slats.first > most)
            return AnalyticProblem{"scene", fmt::format("the fence would need {} slats; {} is the most",
                                                        slats.last - slats.first + 1, most)};
    }
    return std::nullopt;
}

}  // namespace penumbra
