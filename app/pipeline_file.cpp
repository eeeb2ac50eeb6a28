// SPDX-License-Identifier: MIT
#include "app/pipeline_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/shipped_files.h"
#include "graph/json_reader.h"
#include "graph/read_text.h"
#include "host/shots/light_choice.h"

namespace penumbra {

namespace {

constexpr const char* lights_family = "lights";

bool has_lights(const Pipeline& pipeline) {
    return std::ranges::find(pipeline.instances, lights_family, &PipelineInstance::family) !=
           pipeline.instances.end();
}

// A base is a file beside the pipeline's, and who names one that ships may have thought of that.
void tell_of_shipped_bases(Diagnostics& diagnostics) {
    constexpr std::string_view no_file = "no file ";
    std::vector<Diagnostic> told;
    for (const Diagnostic& d : diagnostics.list()) {
        if (d.path != "extends" || !d.message.starts_with(no_file)) continue;
        const auto name = std::filesystem::path(d.message.substr(no_file.size())).filename();
        const std::filesystem::path ships = shipped_root() / shipped_pipelines.folder / name;
        if (std::error_code none; std::filesystem::is_regular_file(ships, none))
            told.push_back(
                {d.place, d.path, fmt::format("the one that ships is {}", ships.generic_string())});
    }
    for (const Diagnostic& d : told) diagnostics.add(d.place, d.path, d.message);
}

}  // namespace

// What a light of the model is like is known when the model has been read: until then it has a size and
// moves.
void name_lights(Pipeline& pipeline, const Shot& shot, const std::string& wanted, Diagnostics& diagnostics) {
    if (!has_lights(pipeline)) return;
    const std::vector<std::string> names = choose_lights(shot, wanted, diagnostics);
    std::map<std::string, PipelineInstance> own;
    std::erase_if(pipeline.instances, [&](const PipelineInstance& instance) {
        if (instance.family != lights_family) return false;
        std::error_code none;  // those of pipelines that ship stand for whatever lights there are
        const std::filesystem::path folder = std::filesystem::path(instance.place.file).parent_path();
        if (!std::filesystem::equivalent(folder, shipped_root() / shipped_pipelines.folder, none))
            own.emplace(instance.name, instance);
        return true;
    });
    std::vector<std::string> known;
    for (const auto& [name, light] : shot.lights) known.push_back(name);
    const auto lights =
        std::ranges::count_if(own, [&](const auto& o) { return shot.lights.contains(o.first); });
    const bool chosen = lights && lights == std::ssize(own);  // else they stand for them, too
    if (chosen && !wanted.empty() && !own.contains(wanted))
        diagnostics.add({}, "--light",
                        fmt::format("\"{}\" is none of the lights that \"{}\" names", wanted, pipeline.name));
    if (lights && !chosen)
        for (const auto& [name, instance] : own)
            if (!shot.lights.contains(name))
                diagnostics.add(
                    instance.place, "instances." + name,
                    "others here are lights of the shot, and this is none" + did_you_mean(name, known));
    const bool some_shine =
        std::ranges::any_of(names, [&](const auto& name) { return shines(shot.lights.at(name)); });
    for (const std::string& name : names) {
        if (chosen && !own.contains(name)) continue;
        const ShotLight& light = shot.lights.at(name);
        if (!chosen && some_shine && !shines(light)) continue;  // no pass and no byte
        if (!is_id(name))
            diagnostics.add(
                light.place, "lights." + name,
                fmt::format("\"{}\" has nodes for each light, which are named after it: expected an "
                            "id ([a-z][a-z0-9_]*)",
                            pipeline.name));
        const bool unknown = light.kind == LightKind::model;
        PipelineInstance& instance = pipeline.instances.emplace_back();
        if (chosen) instance = own.at(name);  // whose facts hold
        instance.name = name;
        instance.family = lights_family;
        instance.place = light.place;
        instance.facts.insert({{"sun_up", {true, light.place}},
                               {"sun_disc", {unknown || has_size(light), light.place}},
                               {"sun_moves", {unknown || light_moves(light), light.place}}});
    }
}

std::optional<CheckedPipeline> read_pipeline(const std::string& file,
                                             const std::vector<std::string>& settings, const NodeSet& nodes,
                                             const Shot* shot, const std::string& light,
                                             Diagnostics& diagnostics) {
    const auto found = shipped_file(file, shipped_root(), shipped_pipelines, diagnostics);
    auto pipeline = found ? load_pipeline(*found, settings, diagnostics) : std::nullopt;
    tell_of_shipped_bases(diagnostics);
    if (pipeline && shot) name_lights(*pipeline, *shot, light, diagnostics);
    if (!diagnostics.empty()) pipeline.reset();
    return pipeline ? check(*pipeline, nodes, diagnostics) : std::nullopt;
}

std::optional<CheckedPipeline> open_pipeline(const std::string& file,
                                             const std::vector<std::string>& settings, const NodeSet& nodes,
                                             const Shot* shot, const std::string& light) {
    Diagnostics diagnostics;
    auto checked = read_pipeline(file, settings, nodes, shot, light, diagnostics);
    if (!checked) std::cerr << diagnostics.text();
    return checked;
}

std::set<std::filesystem::path> files_of_pipeline(const std::filesystem::path& file) {
    std::set<std::filesystem::path> files;
    for (std::filesystem::path next = file; files.insert(next).second;) {
        const auto json = nlohmann::json::parse(read_text(next).value_or(""), nullptr, false);
        if (!json.is_object() || !json.contains("extends") || !json["extends"].is_string()) break;
        next = next.parent_path() / json["extends"].get<std::string>();
    }
    return files;
}

}  // namespace penumbra
