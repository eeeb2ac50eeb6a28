// SPDX-License-Identifier: MIT
#include "tests/bvh_shipped_scenes.h"

#include <filesystem>
#include <stdexcept>

#include "host/models/gltf.h"
#include "host/scene/scene.h"
#include "host/shots/shot.h"

namespace penumbra::test {

std::vector<TriangleScene> shipped_scenes() {
    const std::filesystem::path folder = std::filesystem::path(PENUMBRA_SOURCE_DIR) / "scenes";
    std::vector<TriangleScene> out;
    for (const char* name : {"cards", "colonnade", "engine", "fan", "heightfield", "lamp", "trees"}) {
        Diagnostics diagnostics;
        const std::optional<Shot> shot = read_shot(folder / (std::string(name) + ".shot.json"), diagnostics);
        std::optional<Model> model;
        if (shot) model = load_gltf(shot->model, diagnostics);
        if (!model || !check_objects(*shot, *model, diagnostics))
            throw std::runtime_error(diagnostics.text());
        out.push_back({std::string("shipped_") + name, Scene(std::move(*model), *shot).triangles(0)});
    }
    return out;
}

}  // namespace penumbra::test
