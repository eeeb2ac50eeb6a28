// SPDX-License-Identifier: MIT
#include "app/view_source.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "app/is_there.h"
#include "app/progress.h"
#include "app/shipped_files.h"
#include "graph/read_text.h"
#include "host/json_dump.h"
#include "host/models/joined_models.h"
#include "host/shots/model_shot.h"
#include "host/shots/shot_text.h"
#include "penumbra/json_text.h"

namespace penumbra {

namespace fs = std::filesystem;

namespace {

constexpr const char* reading_models = "reading the model";

// The shot of a "scene" and whatever else is `said`, to be completed from what its models hold.
std::optional<Shot> models_alone(const nlohmann::json& said, const fs::path& file, Diagnostics& diagnostics) {
    const auto nowhere = nlohmann::json::parse(
        R"({ "keys": [{ "frame": 0, "position": [0, 0, 1], "target": [0, 0, 0], "to_sun": [0, 1, 0] }] })");
    nlohmann::json camera = nowhere, sun = nowhere;
    camera["keys"][0].erase("to_sun");
    sun["keys"][0].erase("position");
    sun["keys"][0].erase("target");
    nlohmann::json shot{{"penumbra_shot", 1}, {"camera", camera}, {"sun", sun}};
    shot.update(said);
    return parse_shot(json_dump(shot), file, diagnostics);
}

// `models`, with the frames, their time and the animation of its text; mistakes in them are told where all of
// it is read.
Shot as_played(const Shot& models, const nlohmann::json& text, const fs::path& file) {
    nlohmann::json said;
    for (const char* key : {"scene", "frames", "fps", "animation"})
        if (text.contains(key)) said[key] = text[key];
    Diagnostics told_later;
    return models_alone(said, file, told_later).value_or(models);
}

// Why a shot that nobody wrote cannot be read: mostly a size that no camera has numbers for.
std::string why_not(const Model& model, const std::array<glm::dvec3, 2>& bounds,
                    const Diagnostics& of_made_up) {
    const auto shown = [&](const Node& node) {
        return node.mesh >= 0 && !model.meshes[static_cast<size_t>(node.mesh)].parts.empty();
    };
    if (std::ranges::none_of(model.nodes, shown)) return "has triangles, but no node of its scene shows any";
    const double size = glm::distance(bounds[0], bounds[1]),
                 far = std::max(glm::length(bounds[0]), glm::length(bounds[1]));
    std::string text = fmt::format("is {:.3g} m large, up to {:.3g} m from the origin: ", size, far);
    const bool unusual = !(size > 1e-5 && far < 1e8);
    text += unusual ? "no shot has a camera for that; scale the model" : "no shot can be made up for it";
    for (const Diagnostic& problem : of_made_up.list())
        text += fmt::format("; {}: {}", problem.path, problem.message);
    return text;
}

void tell(const std::string& file, const ModelShot& made, const char* key) {
    for (auto [warning, end] = made.warnings.equal_range(key); warning != end; ++warning)
        print_warning(file + ": " + warning->second);
}

// Of several models each is where its file puts it, known by the file's name, and a number where two have it.
nlohmann::ordered_json scene_of(const std::vector<std::string>& files, const fs::path& folder) {
    if (files.size() == 1) return seen_from(files[0], folder);
    auto list = nlohmann::ordered_json::array();
    std::set<std::string> taken;
    for (const std::string& file : files) {
        const std::string stem = fs::path(file).stem().string();
        std::string name = stem;
        for (int nth = 2; !taken.insert(name).second; ++nth) name = fmt::format("{} {}", stem, nth);
        list.push_back({{"file", seen_from(file, folder)}, {"name", name}});
    }
    return list;
}

// Messages name the files as they were given; from the shot's folder the way there may be a long one.
void name_as_given(Shot& shot, const std::vector<std::string>& files) {
    if (shot.models.empty()) shot.model = files[0];
    for (size_t i = 0; i < shot.models.size(); ++i) shot.models[i].file = files[i];
}

std::optional<ViewSource> open_models(const std::vector<std::string>& files, bool ground,
                                      const fs::path& folder, Diagnostics& diagnostics) {
    const fs::path shot_file = folder / (fs::path(files[0]).stem().string() + ".shot.json");
    const auto scene = scene_of(files, folder);
    for (const std::string& file : files)
        if (const size_t before = diagnostics.size();
            !is_there(file, diagnostics) && diagnostics.size() == before)
            diagnostics.add({file, 0, 0}, "", "no such file");
    if (!diagnostics.empty()) return std::nullopt;
    std::optional<Shot> models = models_alone({{"scene", scene}}, shot_file, diagnostics);
    if (models) name_as_given(*models, files);
    Doing doing;
    doing(reading_models);
    const auto model = models ? load_models(*models, diagnostics) : std::nullopt;
    doing.clear();
    if (!model) return std::nullopt;
    ModelShot made = make_model_shot(*model, files[0], folder, ground);
    auto json = nlohmann::ordered_json::parse(made.text);
    json["scene"] = scene;
    made.text = shot_text(json);
    const auto& [low, high] = made.bounds;
    Diagnostics of_made_up;  // of a file that nobody wrote
    auto shot = parse_shot(made.text, shot_file, of_made_up);
    if (!shot) {
        diagnostics.add({files[0]}, "", why_not(*model, made.bounds, of_made_up));
        return std::nullopt;
    }
    name_as_given(*shot, files);
    for (const char* key : {"scene", "camera", "sun", "lights", "animation"}) tell(files[0], made, key);
    fmt::print(stderr, "{}: {} triangle{}, x {:.4g} .. {:.4g}, y {:.4g} .. {:.4g}, z {:.4g} .. {:.4g} m\n",
               fmt::join(files, ", "), model->triangle_count(), model->triangle_count() == 1 ? "" : "s",
               low.x, high.x, low.y, high.y, low.z, high.z);
    return ViewSource{std::move(*shot), made.text, made.text, made.camera};
}

}  // namespace

// What is made up goes behind the first brace, on its line: errors of all that is written keep their lines.
std::optional<Shot> read_completed_shot(const fs::path& file, Diagnostics& diagnostics, std::string* parsed) {
    // First of all, since this reads no folder, and of what never ends no more than it may.
    const auto read = read_json(file, diagnostics);
    if (!read) return std::nullopt;
    std::string text = read_text(file).value_or("");
    if (parsed) *parsed = text;
    const auto json = nlohmann::json::parse(text, nullptr, false);
    const bool of_model =
        json.is_object() && json.contains("scene") && (json["scene"].is_string() || json["scene"].is_array());
    const bool camera = of_model && json.contains("camera"),
               sun = of_model && (json.contains("sun") || json.contains("lights"));
    if (!of_model || (camera && sun)) return read_shot(file, diagnostics);
    // Mistakes of the scene's are told with all others, by their places in the file.
    Diagnostics of_scene;
    const std::optional<Shot> models = models_alone({{"scene", json["scene"]}}, file, of_scene);
    const size_t before = diagnostics.size();
    const auto there = [&](const fs::path& model) { return is_there(model, diagnostics); };
    if (!models || !(models->models.empty() ? there(models->model)
                                            : std::ranges::all_of(models->models, there, &PlacedModel::file)))
        return diagnostics.size() == before ? read_shot(file, diagnostics) : std::nullopt;
    Doing doing;
    doing(reading_models);
    const auto model = load_models(*models, diagnostics);
    doing.clear();
    if (!model) return std::nullopt;
    const Shot played = as_played(*models, json, file);
    const ModelShot made = make_model_shot(*model, file, file.parent_path(), false, &played);
    const auto made_up = nlohmann::ordered_json::parse(made.text);
    std::string missing;
    const auto complete = [&](const char* key) {
        missing += fmt::format("\"{}\": {}, ", key, json_dump(made_up[key]));
        tell(file.string(), made, key);
    };
    if (!camera) complete("camera");
    if (!sun) complete("sun");
    text.insert(text.find('{') + 1, missing);
    if (parsed) *parsed = text;
    return parse_shot(text, file, diagnostics);
}

bool is_model_file(const std::string& name) {
    std::string ending = fs::path(name).extension().string();
    std::ranges::transform(ending, ending.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return ending == ".glb" || ending == ".gltf" || ending == ".vrm";  // of avatars: a .glb
}

std::optional<GivenFiles> sort_files(const std::vector<std::string>& files, const ViewArguments& view,
                                     Diagnostics& diagnostics) {
    GivenFiles given{"", view};
    for (const std::string& file : files) {
        if (is_model_file(file)) {
            given.view.models.push_back(file);
            continue;
        }
        std::error_code none;
        const bool named_shot = is_shipped(file, shipped_root(), shipped_shots) &&
                                !is_shipped(file, shipped_root(), shipped_pipelines) &&
                                !fs::exists(file, none);
        if ((file.ends_with(".shot.json") || named_shot) && given.view.shot.empty()) {
            given.view.shot = file;
            continue;
        }
        if (fs::is_regular_file(file, none) && fs::path(file).has_extension() &&
            fs::path(file).extension() != ".json")
            diagnostics.add({file}, "",
                            "is neither a pipeline or a shot (.json) nor a model (.glb, .gltf, .vrm)");
        if (!given.pipeline.empty())
            diagnostics.add(
                {}, "",
                fmt::format("\"{}\" and \"{}\": one pipeline and one shot at a time", given.pipeline, file));
        given.pipeline = file;
    }
    if (!given.pipeline.empty() &&
        diagnostics.empty())  // before anybody asks for a shot: the word may be one, or a model
        shipped_file(given.pipeline, shipped_root(), shipped_pipelines, diagnostics);
    if (!diagnostics.empty()) return std::nullopt;
    return given;
}

std::string pipeline_for(const GivenFiles& given, const Shot* shot) {
    if (!given.pipeline.empty()) return given.pipeline;
    return shot && !shot->has_sun ? "lights" : "hybrid_shadows";
}

std::string view_name(const ViewArguments& arguments) {
    std::string name =
        fs::path(arguments.models.empty() ? arguments.shot : arguments.models[0]).stem().string();
    if (name.ends_with(".shot")) name.resize(name.size() - 5);
    // Dots alone would name a folder above.
    return name.find_first_not_of('.') == name.npos ? "unnamed" : name;
}

std::optional<ViewSource> open_view(const ViewArguments& arguments, const fs::path& folder,
                                    Diagnostics& diagnostics) {
    if (arguments.shot.empty() == arguments.models.empty()) {
        diagnostics.add({}, "",
                        arguments.models.empty()
                            ? "give a model, or a shot by --shot: `model.glb`, or `--shot lamp`"
                            : "give a model, or a shot by --shot: one of the two");
        return std::nullopt;
    }
    if (!arguments.models.empty())
        return open_models(arguments.models, arguments.ground, folder, diagnostics);
    if (is_model_file(arguments.shot))
        return open_models({arguments.shot}, arguments.ground, folder, diagnostics);
    if (arguments.ground) {
        diagnostics.add({}, "--ground", "goes with a model; a shot has a \"ground\" of its own");
        return std::nullopt;
    }
    const auto file = shipped_file(arguments.shot, shipped_root(), shipped_shots, diagnostics);
    std::string text;
    auto shot = file ? read_completed_shot(*file, diagnostics, &text) : std::nullopt;
    if (!shot) return std::nullopt;
    return ViewSource{std::move(*shot), "", std::move(text), ""};
}

}  // namespace penumbra
