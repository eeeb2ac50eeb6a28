// SPDX-License-Identifier: MIT
#include "app/mask_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "graph/json_text.h"

namespace penumbra {

namespace fs = std::filesystem;

void write_reference_info(const fs::path& folder, const ReferenceInfo& info) {
    nlohmann::ordered_json json = {
        {"penumbra", 1}, {"shot", info.shot}, {"size", info.size}, {"exact", info.exact}, {"rays", nullptr}};
    if (info.rays) json["rays"] = *info.rays;
    const std::string text = json.dump(2) + "\n";
    write_file(folder / "reference.json", std::as_bytes(std::span(text)));
}

std::optional<ReferenceInfo> read_reference_info(const fs::path& folder, Diagnostics& diagnostics) {
    const auto json = read_json(folder / "reference.json", diagnostics);
    if (!json) return std::nullopt;
    const Json *shot = json->find("shot"), *size = json->find("size"), *exact = json->find("exact"),
               *rays = json->find("rays");
    const bool good = shot && shot->kind == Json::Kind::string && size && size->kind == Json::Kind::array &&
                      size->items.size() == 2 && exact && exact->kind == Json::Kind::boolean && rays &&
                      (rays->kind == Json::Kind::null || rays->kind == Json::Kind::integer);
    if (!good) {
        diagnostics.add(json->place, "", "not written by `penumbra reference`");
        return std::nullopt;
    }
    ReferenceInfo info{shot->string, {}, exact->boolean, {}};
    for (size_t i = 0; i < 2; ++i) info.size[i] = static_cast<uint32_t>(size->items[i].integer);
    if (rays->kind == Json::Kind::integer) info.rays = static_cast<uint32_t>(rays->integer);
    return info;
}

fs::path visibility_file(const fs::path& folder, uint32_t frame) {
    return folder / fmt::format("visibility.{:04}.exr", frame);
}

std::optional<std::vector<uint32_t>> visibility_frames(const fs::path& folder, Diagnostics& diagnostics) {
    std::error_code failure;
    std::vector<uint32_t> frames;
    for (fs::directory_iterator entry(folder, failure), end; !failure && entry != end;
         entry.increment(failure)) {
        unsigned frame = 0;
        int length = 0;
        const std::string name = entry->path().filename().string();
        if (std::sscanf(name.c_str(), "visibility.%u.exr%n", &frame, &length) == 1 &&
            size_t(length) == name.size())
            frames.push_back(frame);
    }
    if (failure) {
        diagnostics.add({folder.string(), 0, 0}, "", "cannot be listed: " + failure.message());
        return std::nullopt;
    }
    if (frames.empty()) {
        diagnostics.add({folder.string(), 0, 0}, "", "no visibility.NNNN.exr in here");
        return std::nullopt;
    }
    std::sort(frames.begin(), frames.end());
    return frames;
}

}  // namespace penumbra
