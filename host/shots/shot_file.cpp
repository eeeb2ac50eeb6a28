// SPDX-License-Identifier: MIT
// The shot's JSON: a closed set of keys, ranges, and errors with places. Every error of a file is reported.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/shots/shot.h"
#include "host/shots/shot_reader.h"
#include "host/truth/analytic.h"
#include "penumbra/json_text.h"

namespace penumbra {

namespace {

std::filesystem::path from_shot(const Shot& shot, const std::string& file) {
    return from_folder(shot.file.parent_path(), file);
}

void read_model(Reader& reader, const Json& json, const std::string& path, Shot& shot) {
    if (!reader.object(json, path, {"file", "name", "translation", "rotation_deg", "scale"})) return;
    const Json* file = reader.required(json, path, "file");
    if (!file) return;
    if (file->kind != Json::Kind::string || file->string.empty())
        return reader.error(file->place, Reader::join(path, "file"), "expected the name of a glTF file");
    PlacedModel& model = shot.models.emplace_back();
    model.file = from_shot(shot, file->string);
    model.name = model.file.stem().string();
    const Json* name = json.find("name");
    if (name && (name->kind != Json::Kind::string || name->string.empty() ||
                 name->string.find('/') != std::string::npos))
        return reader.error(name->place, Reader::join(path, "name"), "expected a name without \"/\"");
    if (name) model.name = name->string;
    if (std::ranges::count(shot.models, model.name, &PlacedModel::name) > 1)
        reader.error(
            name ? name->place : json.place, Reader::join(path, "name"),
            fmt::format("\"{}\" is the name of another model already: give one of its own", model.name));
    if (const Json* v = json.find("translation"))
        reader.vector(*v, Reader::join(path, "translation"), model.place.translation);
    if (const Json* v = json.find("rotation_deg"))
        reader.vector(*v, Reader::join(path, "rotation_deg"), model.place.rotation_deg);
    if (const Json* v = json.find("scale"))
        reader.number(*v, Reader::join(path, "scale"), 1e-6, 1e6, model.scale);
}

void read_models(Reader& reader, const Json& list, Shot& shot) {
    constexpr size_t most = 1024;
    if (list.items.empty() || list.items.size() > most)
        return reader.error(list.place, "scene", fmt::format("expected a list of 1 to {} models", most));
    for (size_t i = 0; i < list.items.size(); ++i)
        read_model(reader, list.items[i], fmt::format("scene[{}]", i), shot);
}

void read_scene(Reader& reader, const Json& root, Shot& shot) {
    const Json* scene = reader.required(root, "", "scene");
    if (!scene) return;
    if (scene->kind == Json::Kind::object) {
        read_analytic(reader, *scene, shot);
    } else if (scene->kind == Json::Kind::array) {
        read_models(reader, *scene, shot);
    } else if (scene->kind != Json::Kind::string || scene->string.empty()) {
        reader.error(scene->place, "scene", "expected the name of a glTF file");
    } else {
        shot.model = from_shot(shot, scene->string);
    }
}

// Analytic scenes bring a camera and a motion of their own: what a shot says besides would not be heeded.
void refuse_with_analytic(Reader& reader, const Json& root) {
    for (const char* key : {"camera", "objects", "lights", "animation", "ground"})
        if (const Json* value = root.find(key))
            reader.error(value->place, key, "an analytic scene has its own");
}

void read_cuts(Reader& reader, const Json& list, Shot& shot) {
    if (list.kind != Json::Kind::array) {
        reader.error(list.place, "cuts",
                     fmt::format("expected a list of frames, not {}", kind_name(list.kind)));
        return;
    }
    for (size_t i = 0; i < list.items.size(); ++i) {
        const std::string path = fmt::format("cuts[{}]", i);
        const size_t before = reader.errors();
        uint32_t cut = 0;
        reader.integer(list.items[i], path, 1, int64_t{shot.frames} - 1, cut);
        if (reader.errors() != before) continue;
        if (!shot.cuts.empty() && cut <= shot.cuts.back())
            reader.error(list.items[i].place, path, "frames of cuts must rise");
        shot.cuts.push_back(cut);
    }
}

void read_camera(Reader& reader, const Json& root, Shot& shot) {
    const Json* camera = reader.required(root, "", "camera");
    if (!camera || !reader.object(*camera, "camera", {"vertical_fov_deg", "near", "keys"})) return;
    if (const Json* fov = camera->find("vertical_fov_deg")) {
        reader.number(*fov, "camera.vertical_fov_deg", 0.01, 170, shot.vertical_fov_deg);
    }
    if (const Json* near = camera->find("near")) reader.number(*near, "camera.near", 1e-6, 1e6, shot.near);
    reader.keys(*camera, "camera", {"frame", "position", "target", "up"}, shot.camera,
                [&](const Json& item, const std::string& path, CameraKey& key) {
                    if (const Json* v = reader.required(item, path, "position")) {
                        reader.vector(*v, path + ".position", key.position);
                    }
                    if (const Json* v = reader.required(item, path, "target")) {
                        reader.vector(*v, path + ".target", key.target);
                    }
                    if (const Json* v = item.find("up")) reader.vector(*v, path + ".up", key.up);
                });
}

void read_sun(Reader& reader, const Json& root, Shot& shot) {
    const Json* sun = shot.lights.empty() ? reader.required(root, "", "sun") : root.find("sun");
    if (!sun || !reader.object(*sun, "sun", {"angular_radius_deg", "keys"})) return;
    if (const Json* radius = sun->find("angular_radius_deg")) {
        reader.number(*radius, "sun.angular_radius_deg", 0, 45, shot.sun_angular_radius_deg);
    }
    reader.keys(*sun, "sun", {"frame", "to_sun"}, shot.sun,
                [&](const Json& item, const std::string& path, SunKey& key) {
                    const Json* v = reader.required(item, path, "to_sun");
                    if (!v) return;
                    reader.vector(*v, path + ".to_sun", key.to_sun);
                    if (!(glm::length(key.to_sun) > 1e-6)) {
                        reader.error(v->place, path + ".to_sun", "a direction may not be zero");
                        key.to_sun = {0, 1, 0};
                    }
                });
}

// Of a shot that is lit by lamps alone nobody asks where its sun is; shadow maps are drawn from above.
void without_sun(Shot& shot) {
    shot.has_sun = false;
    shot.sun = {{0, {0, 1, 0}}};
}

void read_objects(Reader& reader, const Json& root, Shot& shot) {
    const Json* objects = root.find("objects");
    if (!objects) return;
    if (objects->kind != Json::Kind::object) {
        reader.error(objects->place, "objects", "expected an object of node names");
        return;
    }
    for (const JsonMember& member : objects->members) {
        const std::string path = "objects." + member.key;
        ObjectMotion& motion = shot.objects[member.key];
        motion.place = member.key_place;
        if (!reader.object(member.value, path, {"keys"})) continue;
        reader.keys(member.value, path, {"frame", "translation", "rotation_deg"}, motion.keys,
                    [&](const Json& item, const std::string& key_path, ObjectKey& key) {
                        if (const Json* v = item.find("translation")) {
                            reader.vector(*v, key_path + ".translation", key.translation);
                        }
                        if (const Json* v = item.find("rotation_deg")) {
                            reader.vector(*v, key_path + ".rotation_deg", key.rotation_deg);
                        }
                    });
    }
}

void read_ground(Reader& reader, const Json& root, Shot& shot) {
    const Json* ground = root.find("ground");
    if (!ground || !reader.object(*ground, "ground", {"height", "center", "half_extent"})) return;
    Ground& out = shot.ground.emplace();
    if (const Json* v = reader.required(*ground, "ground", "height"))
        reader.number(*v, "ground.height", -huge, huge, out.height);
    if (const Json* v = reader.required(*ground, "ground", "half_extent"))
        reader.number(*v, "ground.half_extent", 1e-6, huge, out.half_extent);
    const Json* center = ground->find("center");
    if (!center) return;
    if (center->kind != Json::Kind::array || center->items.size() != 2) {
        reader.error(center->place, "ground.center", "expected [x, z]");
        return;
    }
    for (size_t i = 0; i < 2; ++i)
        reader.number(center->items[i], fmt::format("ground.center[{}]", i), -huge, huge, out.center[i]);
}

// { "file", "scale" }, or a sky { "down", "up" }.
void read_environment(Reader& reader, const Json& root, Shot& shot) {
    const Json* json = root.find("environment");
    if (!json || !reader.object(*json, "environment", {"file", "scale", "down", "up"})) return;
    const auto refuse = [&](const char* key, const char* beside) {
        if (const Json* value = json->find(key))
            reader.error(value->place, std::string("environment.") + key,
                         fmt::format("an environment with \"{}\" has no \"{}\"", beside, key));
    };
    if (const Json* file = json->find("file")) {
        refuse("down", "file");
        refuse("up", "file");
        EnvironmentFile out;
        if (file->kind != Json::Kind::string || file->string.empty())
            reader.error(file->place, "environment.file", "expected the name of an EXR file");
        else
            out.path = from_shot(shot, file->string);
        if (const Json* scale = json->find("scale"))
            reader.number(*scale, "environment.scale", 0, 1e9, out.scale);
        shot.environment = out;
        return;
    }
    refuse("scale", "up");
    EnvironmentSky out;
    out.linear = true;
    const auto color = [&](const char* key, glm::dvec3& value) {
        const Json* v = reader.required(*json, "environment", key);
        if (!v) return;
        reader.vector(*v, std::string("environment.") + key, value);
        if (!(std::min({value.x, value.y, value.z}) >= 0))
            reader.error(v->place, std::string("environment.") + key, "a radiance may not be negative");
    };
    color("down", out.low);
    color("up", out.high);
    shot.environment = out;
}

// Keys that are good one by one may still meet on the way, so every frame is looked at.
void check_frames(Reader& reader, const Json& root, const Shot& shot) {
    const auto all_finite = [](const auto& list) {
        for (const double value : list)
            if (!std::isfinite(value)) return false;
        return true;
    };
    const Place sun_place = shot.has_sun ? root.find("sun")->find("keys")->place : Place{};
    const Place camera_place = shot.analytic ? sun_place : root.find("camera")->find("keys")->place;
    bool camera_good = true, sun_good = true;
    for (uint32_t frame = 0; frame < shot.frames; ++frame) {
        if (!shot.analytic && camera_good && !all_finite(camera_at(shot, frame, 1).world_from_view)) {
            reader.error(
                camera_place, "camera.keys",
                fmt::format("at frame {} the target is at the camera, or `up` is along the view", frame));
            camera_good = false;
        }
        const glm::dvec3 to_sun = sun_at(shot, frame).to_sun;
        if (sun_good && !all_finite(std::array{to_sun.x, to_sun.y, to_sun.z})) {
            reader.error(sun_place, "sun.keys",
                         fmt::format("at frame {} the direction vanishes between keys", frame));
            sun_good = false;
        } else if (shot.analytic && sun_good) {
            if (const auto problem = analytic_problem(shot, frame)) {
                const bool of_sun = problem->key == std::string_view("sun.keys");
                reader.error(of_sun ? sun_place : root.find("scene")->place, problem->key, problem->text);
                sun_good = false;
            }
        }
    }
}

}  // namespace

namespace {

std::optional<Shot> shot_of(const std::optional<Json>& root, const std::filesystem::path& path,
                            Diagnostics& diagnostics) {
    if (!root) return std::nullopt;
    const size_t before = diagnostics.size();
    Reader reader(diagnostics);
    if (!reader.object(*root, "",
                       {"$schema", "penumbra_shot", "scene", "size", "frames", "cuts", "fps", "camera", "sun",
                        "lights", "objects", "animation", "ground", "environment", "origin", "seed"})) {
        return std::nullopt;
    }
    Shot shot;
    shot.file = path;
    shot.name = shot_name(path);
    if (const Json* version = reader.required(*root, "", "penumbra_shot")) {
        if (version->kind != Json::Kind::integer || version->integer != 1) {
            reader.error(version->place, "penumbra_shot", "this program reads shots of version 1");
        }
    }
    if (const Json* schema = root->find("$schema"); schema && schema->kind != Json::Kind::string)
        reader.error(schema->place, "$schema", "expected the name of a JSON Schema, for editors");
    read_scene(reader, *root, shot);
    if (const Json* size = root->find("size")) {
        if (size->kind == Json::Kind::array && size->items.size() == 2) {
            for (size_t i = 0; i < 2; ++i) {
                reader.integer(size->items[i], fmt::format("size[{}]", i), 1, 16384, shot.size[i]);
            }
        } else {
            reader.error(size->place, "size", "expected [width, height]");
        }
    }
    if (const Json* frames = root->find("frames")) reader.integer(*frames, "frames", 1, 100000, shot.frames);
    if (const Json* cuts = root->find("cuts")) read_cuts(reader, *cuts, shot);
    if (const Json* fps = root->find("fps")) reader.number(*fps, "fps", 0.001, 10000, shot.fps);
    const Json* scene = root->find("scene");
    const bool analytic = scene && scene->kind == Json::Kind::object;
    if (!analytic) read_camera(reader, *root, shot);
    if (!analytic) read_lights(reader, *root, shot);
    read_sun(reader, *root, shot);
    if (!analytic) read_objects(reader, *root, shot);
    if (!analytic) read_ground(reader, *root, shot);
    if (const Json* animation = root->find("animation"); animation && !analytic) {
        if (animation->kind == Json::Kind::string && !animation->string.empty())
            shot.animation = animation->string;
        else if (animation->kind == Json::Kind::integer && animation->integer >= 0)
            shot.animation = std::to_string(animation->integer);
        else
            reader.error(animation->place, "animation",
                         "expected the name or the number of one of the model's");
    }
    if (analytic) refuse_with_analytic(reader, *root);
    read_environment(reader, *root, shot);
    if (const Json* origin = root->find("origin")) reader.vector(*origin, "origin", shot.origin);
    if (const Json* seed = root->find("seed")) {
        reader.integer(*seed, "seed", 0, std::numeric_limits<uint32_t>::max(), shot.seed);
    }
    if (diagnostics.size() == before && !root->find("sun")) without_sun(shot);
    if (diagnostics.size() == before) check_frames(reader, *root, shot);
    if (diagnostics.size() != before) return std::nullopt;
    if (shot.analytic) add_analytic_motion(shot);
    return shot;
}

}  // namespace

// Without ".." where that is the same file: a shot may be read before its folder is there. Behind a folder
// that is a link, ".." leads out of what it links to.
std::filesystem::path from_folder(const std::filesystem::path& folder, const std::string& file) {
    namespace fs = std::filesystem;
    std::error_code none;
    fs::path there = folder / file;
    const fs::path shortest = there.lexically_normal();
    if (!folder.empty() && !fs::exists(folder, none))
        there = (fs::weakly_canonical(fs::absolute(folder, none), none) / file).lexically_normal();
    const bool same = there == shortest || fs::equivalent(there, shortest, none) ||
                      (!fs::exists(there, none) && !fs::exists(shortest, none));
    return same ? shortest : there;
}

std::string shot_name(const std::filesystem::path& file) {
    std::string name = file.filename().string();
    constexpr std::string_view suffix = ".shot.json";
    if (name.ends_with(suffix)) name.resize(name.size() - suffix.size());
    return name;
}

std::optional<Shot> read_shot(const std::filesystem::path& path, Diagnostics& diagnostics) {
    return shot_of(read_json(path, diagnostics), path, diagnostics);
}

std::optional<Shot> parse_shot(std::string_view text, const std::filesystem::path& path,
                               Diagnostics& diagnostics) {
    return shot_of(parse_json(text, path.string(), diagnostics), path, diagnostics);
}

}  // namespace penumbra
