// SPDX-License-Identifier: MIT
// What a ray that hits a triangle wants to know of it: corners, texture coordinates, material, whether it
// moves. The inputs `surfaces` (rgba32ui) and `surface_texels` (r32ui), as
// shaders/reflections/hit_surface.glsl reads them; uploaded where a pipeline asks. All textures lie one after
// the other in one buffer: no bindless access is needed, and a hit reads a full-size texture's nearest texel,
// since a ray knows no footprint.
//
// surfaces:
//   texel 0              x: first texel of the leaves' words, y: of the instances', z: of the materials
//   texels 1 + 4 t ..    triangle t, in the order of Scene::triangles(): v0, v1, v2 (9 floats in the tree's
//                        frame), u0, v0, u1, v1, u2, v2 (6 floats), material | moves << 31
//   from x on            per leaf of the tree two words, the numbers of its first and second triangle; two
//                        leaves to a texel
//   from y on            per instance of the acceleration structure, the number of its first triangle; four
//                        to a texel
//   from z on            per material three texels: base colour (3 floats), 0 / emissive (3 floats), 0 /
//                        where the textures of both lie: first word (~0: none), width - 1 | height - 1 << 16,
//                        the same again. The first is the white Lambert surface of triangles without one.
// surface_texels: 8-bit RGBA as the files have it, rows from the top.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/bvh/bvh.h"
#include "host/device/gpu.h"
#include "host/scene/scene.h"

namespace penumbra {

struct SurfaceTexels {
    std::vector<Texel> surfaces;
    std::vector<uint32_t> texels;
};

// At `frame`; triangles that stand elsewhere at frame `previous` carry the bit, and those of parts that
// deform whenever anything has moved. `bvh` or `first_triangles` (one per instance of an acceleration
// structure) may be left out, and then nothing can be found by leaf or by instance. Throws std::runtime_error
// where a texture has more than 65536 texels per axis or all have more than 2^31.
SurfaceTexels make_surface_texels(const Scene& scene, double frame, double previous, const Bvh* bvh,
                                  std::span<const uint32_t> first_triangles);

// What of `surfaces` is another at `frame`: the corners, and the bit of what moves. Returns the numbers of
// the texels that are written, ascending.
std::vector<uint32_t> move_surface_texels(const Scene& scene, double frame, double previous,
                                          std::span<Texel> surfaces);

// Nothing on the device may be reading the buffers while they are made or moved.
class HitSurfaces {
  public:
    HitSurfaces(Device& device, const Scene& scene) : device_(device), scene_(scene) {}
    void make(double frame, double previous, const Bvh* bvh, std::span<const uint32_t> first_triangles);
    // With the tree that they were made with, refitted or not.
    void move(double frame, double previous);

    VkBufferView surfaces() const { return surfaces_.view.get(); }
    VkBufferView texels() const { return texels_.view.get(); }

  private:
    Device& device_;
    const Scene& scene_;
    std::vector<Texel> made_;
    GpuTexels surfaces_, texels_;
};

}  // namespace penumbra
