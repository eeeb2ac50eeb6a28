// SPDX-License-Identifier: MIT
// The triangles of the analytic scenes: a node "receiver" and, where something casts a shadow, a node
// "caster" that the shot may move.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "host/models/shapes.h"
#include "host/truth/analytic.h"

namespace penumbra {
namespace {

void add_node(Model& model, const char* name, const glm::dvec3& at, Shape shape) {
    Mesh mesh;
    mesh.parts.push_back(to_part(std::move(shape), 0));
    model.meshes.push_back(std::move(mesh));
    Node node;
    node.name = name;
    node.mesh = static_cast<int>(model.meshes.size()) - 1;
    node.translation = at;
    model.nodes.push_back(node);
}

Shape quad(const std::array<glm::dvec3, 4>& corners) {
    Shape shape;
    for (const glm::dvec3& corner : corners) shape.positions.emplace_back(corner);
    shape.indices = {0, 1, 2, 0, 2, 3};
    return shape;
}

// Between two places along m, in the plane z = 0, as long as `reach` to both sides.
Shape band(const glm::dvec2& m, double from, double to, double reach) {
    const glm::dvec2 along(-m.y * reach, m.x * reach);
    return quad({glm::dvec3(from * m - along, 0), glm::dvec3(to * m - along, 0),
                 glm::dvec3(to * m + along, 0), glm::dvec3(from * m + along, 0)});
}

// By circles of latitude about z; the lowest point is a vertex.
//
// At rest: a point of the receiver at a distance x from the contact sees the ball's outline within an angle
// of 2 x / radius of the lowest point, at the distance x, so that its penumbra is as wide as x times the sun.
// What the facets are off by must fall towards the contact likewise: their sagitta, by the square of their
// size, so circles as far apart as the root of their angle, at the squares of equal steps.
Shape ball(double radius, bool at_rest) {
    // Off the sphere by at most radius / 6600; at rest by 1e-4 x.
    const uint32_t rings = at_rest ? 272 : 128, segments = at_rest ? 544 : 256;
    Shape shape;
    for (uint32_t ring = 0; ring <= rings; ++ring) {
        const double step = static_cast<double>(ring) / rings;
        const double angle = glm::pi<double>() * (at_rest ? step * step : step);
        const uint32_t points = ring == 0 || ring == rings ? 1 : segments;
        for (uint32_t i = 0; i < points; ++i) {
            const double turn = 2 * glm::pi<double>() * i / segments;
            const double across = ring == 0 || ring == rings ? 0 : radius * std::sin(angle);
            shape.positions.emplace_back(across * std::cos(turn), across * std::sin(turn),
                                         -radius * std::cos(angle));
        }
    }
    const auto vertex = [&](uint32_t ring, uint32_t i) {
        if (ring == 0) return 0u;
        return 1 + (ring - 1) * segments + (ring == rings ? 0 : i % segments);
    };
    for (uint32_t ring = 0; ring < rings; ++ring)
        for (uint32_t i = 0; i < segments; ++i) {
            const uint32_t a = vertex(ring, i), b = vertex(ring, i + 1), c = vertex(ring + 1, i + 1),
                           d = vertex(ring + 1, i);
            if (ring > 0) shape.indices.insert(shape.indices.end(), {a, c, b});
            if (ring + 1 < rings) shape.indices.insert(shape.indices.end(), {a, d, c});
        }
    return shape;
}

double turn(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Ear clipping: a corner that turns the polygon's way and has no other corner within its triangle is cut off.
Shape filled(std::vector<glm::dvec2> points) {
    double area = 0;
    for (size_t i = 0; i < points.size(); ++i) area += turn({}, points[i], points[(i + 1) % points.size()]);
    if (area < 0) std::reverse(points.begin(), points.end());
    Shape shape;
    std::vector<uint32_t> left;
    for (const glm::dvec2& p : points) {
        left.push_back(static_cast<uint32_t>(left.size()));
        shape.positions.emplace_back(glm::vec2(p), 0.0f);
    }
    const auto is_ear = [&](size_t i) {
        const uint32_t ia = left[(i + left.size() - 1) % left.size()], ib = left[i],
                       ic = left[(i + 1) % left.size()];
        const glm::dvec2 &a = points[ia], &b = points[ib], &c = points[ic];
        if (turn(a, b, c) < 0) return false;
        return std::none_of(left.begin(), left.end(), [&](uint32_t k) {
            return k != ia && k != ib && k != ic && turn(a, b, points[k]) >= 0 &&
                   turn(b, c, points[k]) >= 0 && turn(c, a, points[k]) >= 0;
        });
    };
    while (left.size() > 2) {
        size_t ear = 0;
        while (ear + 1 < left.size() && !is_ear(ear)) ++ear;
        const uint32_t a = left[(ear + left.size() - 1) % left.size()], c = left[(ear + 1) % left.size()];
        shape.indices.insert(shape.indices.end(), {a, left[ear], c});
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    return shape;
}

// What hangs or stands, about the place that geometry_at() gives it.
struct Caster {
    const Shot& shot;
    AnalyticGeometry geometry = analytic_geometry(shot, 0);
    double reach = 2 * analytic_reach(shot);

    // The edge at its place, and no further along itself than the rays come.
    glm::dvec3 at_edge(double z) const {
        const glm::dvec2 along(-geometry.normal.y, geometry.normal.x);
        return {geometry.edge * geometry.normal + glm::dot(geometry.centre, along) * along, z};
    }
    glm::dvec3 at_centre() const { return {geometry.centre, geometry.height}; }

    void add(Model& model, const HalfPlane&) const {
        add_node(model, "caster", at_edge(geometry.height), band(geometry.normal, -reach, 0, reach));
    }
    void add(Model& model, const Slit& slit) const {
        const double half = 0.5 * slit.width_px * analytic_pixel_m;
        Shape sheets = band(geometry.normal, -reach, -half, reach);
        sheets.append(band(geometry.normal, half, reach, reach));
        add_node(model, "caster", at_edge(geometry.height), std::move(sheets));
    }
    void add(Model& model, const Fence& fence) const {
        const double period = fence.period_px * analytic_pixel_m, half = 0.5 * fence.duty * period;
        const SlatRange slats = fence_slats(shot);
        Shape sheets;
        for (int i = slats.first; i <= slats.last; ++i)
            sheets.append(band(geometry.normal, i * period - half, i * period + half, reach));
        add_node(model, "caster", at_edge(geometry.height), std::move(sheets));
    }
    void add(Model& model, const Polygon& polygon) const {
        std::vector<glm::dvec2> points;
        for (const glm::dvec2& p : polygon.points) points.push_back(analytic_pixel_m * glm::dvec2(p.x, -p.y));
        add_node(model, "caster", at_centre(), filled(std::move(points)));
    }
    void add(Model& model, const Sphere& sphere) const {
        add_node(model, "caster", at_centre(), ball(sphere.radius_px * analytic_pixel_m, false));
    }
    void add(Model& model, const ContactPoint& point) const {
        add_node(model, "caster", at_centre(), ball(point.radius_px * analytic_pixel_m, true));
    }
    void add(Model& model, const ContactWall& wall) const {
        const glm::dvec2 m = geometry.normal, along(-m.y * reach, m.x * reach);
        add_node(model, "caster", at_edge(0),
                 quad({glm::dvec3(-along, 0), glm::dvec3(along, 0), glm::dvec3(along, wall.height),
                       glm::dvec3(-along, wall.height)}));
    }
    void add(Model&, const Terminator&) const {}
};

// Strips from one side of the image to the other; they share their edges.
Shape bent_receiver(const Shot& shot) {
    const glm::dvec2 m = analytic_geometry(shot, 0).normal;
    const double width = terminator_strip_width(shot), half = analytic_half_diagonal(shot);
    const glm::dvec2 along(-m.y * half, m.x * half);
    const int strips = static_cast<int>(std::ceil(half / width));
    Shape shape;
    for (int i = -strips; i <= strips; ++i) {
        const double q = i * width, z = terminator_strip(shot, q).height;
        shape.positions.emplace_back(glm::dvec3(q * m - along, z));
        shape.positions.emplace_back(glm::dvec3(q * m + along, z));
        if (i == strips) break;
        const auto first = static_cast<uint32_t>(shape.positions.size()) - 2;
        shape.indices.insert(shape.indices.end(), {first, first + 2, first + 3, first, first + 3, first + 1});
    }
    return shape;
}

}  // namespace

Model analytic_model(const Shot& shot) {
    Model model;
    model.materials = {{{0.8f, 0.8f, 0.8f, 1}, -1}};
    const double half = analytic_half_diagonal(shot);
    const bool bent = std::holds_alternative<Terminator>(shot.analytic.value().shape);
    add_node(model, "receiver", glm::dvec3(0), bent ? bent_receiver(shot) : band({1, 0}, -half, half, half));
    if (!bent) std::visit([&](const auto& shape) { Caster{shot}.add(model, shape); }, shot.analytic->shape);
    return model;
}

}  // namespace penumbra
