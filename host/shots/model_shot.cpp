// SPDX-License-Identifier: MIT
// Numbers are rounded to what a person would write: the text is the shot, and is read back like any other.
#include "host/shots/model_shot.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "host/models/translucency.h"
#include "host/scene/scene.h"
#include "host/shots/shot_text.h"

namespace penumbra {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr double fov_deg = 40, aspect = 16.0 / 9;
constexpr uint32_t still_frames = 16;  // one round of the jitter
constexpr double fps = 30;
constexpr uint32_t most_frames = 300;

// A multiple of a millionth of `size`, or so: no 1e-17 where a zero is meant. The text is the double nearest
// to it, whatever its size: a camera at large coordinates keeps its aim.
double rounded(double value, double size) {
    const int digits = 5 - static_cast<int>(std::floor(std::log10(std::max(size, 1e-9))));
    const double step = std::pow(10.0, -digits);
    const double of_step =
        digits > 0 ? std::stod(fmt::format("{:.{}f}", value, digits)) : std::round(value / step) * step;
    return of_step + 0.0;  // no -0
}

OrderedJson rounded(const glm::dvec3& v, double size) {
    return {rounded(v.x, size), rounded(v.y, size), rounded(v.z, size)};
}

struct View {
    glm::dvec3 position{0}, target{0};
};

// As near as all corners of the box stay in the image, with a margin of a tenth.
View framed(const std::array<glm::dvec3, 2>& box) {
    const double azimuth = glm::radians(-30.0), elevation = glm::radians(20.0);
    const glm::dvec3 back(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                          std::cos(azimuth) * std::cos(elevation));
    const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), back)),
                     up = glm::cross(back, right);
    const double tan_y = 0.9 * std::tan(glm::radians(fov_deg / 2)), tan_x = aspect * tan_y;
    const glm::dvec3 center = 0.5 * (box[0] + box[1]);
    double distance = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 c =
            glm::dvec3(box[corner & 1].x, box[corner >> 1 & 1].y, box[corner >> 2].z) - center;
        distance = std::max({distance, glm::dot(c, back) + std::abs(glm::dot(c, right)) / tan_x,
                             glm::dot(c, back) + std::abs(glm::dot(c, up)) / tan_y});
    }
    return {center + distance * back, center};
}

// Boxes of sixteen moments, joined.
std::array<glm::dvec3, 2> bounds_of(const Scene& scene, uint32_t frames) {
    std::array<glm::dvec3, 2> bounds = scene.bounds();
    for (int i = 1; i <= 16 && scene.animated(); ++i) {
        const auto [low, high] = scene.box(double(frames - 1) * i / 16);
        bounds = {glm::min(bounds[0], low), glm::max(bounds[1], high)};
    }
    return bounds;
}

// Which way an axis of a node points, where it has a length.
std::optional<glm::dvec3> axis(const glm::dmat4& world, int column) {
    const glm::dvec3 v(world[column]);
    const double length = glm::length(v);
    if (!(length > 1e-12 && std::isfinite(length))) return std::nullopt;
    return v / length;
}

uint32_t moments_of(const Scene& scene, uint32_t frames) {
    return scene.animated() ? frames : 1;
}

// Of candidates the first that has a key in any frame, or their number. There may be as many as nodes, all of
// which are put in place at once.
template <class HasKey>
size_t first_with_key(const Scene& scene, const std::vector<int>& candidates, uint32_t frames,
                      const HasKey& has_key) {
    size_t first = candidates.size();
    for (uint32_t frame = 0; first > 0 && frame < moments_of(scene, frames); ++frame) {
        const std::vector<glm::dmat4> transforms = scene.transforms(frame);
        for (size_t i = 0; i < first; ++i)
            if (has_key(transforms[static_cast<size_t>(candidates[i])])) first = i;
    }
    return first;
}

// What `key` makes of a node's transform in each frame, or nothing; without the keys that say what both of
// their neighbours say.
template <class Key>
OrderedJson keys_of(const Scene& scene, int node, uint32_t frames, const Key& key) {
    std::vector<std::pair<uint32_t, OrderedJson>> all;
    for (uint32_t frame = 0; frame < moments_of(scene, frames); ++frame)
        if (OrderedJson made = key(scene.transforms(frame)[static_cast<size_t>(node)]); !made.is_null())
            all.emplace_back(frame, std::move(made));
    OrderedJson keys = OrderedJson::array();
    for (size_t i = 0; i < all.size(); ++i) {
        const bool as_before = i > 0 && all[i].second == all[i - 1].second,
                   as_after = i + 1 == all.size() || all[i].second == all[i + 1].second;
        if (as_before && as_after) continue;
        keys.push_back({{"frame", all[i].first}});
        keys.back().update(all[i].second);
    }
    return keys;
}

// Which way is back and which up, of a node that looks somewhere.
std::optional<std::array<glm::dvec3, 2>> view_axes(const glm::dmat4& world) {
    const auto back = axis(world, 2), up = axis(world, 1);
    if (!back || !up || !(glm::length(glm::cross(*back, *up)) > 1e-6)) return std::nullopt;
    return std::array{*back, *up};
}

OrderedJson view_keys(const Scene& scene, const ModelCamera& camera, uint32_t frames, double size) {
    // In a large world, too, no coarser than what stands right before the camera.
    const double fine = std::min(size, 100 * camera.near);
    return keys_of(scene, camera.node, frames, [&](const glm::dmat4& world) -> OrderedJson {
        const auto axes = view_axes(world);
        if (!axes) return nullptr;
        const auto& [back, up] = *axes;
        const glm::dvec3 position(world[3]);
        return {{"position", rounded(position, fine)},
                {"target", rounded(position - 0.1 * size * back, fine)},
                {"up", rounded(up, 1)}};
    });
}

OrderedJson sun_keys(const Scene& scene, int node, uint32_t frames) {
    return keys_of(scene, node, frames, [&](const glm::dmat4& world) -> OrderedJson {
        const auto back = axis(world, 2);
        if (!back) return nullptr;
        return {{"to_sun", rounded(*back, 1)}};
    });
}

OrderedJson framing_camera(const std::array<glm::dvec3, 2>& bounds, double size) {
    const View view = framed(bounds);
    const double near = std::max(glm::length(view.position - view.target) / 200, 1e-6);
    return {{"vertical_fov_deg", fov_deg},
            {"near", rounded(near, near)},
            {"keys", OrderedJson::array({{{"frame", 0},
                                          {"position", rounded(view.position, size)},
                                          {"target", rounded(view.target, size)},
                                          {"up", {0.0, 1.0, 0.0}}}})}};
}

// The file's first camera that looks somewhere, else one that sees all.
OrderedJson camera_of(const Scene& scene, uint32_t frames, double size, ModelShot& out) {
    const Model& model = scene.model();
    std::vector<int> nodes;
    for (const ModelCamera& camera : model.cameras) nodes.push_back(camera.node);
    const size_t first =
        first_with_key(scene, nodes, frames, [](const glm::dmat4& world) { return view_axes(world); });
    for (size_t i = 0; i < nodes.size(); ++i) {
        const ModelCamera& camera = model.cameras[i];
        const std::string& name = model.nodes[static_cast<size_t>(camera.node)].name;
        if (i == first) {
            out.camera = name.empty() ? "unnamed" : name;
            return {{"vertical_fov_deg", rounded(camera.vertical_fov_deg, 100)},
                    {"near", rounded(camera.near, camera.near)},
                    {"keys", view_keys(scene, camera, frames, size)}};
        }
        out.warnings.emplace("camera", fmt::format("the camera of node \"{}\" is not looked through: its "
                                                   "axes have no length",
                                                   name));
    }
    return framing_camera(out.bounds, size);
}

// The file's first sun that shines somewhere, else one over the left shoulder.
OrderedJson sun_of(const Scene& scene, uint32_t frames, ModelShot& out) {
    const glm::dvec3 to_sun(-0.6, 0.85,
                            0.15);  // three sides of a box that are seen are of three brightnesses
    OrderedJson keys;
    const Model& model = scene.model();
    const size_t first =
        first_with_key(scene, model.suns, frames, [](const glm::dmat4& world) { return axis(world, 2); });
    for (size_t i = 0; i < model.suns.size(); ++i) {
        const int node = model.suns[i];
        const std::string& name = model.nodes[static_cast<size_t>(node)].name;
        if (i != first) {
            out.warnings.emplace("sun",
                                 fmt::format("the directional light of node \"{}\" is not the sun: its "
                                             "axes have no length",
                                             name));
            continue;
        }
        keys = sun_keys(scene, node, frames);
        if (model.suns.size() > 1)
            out.warnings.emplace("sun", fmt::format("of {} directional lights that of node \"{}\" is the sun",
                                                    model.suns.size(), name));
        break;
    }
    if (keys.empty()) keys = OrderedJson::array({{{"frame", 0}, {"to_sun", rounded(to_sun, 1)}}});
    return {{"angular_radius_deg", 0.2665}, {"keys", keys}};
}

// A word that names files and outputs, made of what the light is called, and of nothing that is `used`.
std::string key_of(const std::string& light, std::set<std::string>& used) {
    constexpr size_t longest = 48;
    std::string key;
    for (const char c : light) {
        const char low = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
        const bool kept = (low >= 'a' && low <= 'z') || (low >= '0' && low <= '9');
        if (kept && key.size() < longest)
            key += low;
        else if (!key.empty() && key.back() != '_')
            key += '_';
    }
    if (key.ends_with('_')) key.pop_back();
    if (key.empty() || (key[0] >= '0' && key[0] <= '9')) key = key.empty() ? "light" : "light_" + key;
    std::string free = key;
    for (int nth = 2; !used.insert(free).second; ++nth) free = fmt::format("{}_{}", key, nth);
    return free;
}

OrderedJson lights_of(const Model& model, ModelShot& out) {
    OrderedJson lights;
    std::set<std::string> used{"sun"};
    for (const ModelLight& light : model.lights) {
        if (lights.size() == most_lights) {
            out.warnings.emplace("lights", fmt::format("of {} lights the first {} are in the shot",
                                                       model.lights.size(), most_lights));
            break;
        }
        lights[key_of(light.name, used)] = {{"kind", "model"}, {"light", light.name}};
    }
    return lights;
}

// Which animation is played: the first that takes any time, for a pose is none.
std::optional<size_t> animation_of(const Model& model, ModelShot& out) {
    const auto played = std::ranges::find_if(model.animations, [](const Animation& animation) {
        return !animation.channels.empty() && animation.duration_s > 0;
    });
    if (played == model.animations.end()) return std::nullopt;
    const auto index = static_cast<size_t>(played - model.animations.begin());
    if (model.animations.size() > 1)
        out.warnings.emplace("animation",
                             fmt::format("of {} animations {} is played", model.animations.size(),
                                         played->name.empty() ? fmt::format("number {}", index)
                                                              : fmt::format("\"{}\"", played->name)));
    return index;
}

Shot playing_first(const Model& model, ModelShot& out) {
    Shot shot;
    shot.fps = fps;
    shot.frames = still_frames;
    if (const std::optional<size_t> animation = animation_of(model, out)) {
        shot.animation = std::to_string(*animation);
        shot.frames = static_cast<uint32_t>(std::clamp(
            std::ceil(model.animations[*animation].duration_s * fps) + 1, 2.0, double(most_frames)));
    }
    return shot;
}

Shot playing_as(const Shot& played, const Model& model) {
    Shot shot;
    shot.fps = played.fps;
    shot.frames = played.frames;
    try {
        find_animation(model, played.animation);
        shot.animation = played.animation;
    } catch (const std::runtime_error&) {  // told where the scene is opened
    }
    return shot;
}

void tell_translucents(const Scene& scene, ModelShot& out) {
    const Model& model = scene.model();
    struct Group {
        size_t triangles = 0;
        std::set<std::string> names;
    };
    std::array<Group, 2> groups;  // not drawn at all, and in part
    for (const Instance& instance : scene.instances())
        for (const Part& part : model.meshes[static_cast<size_t>(instance.mesh)].parts) {
            if (!scene.translucent(part)) continue;
            Group& group =
                groups[has_opaque_texels(model, model.materials[static_cast<size_t>(part.material)])];
            group.triangles += part.indices.size() / 3;
            const std::string& name = model.nodes[static_cast<size_t>(instance.node)].name;
            if (!name.empty()) group.names.insert(name);
        }
    constexpr size_t most_names = 3;
    for (size_t i = 0; i < groups.size(); ++i) {
        const auto& [triangles, names] = groups[i];
        if (triangles == 0) continue;
        const size_t told = std::min(names.size(), most_names);
        const auto end = std::next(names.begin(), static_cast<ptrdiff_t>(told));
        std::string of = told ? fmt::format(" of \"{}\"", fmt::join(names.begin(), end, "\", \"")) : "";
        if (names.size() > told) of += fmt::format(" and {} more", names.size() - told);
        const bool one = triangles == 1;
        out.warnings.emplace("scene",
                             fmt::format("{} triangle{}{} {} {}", triangles, one ? "" : "s", of,
                                         one ? "lets light through and is" : "let light through and are",
                                         i ? "drawn where opaque alone" : "not drawn"));
    }
}

}  // namespace

std::string seen_from(const std::filesystem::path& file, const std::filesystem::path& folder) {
    namespace fs = std::filesystem;
    std::error_code none;
    const fs::path from = fs::absolute(file);
    // Of a relative folder that is still to be made, weakly_canonical() would not know where it lies. A model
    // that is a link has its other files beside the link.
    const auto resolved = [&](const fs::path& path) {
        return fs::weakly_canonical(fs::absolute(path), none);
    };
    const fs::path relative = (resolved(from.parent_path()) / from.filename())
                                  .lexically_relative(resolved(folder.empty() ? "." : folder));
    return (relative.empty() ? from : relative).generic_string();
}

ModelShot make_model_shot(const Model& model, const std::filesystem::path& file,
                          const std::filesystem::path& shot_folder, bool ground, const Shot* played) {
    ModelShot out;
    const Shot shot = played ? playing_as(*played, model) : playing_first(model, out);
    const uint32_t frames = shot.frames;
    const Scene scene(model, shot);
    tell_translucents(scene, out);
    out.bounds = bounds_of(scene, frames);
    const auto& [low, high] = out.bounds;
    const double size = std::max(glm::length(high - low), 1e-6);

    OrderedJson json = {{"penumbra_shot", 1}};
    json["scene"] = seen_from(file, shot_folder);
    json["size"] = {1280, 720};
    json["frames"] = frames;
    json["fps"] = shot.fps;
    json["camera"] = camera_of(scene, frames, size, out);
    json["sun"] = sun_of(scene, frames, out);
    if (OrderedJson lights = lights_of(model, out); !lights.empty()) json["lights"] = std::move(lights);
    if (const int animation = find_animation(model, shot.animation); animation >= 0)
        json["animation"] = animation;
    if (ground) {
        const glm::dvec3 center = 0.5 * (low + high);
        json["ground"] = {{"height", rounded(low.y, size)},
                          {"center", {rounded(center.x, size), rounded(center.z, size)}},
                          {"half_extent", rounded(20 * size, size)}};
    }
    out.text = shot_text(json);
    return out;
}

}  // namespace penumbra
