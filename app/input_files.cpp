// SPDX-License-Identifier: MIT
#include "app/input_files.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <variant>

#include "app/pipeline_file.h"
#include "host/models/gltf_text.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// A glTF's JSON, as far as a document may go.
std::string json_of_model(const fs::path& model) {
    std::error_code failure;
    const uint64_t size = fs::is_regular_file(model, failure) ? fs::file_size(model, failure) : 0;
    std::string text(failure ? 0 : std::min(size, glb_head_bytes + largest_document()), '\0');
    std::ifstream(model, std::ios::binary).read(text.data(), static_cast<std::streamsize>(text.size()));
    return std::string(document_of(text));
}

// A glTF, and other files that it is made of.
void add_model(const fs::path& file, FileList& files) {
    files.push_back(file);
    const Json json = Json::parse(json_of_model(file), nullptr, false);
    if (!json.is_object()) return;
    for (const char* list : {"buffers", "images"}) {
        if (!json.contains(list) || !json[list].is_array()) continue;
        for (const Json& item : json[list]) {
            if (!item.is_object() || !item.contains("uri") || !item["uri"].is_string()) continue;
            const std::string uri = item["uri"];
            if (uri.starts_with("data:")) continue;
            std::error_code failure;
            const fs::path part = file.parent_path() / percent_decoded(uri);
            if (fs::is_regular_file(part, failure)) files.push_back(part);
        }
    }
}

}  // namespace

FileList files_of_shot(const Shot& shot, bool made_up) {
    FileList files;
    if (!made_up) files.push_back(shot.file);
    if (const auto* map = std::get_if<EnvironmentFile>(&shot.environment)) files.push_back(map->path);
    if (shot.analytic) return files;
    if (shot.models.empty()) add_model(shot.model, files);
    for (const PlacedModel& model : shot.models) add_model(model.file, files);
    return files;
}

FileList files_of_pipelines(const std::vector<std::string>& files) {
    FileList all;
    for (const std::string& file : files) {
        const auto chain = files_of_pipeline(file);
        all.insert(all.end(), chain.begin(), chain.end());
    }
    return all;
}

FileList files_of_nodes(const std::vector<std::string>& folders) {
    FileList files;
    std::error_code failure;
    for (const std::string& folder : folders)
        for (fs::directory_iterator entry(folder, failure), end; !failure && entry != end;
             entry.increment(failure))
            if (entry->is_regular_file(failure)) files.push_back(entry->path());
    return files;
}

bool spares(const FileList& written, std::initializer_list<FileList> read, Diagnostics& diagnostics) {
    const size_t before = diagnostics.size();
    std::error_code none;
    std::set<fs::path> before_it;
    for (const fs::path& file : written) {
        if (!before_it.insert(file).second)
            diagnostics.add({file.string(), 0, 0}, "", "two files would be written here: give another name");
        const auto is_it = [&](const fs::path& other) { return fs::equivalent(file, other, none); };
        for (const FileList& list : read)
            if (std::ranges::any_of(list, is_it)) {
                diagnostics.add({file.string(), 0, 0}, "",
                                "is read, and would be written over: write elsewhere");
                break;
            }
    }
    return diagnostics.size() == before;
}

}  // namespace penumbra
