// SPDX-License-Identifier: MIT
// A shot's scene and its trees of triangles, for sessions that look at the same shot on the same device one
// after the other or side by side: the model is read once, and a tree is built once.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/scene/scene_bvh.h"
#include "host/standalone.h"

namespace penumbra {

class KeptScene {
  public:
    // load_scene() at the first call, with its warnings at every one. Always of the same shot, whatever its
    // size where it is no analytic one.
    std::shared_ptr<const Scene> scene(const Shot& shot, Diagnostics& diagnostics,
                                       std::vector<std::string>& warnings);
    // Of scene(), at whatever moment somebody has moved it to: whoever uses it moves it before each frame.
    // `progress` as build_bvh()'s.
    std::shared_ptr<SceneBvh> tree(Device& device, bool neighbours, TexelsAs as,
                                   const std::function<void(double)>& progress = {});

  private:
    struct Tree {
        bool neighbours;
        TexelsAs as;
        std::shared_ptr<SceneBvh> bvh;
    };
    std::shared_ptr<const Scene> scene_;
    std::vector<std::string> warnings_;
    std::vector<Tree> trees_;
};

}  // namespace penumbra
