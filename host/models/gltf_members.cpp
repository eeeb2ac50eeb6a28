// SPDX-License-Identifier: MIT
#include "host/models/gltf_members.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

namespace penumbra {
namespace {

enum class Kind { boolean, number, numbers, count, index, indices, text };

// `way`: names of members; [] stands for all of a list's, {} for all of an object's.
struct Member {
    std::string_view way;
    Kind kind;
    size_t length = 0;  // of a list; 0: any
};

constexpr Member members[] = {
    {"extensionsRequired.[]", Kind::text},
    {"scene", Kind::index},
    {"scenes.[].nodes", Kind::indices},
    {"nodes.[].mesh", Kind::index},
    {"nodes.[].skin", Kind::index},
    {"nodes.[].camera", Kind::index},
    {"nodes.[].children", Kind::indices},
    {"nodes.[].matrix", Kind::numbers, 16},
    {"nodes.[].translation", Kind::numbers, 3},
    {"nodes.[].rotation", Kind::numbers, 4},
    {"nodes.[].scale", Kind::numbers, 3},
    {"nodes.[].weights", Kind::numbers},
    {"meshes.[].weights", Kind::numbers},
    {"meshes.[].primitives.[].mode", Kind::index},
    {"meshes.[].primitives.[].indices", Kind::index},
    {"meshes.[].primitives.[].material", Kind::index},
    {"meshes.[].primitives.[].attributes.{}", Kind::index},
    {"meshes.[].primitives.[].targets.[].{}", Kind::index},
    {"skins.[].joints", Kind::indices},
    {"skins.[].inverseBindMatrices", Kind::index},
    {"animations.[].samplers.[].input", Kind::index},
    {"animations.[].samplers.[].output", Kind::index},
    {"animations.[].samplers.[].interpolation", Kind::text},
    {"animations.[].channels.[].sampler", Kind::index},
    {"animations.[].channels.[].target.node", Kind::index},
    {"animations.[].channels.[].target.path", Kind::text},
    {"accessors.[].bufferView", Kind::index},
    {"accessors.[].byteOffset", Kind::count},
    {"accessors.[].componentType", Kind::index},
    {"accessors.[].count", Kind::count},
    {"accessors.[].type", Kind::text},
    {"accessors.[].normalized", Kind::boolean},
    {"accessors.[].sparse.count", Kind::index},
    {"accessors.[].sparse.indices.bufferView", Kind::index},
    {"accessors.[].sparse.indices.byteOffset", Kind::index},
    {"accessors.[].sparse.indices.componentType", Kind::index},
    {"accessors.[].sparse.values.bufferView", Kind::index},
    {"accessors.[].sparse.values.byteOffset", Kind::index},
    {"bufferViews.[].buffer", Kind::index},
    {"bufferViews.[].byteOffset", Kind::count},
    {"bufferViews.[].byteLength", Kind::count},
    {"bufferViews.[].byteStride", Kind::count},
    {"buffers.[].byteLength", Kind::count},
    {"buffers.[].uri", Kind::text},
    {"images.[].bufferView", Kind::index},
    {"images.[].uri", Kind::text},
    {"textures.[].source", Kind::index},
    {"textures.[].sampler", Kind::index},
    {"materials.[].doubleSided", Kind::boolean},
    {"materials.[].alphaCutoff", Kind::number},
    {"materials.[].alphaMode", Kind::text},
    {"materials.[].emissiveFactor", Kind::numbers, 3},
    {"materials.[].emissiveTexture.index", Kind::index},
    {"materials.[].emissiveTexture.texCoord", Kind::index},
    {"materials.[].pbrMetallicRoughness.baseColorFactor", Kind::numbers, 4},
    {"materials.[].pbrMetallicRoughness.baseColorTexture.index", Kind::index},
    {"materials.[].pbrMetallicRoughness.baseColorTexture.texCoord", Kind::index},
    {"materials.[].pbrMetallicRoughness.metallicFactor", Kind::number},
    {"materials.[].pbrMetallicRoughness.roughnessFactor", Kind::number},
    {"materials.[].pbrMetallicRoughness.metallicRoughnessTexture.index", Kind::index},
    {"materials.[].pbrMetallicRoughness.metallicRoughnessTexture.texCoord", Kind::index},
    {"cameras.[].perspective.yfov", Kind::number},
    {"cameras.[].perspective.znear", Kind::number},
    {"extensions.KHR_lights_punctual.lights.[].type", Kind::text},
    {"extensions.KHR_lights_punctual.lights.[].color", Kind::numbers, 3},
    {"extensions.KHR_lights_punctual.lights.[].intensity", Kind::number},
    {"extensions.KHR_lights_punctual.lights.[].range", Kind::number},
    {"extensions.KHR_lights_punctual.lights.[].spot.innerConeAngle", Kind::number},
    {"extensions.KHR_lights_punctual.lights.[].spot.outerConeAngle", Kind::number},
};

// tinygltf keeps these as int, whatever their size.
bool is_index(const nlohmann::json& json) {
    return json.is_number_unsigned() && json.get<uint64_t>() <= uint64_t{std::numeric_limits<int>::max()};
}

bool fits(const nlohmann::json& json, const Member& member) {
    const auto list_of = [&](auto&& is_one) {
        return json.is_array() && (member.length == 0 || json.size() == member.length) &&
               std::ranges::all_of(json, is_one);
    };
    switch (member.kind) {
        case Kind::boolean:
            return json.is_boolean();
        case Kind::number:
            return json.is_number();
        case Kind::numbers:
            return list_of([](const nlohmann::json& item) { return item.is_number(); });
        case Kind::count:
            return json.is_number_unsigned();
        case Kind::index:
            return is_index(json);
        case Kind::indices:
            return list_of(is_index);
        case Kind::text:
            return json.is_string();
    }
    return true;
}

std::string words_of(const Member& member) {
    switch (member.kind) {
        case Kind::boolean:
            return "true or false";
        case Kind::number:
            return "a number";
        case Kind::numbers:
            return member.length ? fmt::format("a list of {} numbers", member.length) : "a list of numbers";
        case Kind::indices:
            return "a list of whole numbers from 0 on";
        case Kind::text:
            return "a string";
        default:
            return "a whole number from 0 on";
    }
}

struct Misfit {
    std::string way;
    std::string expected;
};

// The first on the way from `json` that does not fit.
std::optional<Misfit> misfit(const nlohmann::json& json, std::string_view way, const Member& member) {
    if (way.empty()) return fits(json, member) ? std::nullopt : std::optional(Misfit{"", words_of(member)});
    const std::string_view step = way.substr(0, way.find('.'));
    way.remove_prefix(std::min(step.size() + 1, way.size()));
    if (step == "[]") {
        if (!json.is_array()) return Misfit{"", "a list"};
        for (size_t i = 0; i < json.size(); ++i)
            if (const auto found = misfit(json[i], way, member))
                return Misfit{fmt::format("[{}]{}", i, found->way), found->expected};
        return std::nullopt;
    }
    if (!json.is_object()) return Misfit{"", "an object"};
    const bool all = step == "{}";
    for (auto item = all ? json.begin() : json.find(step); item != json.end(); ++item) {
        if (const auto found = misfit(item.value(), way, member))
            return Misfit{fmt::format(".{}{}", item.key().substr(0, 80), found->way), found->expected};
        if (!all) break;
    }
    return std::nullopt;
}

}  // namespace

std::string wrong_member(const nlohmann::json& gltf) {
    if (!gltf.is_object()) return "";  // which the parser says
    for (const Member& member : members)
        if (const auto found = misfit(gltf, member.way, member))
            return fmt::format("{}: expected {}", found->way.substr(1), found->expected);
    return "";
}

}  // namespace penumbra
