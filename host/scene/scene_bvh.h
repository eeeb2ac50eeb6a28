// SPDX-License-Identifier: MIT
// A scene's BVH on the device, as the texel buffers that a `scene` port reads, or storage buffers of the same
// words: two, and two more where triangles are alpha-tested (scene_alpha.h); and as the buffer of the input
// `neighbours`. Follows moving objects, at the cost of what moves: refitted, and rebuilt where the old shape
// cannot hold them.
#pragma once

#include <functional>
#include <optional>

#include "host/bvh/bvh.h"
#include "host/device/gpu.h"
#include "host/scene/scene.h"
#include "host/scene/scene_alpha.h"

namespace penumbra {

class SceneBvh {
  public:
    // Builds for the scene at `frame`, on request with leaf_neighbours(). `scene` must outlive the BVH.
    SceneBvh(Device& device, const Scene& scene, double frame, bool neighbours,
             TexelsAs as = TexelsAs::texels, const std::function<void(double)>& progress = {});

    // Moves to another frame, where anything moves between the two; nothing on the device may be reading the
    // buffers.
    void update(double frame);

    // Without views where they are words; no alpha where nothing is alpha-tested.
    const GpuTexels& nodes() const { return nodes_; }
    const GpuTexels& leaves() const { return leaves_; }
    const GpuTexels& alpha_uv() const { return alpha_uv_; }
    const GpuTexels& alpha_map() const { return alpha_map_; }
    const GpuBuffer& neighbours() const { return neighbours_; }  // none where they were not asked for
    const Bvh& bvh() const { return bvh_; }
    uint32_t builds() const { return builds_; }  // so far: each has leaves of its own

  private:
    void build(const std::vector<Triangle>& triangles, const std::function<void(double)>& progress = {});
    bool follow(const std::vector<Triangle>& triangles);
    void upload_tree();
    void upload_neighbours();

    Device& device_;
    const Scene& scene_;
    double frame_;
    uint32_t builds_ = 0;
    Bvh bvh_;
    bool with_neighbours_;
    TexelsAs as_;
    std::vector<Texel> built_neighbours_, neighbour_words_;  // of the last build; of now
    std::optional<SceneAlpha> alpha_;
    GpuTexels nodes_, leaves_, alpha_uv_, alpha_map_;
    GpuBuffer neighbours_;
};

}  // namespace penumbra
