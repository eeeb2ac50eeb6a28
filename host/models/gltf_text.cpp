// SPDX-License-Identifier: MIT
#include "host/models/gltf_text.h"

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

namespace penumbra {
namespace {

using Json = nlohmann::json;

constexpr const char *meshopt = "EXT_meshopt_compression", *draco = "KHR_draco_mesh_compression";
constexpr uint32_t glb_magic = 0x46546C67, json_chunk = 0x4E4F534A;
constexpr size_t glb_header = 12, chunk_header = 8;

uint32_t word(const std::string& bytes, size_t at) {
    uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

// The elements of a member that is a list; none where it is none.
std::vector<Json*> items(Json& object, const char* key) {
    std::vector<Json*> out;
    if (object.is_object() && object.contains(key) && object[key].is_array())
        for (Json& item : object[key]) out.push_back(&item);
    return out;
}

bool has_extension(Json& object, const char* name) {
    return object.is_object() && object.contains("extensions") && object["extensions"].is_object() &&
           object["extensions"].contains(name);
}

// Nothing where nothing is to be changed.
std::string patched(const std::string& text) {
    if (text.find(meshopt) == std::string::npos && text.find(draco) == std::string::npos) return "";
    Json json = Json::parse(text, nullptr, false);
    bool changed = false;
    for (Json* buffer : items(json, "buffers")) {
        if (!has_extension(*buffer, meshopt) || buffer->contains("uri")) continue;
        (*buffer)["uri"] = "data:application/octet-stream;base64,AA==";
        (*buffer)["byteLength"] = 1;
        changed = true;
    }
    for (Json* mesh : items(json, "meshes"))
        for (Json* primitive : items(*mesh, "primitives"))
            if (has_extension(*primitive, draco)) changed = primitive->erase("indices") > 0 || changed;
    return changed ? json.dump(-1, ' ', false, Json::error_handler_t::replace) : "";
}

}  // namespace

std::string taken_by_tinygltf(std::string bytes) {
    const bool binary = bytes.size() >= glb_header + chunk_header && word(bytes, 0) == glb_magic;
    if (!binary) {
        const std::string text = patched(bytes);
        return text.empty() ? bytes : text;
    }
    const size_t start = glb_header + chunk_header, length = word(bytes, glb_header);
    if (word(bytes, glb_header + 4) != json_chunk || length > bytes.size() - start) return bytes;
    std::string text = patched(bytes.substr(start, length));
    if (text.empty()) return bytes;
    text.resize((text.size() + 3) / 4 * 4, ' ');
    bytes.replace(start, length, text);
    const uint32_t sizes[2] = {static_cast<uint32_t>(bytes.size()), static_cast<uint32_t>(text.size())};
    std::memcpy(bytes.data() + 8, sizes, sizeof sizes);
    return bytes;
}

std::string old_version(const std::string& bytes) {
    if (bytes.size() >= 8 && bytes.starts_with("glTF")) return bytes[4] == 1 ? "1.0" : "";
    const auto json = Json::parse(bytes, nullptr, false);
    if (!json.is_object() || !json.contains("asset") || !json["asset"].is_object()) return "";
    const auto version = json["asset"].find("version");
    if (version == json["asset"].end() || !version->is_string()) return "";
    const std::string text = version->get<std::string>();
    return text.starts_with("2.") ? "" : text;
}

}  // namespace penumbra
