// SPDX-License-Identifier: MIT
#include "app/view/stage.h"

#include <algorithm>
#include <new>

#include "app/node_folders.h"
#include "app/outputs.h"
#include "app/pipeline_file.h"

namespace penumbra::viewer {

void diagnose_thrown(const std::string& what, Diagnostics& diagnostics, const std::function<void()>& make) {
    try {
        make();
    } catch (const std::bad_alloc&) {
        diagnostics.add({what}, "", "there is not enough memory");
    } catch (const std::exception& error) {
        diagnostics.add({what}, "", error.what());
    }
}

std::unique_ptr<Stage> open_stage(const StagePlace& place, const StageWish& wish, Diagnostics& diagnostics,
                                  std::vector<std::string>& warnings) {
    auto nodes = read_nodes(wish.node_folders, diagnostics);
    auto checked =
        nodes ? read_pipeline(wish.pipeline, wish.settings, *nodes, &place.shot, wish.light, diagnostics)
              : std::nullopt;
    if (!checked) return nullptr;
    SessionOptions options;
    options.size = wish.size;
    options.captures = checked->output_names();
    const CheckedResource* shown = checked->resource(wish.shown);
    if (shown && !shown->input && std::ranges::find(options.captures, wish.shown) == options.captures.end())
        options.captures.push_back(wish.shown);
    options.seed = wish.seed;
    options.light = wish.light;
    options.steered = options.hold = true;
    options.kept = &place.scene;
    options.doing = place.told;
    auto stage = std::make_unique<Stage>(Stage{std::move(*nodes), std::move(*checked), nullptr, {}, {}});
    diagnose_thrown(stage->pipeline.file, diagnostics, [&] {
        stage->session = Session::open(place.device, stage->nodes, stage->pipeline, place.shot, options,
                                       diagnostics, warnings);
    });
    if (!stage->session) return nullptr;
    stage->controls = controls_of(stage->session->plan());
    stage->files = files_of_pipeline(stage->pipeline.file);
    return stage;
}

std::vector<std::string> resources_of(const Stage& stage) {
    std::vector<std::string> names;
    for (const PlanPass& pass : stage.session->plan().passes)
        if (pass.kind != PassKind::capture) names.insert(names.end(), pass.writes.begin(), pass.writes.end());
    for (const std::string& name : host_image_names())
        if (is_host_image(stage.pipeline, name)) names.push_back(name);
    return names;
}

}  // namespace penumbra::viewer
