// SPDX-License-Identifier: MIT
// The analytic scene of a shot's JSON: by its name, with the keys that its kind has.
#include <fmt/ranges.h>

#include "host/shots/shot_reader.h"

namespace penumbra {
namespace {

// One of the analytic scenes: its name and the keys that it has besides those that place it.
struct AnalyticKind {
    const char* name;
    bool hangs;  // so high that its penumbra is as wide as "penumbra_px"
    bool moves;
    AnalyticShape shape;
    std::vector<const char*> keys;
};

const std::vector<AnalyticKind>& analytic_kinds() {
    static const std::vector<AnalyticKind> kinds = {
        {"half_plane", true, true, HalfPlane{}, {"tilt_deg"}},
        {"slit", true, true, Slit{}, {"width_px"}},
        {"fence", true, true, Fence{}, {"period_px", "duty"}},
        {"polygon", true, true, Polygon{}, {"points"}},
        {"sphere", true, true, Sphere{}, {"radius_px"}},
        {"contact_point", false, true, ContactPoint{}, {"radius_px"}},
        {"contact_wall", false, true, ContactWall{}, {"height"}},
        {"terminator", true, false, Terminator{}, {}}};
    return kinds;
}

void read_points(Reader& reader, const Json& list, std::vector<glm::dvec2>& out) {
    const std::string path = "scene.points";
    if (list.kind != Json::Kind::array || list.items.size() < 3 || list.items.size() > 256) {
        reader.error(list.place, path, "expected a list of 3 to 256 points");
        return;
    }
    for (size_t i = 0; i < list.items.size(); ++i) {
        const Json& point = list.items[i];
        const std::string at = fmt::format("{}[{}]", path, i);
        if (point.kind != Json::Kind::array || point.items.size() != 2) {
            reader.error(point.place, at, "expected [x, y]");
            continue;
        }
        reader.number(point.items[0], at + "[0]", -1e5, 1e5, out.emplace_back().x);
        reader.number(point.items[1], at + "[1]", -1e5, 1e5, out.back().y);
    }
}

}  // namespace

void read_analytic(Reader& reader, const Json& scene, Shot& shot) {
    const Json* name = reader.required(scene, "scene", "analytic");
    const AnalyticKind* kind =
        name ? reader.named(*name, "scene.analytic", "analytic scene", analytic_kinds()) : nullptr;
    if (!kind) return;
    AnalyticScene& out = shot.analytic.emplace();
    out.shape = kind->shape;
    std::vector<const char*> known{"analytic"};
    if (kind->hangs) known.push_back("penumbra_px");
    if (kind->moves) known.insert(known.end(), {"edge_deg", "speed_px", "offset_px"});
    known.insert(known.end(), kind->keys.begin(), kind->keys.end());
    if (!reader.object(scene, "scene", known)) return;

    const auto number = [&](const char* key, double low, double high, double& value) {
        if (const Json* v = reader.required(scene, "scene", key))
            reader.number(*v, std::string("scene.") + key, low, high, value);
    };
    const auto optional = [&](const char* key, double low, double high, double& value) {
        if (kind->moves && scene.find(key)) number(key, low, high, value);
    };
    if (kind->hangs) number("penumbra_px", 0.5, 4096, out.penumbra_px);
    optional("edge_deg", -360, 360, out.edge_deg);
    optional("speed_px", -64, 64, out.speed_px);
    optional("offset_px", -1e5, 1e5, out.offset_px);
    if (auto* edge = std::get_if<HalfPlane>(&out.shape)) optional("tilt_deg", 0, 85, edge->tilt_deg);
    if (auto* slit = std::get_if<Slit>(&out.shape)) number("width_px", 0.01, 1e4, slit->width_px);
    if (auto* fence = std::get_if<Fence>(&out.shape)) {
        number("period_px", 0.1, 1e4, fence->period_px);
        number("duty", 0.01, 0.99, fence->duty);
    }
    if (auto* sphere = std::get_if<Sphere>(&out.shape)) number("radius_px", 0.1, 1e4, sphere->radius_px);
    if (auto* point = std::get_if<ContactPoint>(&out.shape)) number("radius_px", 1, 1e4, point->radius_px);
    if (auto* wall = std::get_if<ContactWall>(&out.shape)) number("height", 0.01, 1e3, wall->height);
    if (auto* polygon = std::get_if<Polygon>(&out.shape))
        if (const Json* points = reader.required(scene, "scene", "points"))
            read_points(reader, *points, polygon->points);
}

}  // namespace penumbra
