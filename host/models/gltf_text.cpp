// SPDX-License-Identifier: MIT
#include "host/models/gltf_text.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "host/json_dump.h"
#include "host/models/gltf_members.h"

namespace penumbra {
namespace {

using Json = nlohmann::json;

constexpr const char *meshopt = "EXT_meshopt_compression", *draco = "KHR_draco_mesh_compression";
constexpr const char* octets = "data:application/octet-stream;base64,";
constexpr uint32_t glb_magic = 0x46546C67, json_chunk = 0x4E4F534A;
constexpr size_t glb_header = 12, chunk_header = 8;

uint32_t word(const std::vector<unsigned char>& bytes, size_t at) {
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

// Bytes before those of a data URI that tinygltf would take for the name of a file, since it does not know
// that type of data; else 0.
size_t unknown_data(std::string_view uri) {
    constexpr std::string_view known[] = {"application/octet-stream",
                                          "application/gltf-buffer",
                                          "text/plain",
                                          "image/jpeg",
                                          "image/png",
                                          "image/bmp",
                                          "image/gif"};
    constexpr std::string_view first = "data:", last = ";base64,";
    constexpr size_t longest = 128;
    const std::string_view head = uri.substr(0, uri.substr(0, longest).find(',') + 1);
    if (!head.starts_with(first) || !head.ends_with(last)) return 0;
    const std::string_view type = head.substr(first.size(), head.size() - first.size() - last.size());
    return std::ranges::find(known, type) == std::end(known) ? head.size() : 0;
}

// Null where there is none.
std::string* uri_of(Json& item) {
    const bool has = item.is_object() && item.contains("uri") && item["uri"].is_string();
    return has ? item["uri"].get_ptr<std::string*>() : nullptr;
}

// tinygltf decodes a URI as if it came from a form, where a plus stands for a space.
bool keep_pluses(std::string& uri) {
    if (uri.find('+') == uri.npos) return false;
    std::string kept;
    for (const char c : uri) {
        if (c == '+')
            kept += "%2B";
        else
            kept += c;
    }
    uri = std::move(kept);
    return true;
}

// Base64 of no more than `bytes` bytes.
bool cut_data(std::string& uri, uint64_t bytes) {
    const size_t start = uri.find(',') + 1;
    if (start == 0 || bytes >= uri.size()) return false;
    const size_t rest = bytes % 3, end = start + bytes / 3 * 4 + (rest ? rest + 1 : 0);
    if (end >= uri.size() || uri[end] == '=') return false;
    uri.resize(end);
    if (rest) uri.append(3 - rest, '=');
    return true;
}

// Nothing where nothing is to be changed; `made` as make_readable() says.
std::string patched(std::string_view text, ReadableGltf& made) {
    Json json = Json::parse(text, nullptr, false);
    made.wrong = wrong_member(json);
    bool changed = false;
    for (const char* list : {"buffers", "images"})
        for (Json* item : items(json, list)) {
            std::string* const uri = uri_of(*item);
            if (!uri) continue;
            if (const size_t head = unknown_data(*uri)) {
                uri->replace(0, head, octets);
                changed = true;
            }
            if (!uri->starts_with("data:")) changed = keep_pluses(*uri) || changed;
        }
    for (Json* buffer : items(json, "buffers")) {
        std::string* const uri = uri_of(*buffer);
        if (!uri || uri->empty() || !buffer->contains("byteLength")) continue;
        const Json& length = (*buffer)["byteLength"];
        const uint64_t bytes =
            length.is_number_unsigned() ? length.get<uint64_t>() : std::numeric_limits<uint64_t>::max();
        if (uri->starts_with("data:"))
            changed = cut_data(*uri, bytes) || changed;
        else
            made.lengths.push_back(bytes);
    }
    for (Json* buffer : items(json, "buffers")) {
        if (!has_extension(*buffer, meshopt) || buffer->contains("uri")) continue;
        (*buffer)["uri"] = std::string(octets) + "AA==";
        (*buffer)["byteLength"] = 1;
        changed = true;
    }
    for (Json* mesh : items(json, "meshes"))
        for (Json* primitive : items(*mesh, "primitives"))
            if (has_extension(*primitive, draco)) changed = primitive->erase("indices") > 0 || changed;
    return changed ? json_dump(json) : "";
}

}  // namespace

std::string_view document_of(std::string_view file) {
    if (!file.starts_with("glTF") || file.size() < glb_head_bytes) return file;
    uint32_t length = 0;
    std::memcpy(&length, file.data() + glb_header, sizeof length);
    return file.substr(glb_head_bytes, length);
}

std::string percent_decoded(const std::string& uri) {
    std::string out;
    for (size_t i = 0; i < uri.size(); ++i) {
        unsigned char value = 0;
        const char *digits = uri.data() + i + 1, *end = digits + 2;
        if (uri[i] == '%' && i + 2 < uri.size() && std::from_chars(digits, end, value, 16).ptr == end) {
            out += static_cast<char>(value);
            i += 2;
        } else {
            out += uri[i];
        }
    }
    return out;
}

ReadableGltf make_readable(std::vector<unsigned char>& bytes) {
    ReadableGltf made;
    const std::string_view all(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const bool binary = bytes.size() >= glb_header + chunk_header && word(bytes, 0) == glb_magic;
    if (!binary) {
        if (const std::string text = patched(all, made); !text.empty())
            bytes.assign(text.begin(), text.end());
        return made;
    }
    const size_t start = glb_header + chunk_header, length = word(bytes, glb_header);
    if (word(bytes, glb_header + 4) != json_chunk || length > bytes.size() - start) return made;
    std::string text = patched(all.substr(start, length), made);
    if (text.empty()) return made;
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::vector<unsigned char> out(bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(start));
    out.insert(out.end(), text.begin(), text.end());
    out.insert(out.end(), bytes.begin() + static_cast<ptrdiff_t>(start + length), bytes.end());
    const uint32_t sizes[2] = {static_cast<uint32_t>(out.size()), static_cast<uint32_t>(text.size())};
    std::memcpy(out.data() + 8, sizes, sizeof sizes);
    bytes = std::move(out);
    return made;
}

std::string old_version(const std::vector<unsigned char>& bytes) {
    const std::string_view all(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (all.starts_with("glTF")) return bytes.size() >= 8 && bytes[4] == 1 ? "1.0" : "";
    const Json json = Json::parse(all, nullptr, false);
    if (!json.is_object()) return "";
    // Lists were objects then, and the version could be left out, or a number.
    const bool of_objects = json.contains("meshes") && json["meshes"].is_object();
    const std::string guess = of_objects ? "1.0 or older" : "";
    if (!json.contains("asset") || !json["asset"].is_object()) return guess;
    const auto version = json["asset"].find("version");
    if (version == json["asset"].end()) return guess;
    if (version->is_number() && version->get<double>() < 2) return version->dump();
    if (!version->is_string()) return "";
    const std::string text = version->get<std::string>();
    return text.starts_with("2.") ? "" : text;
}

}  // namespace penumbra
