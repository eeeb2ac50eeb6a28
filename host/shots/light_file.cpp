// SPDX-License-Identifier: MIT
// The lights of a shot's JSON: by their names, each with the keys that its kind has.
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "host/shots/shot_reader.h"

namespace penumbra {
namespace {

// What a light of some kind says of itself, besides its colour, its range and its keys.
struct Kind {
    LightKind kind;
    const char* name;
    std::vector<const char*>
        sizes;             // metres; the first one or two are required, a point's and a spot's radius is not
    const char* strength;  // of the model's: nullptr
    bool faces, lies;      // whether keys have a direction; whether they say how it is laid
};

const std::vector<Kind>& kinds() {
    static const std::vector<Kind> list = {
        {LightKind::point, "point", {"radius"}, "intensity", false, false},
        {LightKind::sphere, "sphere", {"radius"}, "luminance", false, false},
        {LightKind::disc, "disc", {"radius"}, "luminance", true, false},
        {LightKind::rectangle, "rectangle", {"width", "height"}, "luminance", true, true},
        {LightKind::tube, "tube", {"length", "radius"}, "luminance", false, true},
        {LightKind::spot, "spot", {"radius", "inner_deg", "outer_deg"}, "intensity", true, false},
        {LightKind::model, "model", {"radius"}, nullptr, false, false}};
    return list;
}

double* value_of(ShotLight& light, std::string_view key) {
    if (key == "radius") return &light.radius;
    if (key == "height") return &light.height;
    if (key == "inner_deg") return &light.inner_deg;
    if (key == "outer_deg") return &light.outer_deg;
    return &light.length;  // a tube's, and a rectangle's width
}

void read_sizes(Reader& reader, const Json& json, const std::string& path, const Kind& kind,
                ShotLight& light) {
    const bool may_be_a_point = !kind.strength || kind.strength == std::string_view("intensity");
    for (const char* key : kind.sizes) {
        const Json* value = may_be_a_point ? json.find(key) : reader.required(json, path, key);
        if (!value) continue;
        const bool angle = std::string_view(key).ends_with("_deg");
        reader.number(*value, Reader::join(path, key), angle || may_be_a_point ? 0 : 1e-6, angle ? 90 : 1e6,
                      *value_of(light, key));
    }
    if (light.kind == LightKind::spot && !(light.inner_deg < light.outer_deg))
        reader.error(json.place, Reader::join(path, "inner_deg"),
                     fmt::format("{} is not below outer_deg, {}", light.inner_deg, light.outer_deg));
}

void read_name(Reader& reader, const Json& json, const std::string& path, std::string& name) {
    const Json* value = reader.required(json, path, "light");
    if (!value) return;
    if (value->kind == Json::Kind::string && !value->string.empty())
        name = value->string;
    else
        reader.error(value->place, path + ".light", "expected the name of a light of the model");
}

void read_color(Reader& reader, const Json& json, const std::string& path, glm::dvec3& color) {
    reader.vector(json, path, color);
    if (glm::any(glm::lessThan(color, glm::dvec3(0))))
        reader.error(json.place, path, "a colour may not be negative");
}

void read_direction(Reader& reader, const Json& json, const std::string& path, glm::dvec3& out) {
    reader.vector(json, path, out);
    if (glm::length(out) > 1e-6) return;
    reader.error(json.place, path, "a direction may not be zero");
    out = {0, -1, 0};
}

void read_keys(Reader& reader, const Json& json, const std::string& path, const Kind& kind,
               ShotLight& light) {
    const auto may_have = [&](const Json& item, const std::string& at, const char* key, bool may) {
        const Json* value = item.find(key);
        if (value && !may)
            reader.error(value->place, Reader::join(at, key), fmt::format("a {} has none", kind.name));
        return may ? value : nullptr;
    };
    reader.keys(json, path, {"frame", "position", "direction", "along", "size", "power"}, light.keys,
                [&](const Json& item, const std::string& at, LightKey& key) {
                    if (const Json* v = reader.required(item, at, "position"))
                        reader.vector(*v, at + ".position", key.position);
                    if (const Json* v = may_have(item, at, "direction", kind.faces))
                        read_direction(reader, *v, at + ".direction", key.direction);
                    if (const Json* v = may_have(item, at, "along", kind.lies))
                        read_direction(reader, *v, at + ".along", key.along);
                    if (const Json* v = item.find("size"))
                        reader.number(*v, at + ".size", 1e-6, 1e6, key.size);
                    if (const Json* v = item.find("power"))
                        reader.number(*v, at + ".power", 0, 1e9, key.power);
                });
}

bool names_a_file(const std::string& key) {
    const auto control = [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; };
    return !key.empty() && key.size() <= 64 && key.find('/') == key.npos &&
           std::ranges::none_of(key, control);
}

// Keys that are good one by one may still meet on the way.
void check_frames(Reader& reader, const std::string& path, const Shot& shot, const ShotLight& light) {
    for (uint32_t frame = 0; frame < shot.frames; ++frame) {
        const LightKey key = light_at(light, frame);
        const glm::dvec3 both = key.direction + key.along;
        if (std::isfinite(both.x + both.y + both.z)) continue;
        reader.error(
            light.place, path + ".keys",
            fmt::format("at frame {} a direction vanishes between keys, or `along` is along `direction`",
                        frame));
        return;
    }
}

}  // namespace

const char* name_of(LightKind kind) {
    for (const Kind& known : kinds())
        if (known.kind == kind) return known.name;
    return "";
}

void read_lights(Reader& reader, const Json& root, Shot& shot) {
    const Json* lights = root.find("lights");
    if (!lights) return;
    if (lights->kind != Json::Kind::object || lights->members.empty() ||
        lights->members.size() > most_lights) {
        reader.error(lights->place, "lights",
                     fmt::format("expected an object of 1 to {} lights by their names", most_lights));
        return;
    }
    for (const JsonMember& member : lights->members) {
        const std::string path = "lights." + member.key;
        const Json& json = member.value;
        ShotLight& light = shot.lights[member.key];
        light.place = member.key_place;
        if (!names_a_file(member.key))
            reader.error(member.key_place, "lights",
                         "files are called by a light's name: expected 1 to 64 bytes without \"/\" and "
                         "control characters");
        if (member.key == "sun") reader.error(member.key_place, path, "the sun has a key of its own");
        const Json* name = json.kind == Json::Kind::object ? reader.required(json, path, "kind") : nullptr;
        const Kind* kind = name ? reader.named(*name, path + ".kind", "kind of light", kinds()) : nullptr;
        std::vector<const char*> known{"kind"};
        const bool in_model = kind && kind->kind == LightKind::model;
        if (in_model)
            known.push_back("light");
        else
            known.insert(known.end(), {"color", "range", "keys"});
        if (kind && kind->strength) known.push_back(kind->strength);
        if (kind) known.insert(known.end(), kind->sizes.begin(), kind->sizes.end());
        if (json.kind != Json::Kind::object) reader.object(json, path, known);
        if (!kind || !reader.object(json, path, known)) continue;
        light.kind = kind->kind;
        if (in_model) light.radius = -1;  // the model's own, if the shot has none
        read_sizes(reader, json, path, *kind, light);
        if (in_model) {
            read_name(reader, json, path, light.in_model);
            continue;
        }
        if (const Json* v = reader.required(json, path, kind->strength))
            reader.number(*v, path + "." + kind->strength, 0, 1e12, light.strength);
        if (const Json* v = json.find("color")) read_color(reader, *v, path + ".color", light.color);
        if (const Json* v = json.find("range")) reader.number(*v, path + ".range", 1e-6, huge, light.range);
        const size_t before = reader.errors();
        read_keys(reader, json, path, *kind, light);
        if (reader.errors() == before && !light.keys.empty()) check_frames(reader, path, shot, light);
    }
}

}  // namespace penumbra
