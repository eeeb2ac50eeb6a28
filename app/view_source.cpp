// SPDX-License-Identifier: MIT
#include "app/view_source.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

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
    return ViewSource{std::move(*shot), made.text};
}

}  // namespace

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
    auto shot = file ? read_shot(*file, diagnostics) : std::nullopt;
    if (!shot) return std::nullopt;
    return ViewSource{std::move(*shot), ""};
}

}  // namespace penumbra
