// SPDX-License-Identifier: MIT
#include "tests/fact_scenes.h"

#include <cmath>
#include <glm/gtc/constants.hpp>

#include "host/models/shapes.h"
#include "host/truth/analytic.h"

namespace penumbra::test {
namespace {

Model yard() {
    Model model;
    model.materials = {{{0.8f, 0.8f, 0.75f, 1}, -1}};
    const auto add = [&](const char* name, const Shape& shape) {
        Mesh mesh;
        add_part(model, mesh, shape.positions, {}, shape.indices, 0);
        model.meshes.push_back(std::move(mesh));
        Node node;
        node.name = name;
        node.mesh = static_cast<int>(model.meshes.size()) - 1;
        model.nodes.push_back(node);
    };
    add("floor", ground(5, 5, 2, 2));
    add("gate", box({-1, 0, -0.1}, {1, 2, 0.1}));
    return model;
}

// The same with a leaf whose texture is half holes.
Model garden(double alpha_cutoff = 0.5) {
    Model model = yard();
    model.textures.push_back({2, 1, {90, 160, 60, 255, 90, 160, 60, 0}});
    Material leaf;
    leaf.texture = 0;
    leaf.alpha_cutoff = alpha_cutoff;
    model.materials.push_back(leaf);
    Mesh mesh;
    add_part(model, mesh, {{2, 1, 0}, {3, 1, 0}, {2, 1, 1}}, {{0, 0}, {1, 0}, {0, 1}}, {0, 1, 2}, 1);
    model.meshes.push_back(std::move(mesh));
    Node node;
    node.mesh = static_cast<int>(model.meshes.size()) - 1;
    model.nodes.push_back(node);
    return model;
}

// Triangles without an area: nothing that could be seen, nothing that could cast.
Model slivers() {
    Model model;
    Mesh mesh;
    add_part(model, mesh, {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, {}, {0, 1, 2}, -1);
    model.meshes.push_back(std::move(mesh));
    Node node;
    node.mesh = 0;
    model.nodes.push_back(node);
    return model;
}

Model flattened() {
    Model model = yard();
    for (Node& node : model.nodes) node.scale = {0, 0, 0};
    return model;
}

Shot still(std::vector<SunKey> sun, double radius_deg = 0.2665) {
    Shot shot;
    shot.frames = 100;
    shot.camera = {{0, {0, 3, 6}, {0, 0, 0}, {0, 1, 0}}};
    shot.sun = std::move(sun);
    shot.sun_angular_radius_deg = radius_deg;
    return shot;
}

glm::dvec3 toward(double elevation_deg, double azimuth_deg = 0) {
    const double e = glm::radians(elevation_deg), a = glm::radians(azimuth_deg);
    return {std::cos(e) * std::cos(a), std::sin(e), std::cos(e) * std::sin(a)};
}

std::vector<SunKey> at(double elevation_deg) {
    return {{0, toward(elevation_deg)}};
}

Shot with_camera(Shot shot, const CameraKey& last) {
    shot.camera.push_back(last);
    return shot;
}
Shot flying(Shot shot) {
    return with_camera(std::move(shot), {90, {1, 3, 6}, {0, 0, 0}, {0, 1, 0}});
}
Shot with_gate(Shot shot, const ObjectKey& last) {
    shot.objects["gate"].keys = {{0, {0, 0, 0}, {0, 0, 0}}, last};
    return shot;
}
Shot far_away(Shot shot) {
    shot.origin = {4e6, 0, -4e6};
    return shot;
}

Shot edge(double speed_px) {
    Shot shot;
    shot.analytic = AnalyticScene{.penumbra_px = 8, .edge_deg = 17, .speed_px = speed_px};
    shot.size = {64, 48};
    shot.frames = 100;
    shot.sun = {{0, {0.3, 0.2, 1}}};
    add_analytic_motion(shot);
    return shot;
}

}  // namespace

std::vector<FactScene> fact_scenes() {
    const auto noon = at(60);
    std::vector<FactScene> rows;
    const auto row = [&](const char* name, Model model, Shot shot, Shadow shadow, bool moves) {
        rows.push_back({name, std::move(model), std::move(shot), shadow, moves});
    };
    row("noon", yard(), still(noon), Shadow::soft, false);
    row("noon, the camera flies", yard(), flying(still(noon)), Shadow::soft, true);
    row("noon, the camera turns in place", yard(),
        with_camera(still(noon), {9, {0, 3, 6}, {1, 0, 0}, {0, 1, 0}}), Shadow::soft, true);
    row("noon, the camera rolls", yard(), with_camera(still(noon), {9, {0, 3, 6}, {0, 0, 0}, {1, 1, 0}}),
        Shadow::soft, true);
    row("noon, two equal camera keys", yard(), with_camera(still(noon), {9, {0, 3, 6}, {0, 0, 0}, {0, 1, 0}}),
        Shadow::soft, false);
    const auto gate_moves = [&](const char* name, Shot shot, Shadow shadow) {
        row(name, yard(), std::move(shot), shadow, true);
        rows.back().casters_move = true;
    };
    gate_moves("noon, the gate slides", with_gate(still(noon), {50, {1, 0, 0}, {0, 0, 0}}), Shadow::soft);
    gate_moves("noon, the gate turns", with_gate(still(noon), {50, {0, 0, 0}, {0, 90, 0}}), Shadow::soft);
    row("noon, the gate stays", yard(), with_gate(still(noon), {50, {0, 0, 0}, {0, 0, 0}}), Shadow::soft,
        false);
    gate_moves("noon, gate and camera move", flying(with_gate(still(noon), {50, {1, 0, 0}, {0, 0, 0}})),
               Shadow::soft);
    row("noon, 4000 km from the origin", yard(), far_away(still(noon)), Shadow::soft, false);
    const auto with_sun = [&](const char* name, Shot shot, Shadow shadow, bool moves) {
        row(name, yard(), std::move(shot), shadow, moves);
        rows.back().sun_moves = true;
    };
    with_sun("the sun crosses the sky, nothing else moves",
             still({{0, toward(10)}, {50, toward(80)}, {99, toward(20, 180)}}), Shadow::soft, false);
    with_sun("the sun crosses the sky, the camera flies", flying(still({{0, toward(10)}, {50, toward(80)}})),
             Shadow::soft, true);
    with_sun("the sun sets", still({{0, toward(30)}, {99, toward(-30)}}), Shadow::soft, false);
    with_sun("a point for a sun crosses the sky", still({{0, toward(10)}, {50, toward(80)}}, 0), Shadow::hard,
             false);
    row("two equal sun keys", yard(), still({{0, toward(30)}, {99, toward(30)}}), Shadow::soft, false);
    row("the sun in the zenith", yard(), still({{0, {1e-12, 3, -1e-12}}}), Shadow::soft, false);
    row("the sun's upper rim above the horizon", yard(), still(at(-0.26)), Shadow::soft, false);
    row("a wide sun, half of it above the horizon", yard(), still(at(-30), 45), Shadow::soft, false);
    row("a sun of a millionth of a degree", yard(), still(noon, 1e-6), Shadow::soft, false);
    row("an analytic edge", {}, edge(0), Shadow::soft, false);
    row("an analytic edge that moves", {}, edge(0.5), Shadow::soft, true);
    rows.back().casters_move = true;
    row("a point for a sun", yard(), still(noon, 0), Shadow::hard, false);
    row("a point for a sun, the camera flies", yard(), flying(still(noon, 0)), Shadow::hard, true);
    gate_moves("a point for a sun, the gate slides", with_gate(still(noon, 0), {50, {1, 0, 0}, {0, 0, 0}}),
               Shadow::hard);
    row("a point for a sun, on the horizon", yard(), still(at(0), 0), Shadow::hard, false);
    row("nothing there", {}, still(noon), Shadow::none, false);
    row("nothing there, the camera flies", {}, flying(still(noon)), Shadow::none, true);
    row("nothing there, a point for a sun", {}, still(noon, 0), Shadow::none, false);
    row("triangles without an area", slivers(), still(noon), Shadow::none, false);
    row("meshes scaled to nothing", flattened(), still(noon), Shadow::none, false);
    row("midnight", yard(), still(at(-60)), Shadow::all, false);
    row("midnight, the camera flies", yard(), flying(still(at(-60))), Shadow::all, true);
    with_sun("the sun passes below the horizon from dusk to dawn",
             still({{0, toward(-2)}, {99, toward(-2, 179)}}), Shadow::all, false);
    row("midnight, a point for a sun", yard(), still(at(-60), 0), Shadow::all, false);
    row("midnight, nothing there", {}, still(at(-60)), Shadow::all, false);
    row("the sun in the nadir", yard(), still({{0, {0, -1, 0}}}), Shadow::all, false);
    row("the sun's upper rim below the horizon", yard(), still(at(-0.27)), Shadow::all, false);
    with_sun("polar night: the sun circles below the horizon",
             still({{0, toward(-5, 0)}, {50, toward(-5, 90)}, {99, toward(-5, 180)}}), Shadow::all, false);
    const auto with_holes = [&](const char* name, Model model, Shot shot, Shadow shadow, bool moves) {
        row(name, std::move(model), std::move(shot), shadow, moves);
        rows.back().alpha = true;
    };
    with_holes("leaves with holes", garden(), still(noon), Shadow::soft, false);
    with_holes("leaves with holes, the camera flies", garden(), flying(still(noon)), Shadow::soft, true);
    with_holes("leaves with holes, a point for a sun", garden(), still(noon, 0), Shadow::hard, false);
    with_holes("leaves with holes at midnight", garden(), still(at(-60)), Shadow::all, false);
    row("leaves whose cutoff removes nothing", garden(0), still(noon), Shadow::soft, false);
    return rows;
}

}  // namespace penumbra::test
