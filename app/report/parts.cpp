// SPDX-License-Identifier: MIT
#include "app/report/parts.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/digest.h"
#include "app/input_files.h"
#include "app/text_file.h"
#include "graph/read_text.h"
#include "host/json_dump.h"

namespace penumbra::report {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string text_of(const fs::path& file) {
    auto text = read_text(file);
    if (!text) throw FileError(file.string() + ": cannot be read");
    return std::move(*text);
}

std::string digest_of(const FileList& files) {
    std::string out;
    for (const fs::path& file : files) out += digest(text_of(file));
    return out;
}

// Every file below, by name.
std::string folder_digest(const fs::path& folder) {
    FileList files;
    std::error_code failure, none;
    for (fs::recursive_directory_iterator entry(folder, failure), end; !failure && entry != end;
         entry.increment(failure))
        if (entry->is_regular_file(none)) files.push_back(entry->path());
    if (failure) throw FileError(folder.string() + ": cannot be read: " + failure.message());
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
    common_ += json_dump(to_json(results).at("study"));
    for (const Contender& contender : results.contenders) {
        common_ += contender.id;
        const bool of_program = results.study.light.empty() && contender.variant() && contender.brute_force();
        if (!contender.file.empty() && !of_program)  // whose own text the program's digest holds
            common_ += digest_of(files_of_pipelines({contender.file}));
    }
    for (const std::string& nodes : node_folders) common_ += folder_digest(nodes);
}

Parts::Name Parts::name(std::string name, const std::vector<Shot>& shots) const {
    std::string key = common_;
    for (const Shot& shot : shots) key += digest_of(files_of_shot(shot));
    return {std::move(name), digest(key)};
}

std::optional<Json> Parts::find(const Name& part) const {
    if (std::error_code none; !fs::is_regular_file(file(part), none)) return std::nullopt;
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
        if (std::error_code none; !fs::is_regular_file(folder_ / image, none)) return std::nullopt;
    return whole;
}

void Parts::forget(const Name& part) const {
    fs::remove(file(part));
}

void Parts::keep(const Name& part, const Json& json) const {
    write_text(file(part), json_dump(Json{{"key", part.key}, {"part", json}}) + "\n");
}

fs::path Parts::file(const Name& part) const {
    return folder_ / "parts" / (part.name + ".json");
}

}  // namespace penumbra::report
