// SPDX-License-Identifier: MIT
// A scene's translucent triangles in a tree of their own, so that whoever walks the scene's tree pays nothing
// for them: the inputs `translucents` (rgba32ui) and `translucent_texels` (r32ui), as
// shaders/visibility/transmittance.glsl reads them. Both trace backends do: they are few, and a ray goes
// through all of them.
//
// translucents:
//   texel 0              x: first texel of the leaves, y: of the leaves' words, z: of the records
//   texels 1 ..          nodes of the tree (host/bvh/bvh.h)
//   from x on            its leaves
//   from y on            per leaf two words, two leaves to a texel: record + 1 << 4 | i1 << 2 | i0, as
//                        scene_alpha.h has them; 0: no triangle
//   from z on            records of two texels, as those of scene_alpha.h
// translucent_texels: transmittance maps (host/models/translucency.h), each from its records' first word on.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "host/bvh/bvh.h"
#include "host/device/gpu.h"
#include "host/scene/scene.h"

namespace penumbra {

struct SceneTranslucents {
    std::vector<Texel> records;  // two per triangle of Scene::translucent_triangles()
    std::vector<uint32_t> map;   // translucent_texels

    // Of a triangle at the point with these weights of its corners (their sum is 1), in double precision.
    glm::dvec3 transmittance(size_t triangle, const std::array<double, 3>& weights) const;
};

// Throws std::runtime_error where a texture or their number exceeds the layout (65536 texels per axis, 2^31
// in all).
SceneTranslucents make_scene_translucents(const Scene& scene);

class TranslucentTree {
  public:
    // `scene` must outlive it.
    TranslucentTree(Device& device, const Scene& scene, double frame);
    // Nothing on the device may be reading the buffers.
    void update(double frame);

    VkBufferView tree() const { return tree_.view.get(); }
    VkBufferView texels() const { return texels_.view.get(); }

  private:
    void build();

    Device& device_;
    const Scene& scene_;
    double frame_;
    std::vector<Triangle> triangles_;
    SceneTranslucents translucents_;
    GpuTexels tree_, texels_;
};

}  // namespace penumbra
