// SPDX-License-Identifier: MIT
#include "app/kept_scene.h"

#include <algorithm>

namespace penumbra {

std::shared_ptr<const Scene> KeptScene::scene(const Shot& shot, Diagnostics& diagnostics,
                                              std::vector<std::string>& warnings) {
    if (!scene_) {
        auto loaded = load_scene(shot, diagnostics, warnings_);
        if (loaded) scene_ = std::make_shared<const Scene>(std::move(*loaded));
    }
    warnings.insert(warnings.end(), warnings_.begin(), warnings_.end());
    return scene_;
}

std::shared_ptr<SceneBvh> KeptScene::tree(Device& device, bool neighbours, TexelsAs as,
                                          const std::function<void(double)>& progress) {
    // One that knows more than is asked for does as well.
    const auto found =
        std::ranges::find_if(trees_, [&](const Tree& t) { return t.as == as && t.neighbours >= neighbours; });
    if (found != trees_.end()) return found->bvh;
    trees_.push_back(
        {neighbours, as, std::make_shared<SceneBvh>(device, *scene_, 0, neighbours, as, progress)});
    return trees_.back().bvh;
}

}  // namespace penumbra
