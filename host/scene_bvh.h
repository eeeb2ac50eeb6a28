// SPDX-License-Identifier: MIT
// A scene's BVH on the device, as the texel buffers that a `scene` port and the input
// `neighbours` read. Follows moving objects:
// refitted, and rebuilt where the old shape cannot hold them.
#pragma once

#include "host/bvh.h"
#include "host/gpu.h"
#include "host/scene.h"

namespace penumbra {

class SceneBvh {
  public:
    // Builds for the scene at `frame`, on request with leaf_neighbours(). `scene` must outlive the BVH.
    SceneBvh(Device& device, const Scene& scene, double frame, bool neighbours);

    // Moves to another frame; nothing on the device may be reading the buffers.
    void update(double frame);

    VkBufferView nodes() const { return nodes_.view.get(); }
    VkBufferView leaves() const { return leaves_.view.get(); }
    VkBufferView neighbours() const { return neighbours_.view.get(); }  // null without them
    const Bvh& bvh() const { return bvh_; }

  private:
    struct TexelBuffer {
        GpuBuffer buffer;
        Owned<VkBufferView> view;
    };
    TexelBuffer upload(const std::vector<Texel>& texels, const char* what);
    void upload_all();

    Device& device_;
    const Scene& scene_;
    Bvh bvh_;
    bool with_neighbours_;
    TexelBuffer nodes_, leaves_, neighbours_;
};

}  // namespace penumbra
