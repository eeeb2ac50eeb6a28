// SPDX-License-Identifier: MIT
#include "app/report/parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <variant>

#include "app/text_file.h"
#include "host/images/image_file.h"

namespace penumbra::report {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string text_of(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(stream)), {});
    if (!stream) throw FileError(file.string() + ": cannot be read");
    return text;
}

// FNV-1a, 64 bits (Fowler, Noll, Vo 1991): tells versions of a file apart, and guards against nothing else.
std::string digest(std::string_view bytes) {
    uint64_t hash = 14695981039346656037u;
    for (const char byte : bytes) hash = (hash ^ static_cast<uint8_t>(byte)) * 1099511628211u;
    return fmt::format("{:016x}", hash);
}

// A pipeline with all that it extends.
std::string pipeline_digest(const fs::path& file) {
    const std::string text = text_of(file);
    const Json json = Json::parse(text, nullptr, false);
    std::string out = digest(text);
    if (json.is_object() && json.contains("extends") && json["extends"].is_string())
        out += pipeline_digest(file.parent_path() / json["extends"].get<std::string>());
    return out;
}

// As tinygltf decodes it.
std::string decoded_uri(const std::string& uri) {
    std::string out;
    for (size_t i = 0; i < uri.size(); ++i) {
        uint8_t byte = 0;
        const char* const first = uri.data() + i + 1;
        const bool coded = uri[i] == '%' && i + 2 < uri.size() &&
                           std::from_chars(first, first + 2, byte, 16).ptr == first + 2;
        out += coded ? static_cast<char>(byte) : uri[i] == '+' ? ' ' : uri[i];
        if (coded) i += 2;
    }
    return out;
}

// Of a binary glTF its JSON chunk.
std::string_view document_of(std::string_view model) {
    constexpr size_t chunk = 20;
    if (!model.starts_with("glTF") || model.size() < chunk) return model;
    uint32_t length = 0;
    for (size_t i = 0; i < 4; ++i) length |= uint32_t{static_cast<uint8_t>(model[12 + i])} << 8 * i;
    return model.substr(chunk, length);
}

// Other files that a glTF is made of.
void add_uris(const Json& json, const fs::path& folder, std::string& out) {
    if (!json.is_structured()) return;
    for (auto item = json.begin(); item != json.end(); ++item) {
        const bool outside = json.is_object() && item.key() == "uri" && item->is_string() &&
                             !item->get<std::string>().starts_with("data:");
        if (outside)
            if (const fs::path file = folder / decoded_uri(item->get<std::string>());
                fs::is_regular_file(file))
                out += digest(text_of(file));
        add_uris(*item, folder, out);
    }
}

std::string shot_digest(const Shot& shot) {
    std::string out = digest(text_of(shot.file));
    if (const auto* map = std::get_if<EnvironmentFile>(&shot.environment)) out += digest(text_of(map->path));
    if (shot.analytic) return out;
    std::vector<fs::path> files{shot.model};
    if (!shot.models.empty()) files.clear();
    for (const PlacedModel& model : shot.models) files.push_back(model.file);
    for (const fs::path& file : files) {
        const std::string model = text_of(file);
        out += digest(model);
        add_uris(Json::parse(document_of(model), nullptr, false), file.parent_path(), out);
    }
    return out;
}

// Every file below, by name.
std::string folder_digest(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file()) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::string out;
    for (const fs::path& file : files) out += file.generic_string() + digest(text_of(file));
    return out;
}

}  // namespace

Parts::Parts(fs::path folder, const Results& results, const std::vector<std::string>& node_folders)
    : folder_(std::move(folder)) {
    const DeviceInfo& device = results.device;
    common_ = digest(text_of("/proc/self/exe")) + device.name + device.driver;
    common_ += to_json(results).at("study").dump();
    for (const Contender& contender : results.contenders) {
        common_ += contender.id;
        if (!contender.file.empty() && !(contender.variant() && contender.brute_force()))
            common_ += pipeline_digest(contender.file);  // brute force is a part of the program
    }
    for (const std::string& nodes : node_folders) common_ += folder_digest(nodes);
}

Parts::Name Parts::name(std::string name, const std::vector<Shot>& shots) const {
    std::string key = common_;
    for (const Shot& shot : shots) key += shot_digest(shot);
    return {std::move(name), digest(key)};
}

std::optional<Json> Parts::find(const Name& part) const {
    if (!fs::is_regular_file(file(part))) return std::nullopt;
    try {
        return whole_part(part);
    } catch (const Json::exception&) {  // which something else has written
        return std::nullopt;
    }
}

std::optional<Json> Parts::whole_part(const Name& part) const {
    const Json json = Json::parse(text_of(file(part)));
    if (json.at("key") != part.key) return std::nullopt;
    const Json& whole = json.at("part");
    std::vector<std::string> images;
    for (const Json& shot : whole.at("shots"))
        for (const char* image : {"reference_image", "motion_image"})
            if (!shot.at(image).is_null()) images.push_back(shot.at(image).get<std::string>());
    for (const Json& row : whole.at("results"))
        for (const Json& image : row.at("images")) images.push_back(image.get<std::string>());
    for (const std::string& image : images)
        if (!fs::is_regular_file(folder_ / image)) return std::nullopt;
    return whole;
}

void Parts::forget(const Name& part) const {
    fs::remove(file(part));
}

void Parts::keep(const Name& part, const Json& json) const {
    write_text(file(part), Json{{"key", part.key}, {"part", json}}.dump() + "\n");
}

fs::path Parts::file(const Name& part) const {
    return folder_ / "parts" / (part.name + ".json");
}

}  // namespace penumbra::report
