// SPDX-License-Identifier: MIT
#include "app/report/shots.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "app/text_file.h"
#include "app/view_source.h"
#include "host/json_dump.h"
#include "host/shots/light_choice.h"
#include "host/shots/model_shot.h"

namespace penumbra::report {
namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

void cut_to_first_key(OrderedJson& value) {
    if (!value.is_structured()) return;
    for (auto item = value.begin(); item != value.end(); ++item) {
        if (value.is_object() && item.key() == "keys" && item->is_array() && item->size() > 1)
            *item = OrderedJson::array({item->front()});
        cut_to_first_key(*item);
    }
}

// Works on the text rather than on a Shot, so that whatever else a shot says stays as it is.
OrderedJson standing_still(const std::string& text, const fs::path& file, const fs::path& folder,
                           uint32_t frames) {
    OrderedJson json = OrderedJson::parse(text);
    const auto seen_from_there = [&](OrderedJson& path) {
        path = seen_from(from_folder(file.parent_path(), path.get<std::string>()), folder);
    };
    json.erase("$schema");  // relative to the original
    json.erase("cuts");
    json.erase("animation");
    cut_to_first_key(json);
    OrderedJson& scene = json["scene"];
    if (scene.is_string())
        seen_from_there(scene);
    else if (scene.is_array())
        for (OrderedJson& model : scene) seen_from_there(model["file"]);
    else
        for (const char* motion : {"speed_px", "offset_px"}) scene.erase(motion);
    if (json.contains("environment") && json["environment"].contains("file"))
        seen_from_there(json["environment"]["file"]);
    json["frames"] = frames;
    return json;
}

void write_json(const fs::path& file, const OrderedJson& json) {
    write_text(file, json_dump(json, 2) + "\n");
}

// Names of files that are no UTF-8 are not whole in JSON.
void take_files(Shot& shot, const Shot& from) {
    shot.model = from.model;
    for (size_t i = 0; i < from.models.size(); ++i) shot.models[i].file = from.models[i].file;
    shot.environment = from.environment;
}

fs::path still_file(const fs::path& folder, const std::string& name) {
    return folder / (name + ".still.shot.json");
}

}  // namespace

bool can_be_reported(const fs::path& folder, const FileList& shots, const std::vector<std::string>& pipelines,
                     const std::vector<std::string>& node_folders, Diagnostics& diagnostics) {
    const size_t before = diagnostics.size();
    FileList written;
    for (const char* name : {"results.json", "results.csv", "tables.md", "index.html"})
        written.push_back(folder / name);
    std::map<std::string, fs::path> named;
    for (const fs::path& file : shots) {
        const auto [at, is_new] = named.emplace(shot_name(file), file);
        if (!is_new) {
            std::error_code none;
            diagnostics.add({file.string(), 0, 0}, "",
                            fs::equivalent(file, at->second, none)
                                ? "is given twice"
                                : fmt::format("\"{}\" is the name of {} too: report on each by itself",
                                              at->first, at->second.string()));
            continue;
        }
        written.push_back(still_file(folder / "shots", at->first));
        if (at->first.starts_with("edge_")) written.push_back(folder / "shots" / file.filename());
    }
    spares(written, {shots, files_of_pipelines(pipelines), files_of_nodes(node_folders)}, diagnostics);
    return diagnostics.size() == before;
}

std::optional<ReportShot> open_report_shot(const fs::path& file, const fs::path& folder, uint32_t frames,
                                           Diagnostics& diagnostics) {
    std::string text;
    auto moving = read_completed_shot(file, diagnostics, &text);
    if (!moving) return std::nullopt;
    const std::string name = moving->name;
    if (frames == 0) return ReportShot{name, std::move(*moving), std::nullopt};
    const fs::path standing = still_file(folder, name);
    write_json(standing, standing_still(text, file, folder, frames));
    auto still = read_shot(standing, diagnostics);
    if (!still) return std::nullopt;
    take_files(*still, *moving);
    return ReportShot{name, std::move(*moving), std::move(still)};
}

bool keep_light_alone(const std::string& light, ReportShot& shot, Diagnostics& diagnostics) {
    const auto alone = [&](Shot& of) {
        const auto chosen = choose_light(of, light, diagnostics);
        if (!chosen) return false;
        std::erase_if(of.lights, [&](const auto& other) { return other.first != chosen->name; });
        of.has_sun = false;
        return true;
    };
    return alone(shot.moving) && (!shot.still || alone(*shot.still));
}

EdgeShot make_edge_shot(double width_px, double speed_px, uint32_t frame, const fs::path& folder,
                        Diagnostics& diagnostics) {
    const fs::path file = folder / fmt::format("edge_{:g}px_{:+g}.shot.json", width_px, speed_px);
    // The edge's angle and the sun are those of `penumbra gates`.
    write_json(file, {{"penumbra_shot", 1},
                      {"scene",
                       {{"analytic", "half_plane"},
                        {"penumbra_px", width_px},
                        {"edge_deg", 20},
                        {"speed_px", speed_px},
                        {"offset_px", -speed_px * frame}}},
                      {"frames", frame + 1},
                      {"sun",
                       {{"angular_radius_deg", 0.2665},
                        {"keys", OrderedJson::array({{{"frame", 0}, {"to_sun", {0.3, 0.2, 1}}}})}}}});
    EdgeShot edge{width_px, speed_px, {}};
    if (auto shot = read_shot(file, diagnostics)) edge.shot = std::move(*shot);
    return edge;
}

}  // namespace penumbra::report
