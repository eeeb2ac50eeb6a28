// SPDX-License-Identifier: MIT
#include "app/view_source.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "app/shipped_files.h"
#include "host/models/gltf.h"
#include "host/shots/model_shot.h"

namespace penumbra {

namespace fs = std::filesystem;

namespace {

std::optional<ViewSource> open_model(const std::string& file, bool ground, const fs::path& folder,
                                     Diagnostics& diagnostics) {
    const auto model = load_gltf(file, diagnostics);
    if (!model) return std::nullopt;
    if (model->triangle_count() == 0) {
        diagnostics.add({file, 0, 0}, "", fmt::format("{}", fmt::join(model->warnings, "; ")));
        return std::nullopt;
    }
    const ModelShot made = make_model_shot(*model, file, folder, ground);
    const fs::path shot_file = folder / (fs::path(file).stem().string() + ".shot.json");
    auto shot = parse_shot(made.text, shot_file, diagnostics);
    if (!shot) return std::nullopt;
    const auto& [low, high] = made.bounds;
    fmt::print(stderr, "{}: {} triangles, x {:.4g} .. {:.4g}, y {:.4g} .. {:.4g}, z {:.4g} .. {:.4g} m\n",
               file, model->triangle_count(), low.x, high.x, low.y, high.y, low.z, high.z);
    return ViewSource{std::move(*shot), made.text, made.text};
}

std::string text_of(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

// What is made up goes behind the first brace, on its line: errors of all that is written keep their lines.
std::optional<Shot> read_completed_shot(const fs::path& file, Diagnostics& diagnostics, std::string* parsed) {
    std::string text = text_of(file);
    if (parsed) *parsed = text;
    const auto json = nlohmann::json::parse(text, nullptr, false);
    const bool of_model = json.is_object() && json.contains("scene") && json["scene"].is_string();
    const bool camera = of_model && json.contains("camera"),
               sun = of_model && (json.contains("sun") || json.contains("lights"));
    const fs::path model_file = of_model ? file.parent_path() / json["scene"].get<std::string>() : fs::path();
    if (!of_model || (camera && sun) || !fs::is_regular_file(model_file)) return read_shot(file, diagnostics);
    const auto model = load_gltf(model_file, diagnostics);
    if (!model) return std::nullopt;
    if (model->triangle_count() == 0) return read_shot(file, diagnostics);
    const ModelShot made = make_model_shot(*model, model_file, file.parent_path(), false);
    const auto made_up = nlohmann::ordered_json::parse(made.text);
    std::string missing;
    if (!camera) missing += "\"camera\": " + made_up["camera"].dump() + ", ";
    if (!sun) missing += "\"sun\": " + made_up["sun"].dump() + ", ";
    text.insert(text.find('{') + 1, missing);
    if (parsed) *parsed = text;
    return parse_shot(text, file, diagnostics);
}

bool is_model_file(const std::string& name) {
    std::string ending = fs::path(name).extension().string();
    std::ranges::transform(ending, ending.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return ending == ".glb" || ending == ".gltf";
}

std::optional<GivenFiles> sort_files(const std::vector<std::string>& files, const ViewArguments& view,
                                     Diagnostics& diagnostics) {
    GivenFiles given{"", view};
    for (const std::string& file : files) {
        std::string& place = is_model_file(file) ? given.view.model : given.pipeline;
        if (!place.empty())
            diagnostics.add(
                {}, "",
                fmt::format("\"{}\" and \"{}\": one pipeline and one model or shot at a time", place, file));
        place = file;
    }
    if (!diagnostics.empty()) return std::nullopt;
    if (given.pipeline.empty()) given.pipeline = "hybrid_shadows";
    return given;
}

std::string view_name(const ViewArguments& arguments) {
    std::string name = fs::path(arguments.model.empty() ? arguments.shot : arguments.model).stem().string();
    if (name.ends_with(".shot")) name.resize(name.size() - 5);
    return name;
}

std::optional<ViewSource> open_view(const ViewArguments& arguments, const fs::path& folder,
                                    Diagnostics& diagnostics) {
    if (arguments.shot.empty() == arguments.model.empty()) {
        diagnostics.add({}, "", "give a model, or a shot by --shot: one of the two");
        return std::nullopt;
    }
    if (!arguments.model.empty()) return open_model(arguments.model, arguments.ground, folder, diagnostics);
    if (is_model_file(arguments.shot))
        return open_model(arguments.shot, arguments.ground, folder, diagnostics);
    if (arguments.ground) {
        diagnostics.add({}, "--ground", "goes with a model; a shot has a \"ground\" of its own");
        return std::nullopt;
    }
    const auto file = shipped_file(arguments.shot, shipped_root(), shipped_shots, diagnostics);
    std::string text;
    auto shot = file ? read_completed_shot(*file, diagnostics, &text) : std::nullopt;
    if (!shot) return std::nullopt;
    return ViewSource{std::move(*shot), "", std::move(text)};
}

}  // namespace penumbra
