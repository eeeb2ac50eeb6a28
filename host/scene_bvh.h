// SPDX-License-Identifier: MIT
// A scene's BVH on the device, as the two texel buffers that a `scene` port reads. Follows moving objects:
// refitted, and rebuilt where the old shape cannot hold them.
#pragma once

#include "host/bvh.h"
#include "host/gpu.h"
#include "host/scene.h"

namespace penumbra {

class SceneBvh {
  public:
    // Builds for the scene at `frame`. `scene` must outlive the BVH.
    SceneBvh(Device& device, const Scene& scene, double frame);

    // Moves to another frame; nothing on the device may be reading the buffers.
    void update(double frame);

    VkBufferView nodes() const { return nodes_.view.get(); }
    VkBufferView leaves() const { return leaves_.view.get(); }
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
    TexelBuffer nodes_, leaves_;
};

}  // namespace penumbra
