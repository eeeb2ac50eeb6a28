// SPDX-License-Identifier: MIT
// An engine without ray queries: its triangles become two arrays of texels, which the slots scene.nodes and
// scene.leaves read through uniform texel buffers (rgba32ui). A moving mesh is fitted again.
#include <penumbra/bvh.h>

#include <cstdio>
#include <vector>

int main() {
    // A floor, and a quad one metre above it.
    std::vector<penumbra::Triangle> triangles = {{{{-9, 0, -9}, {9, 0, -9}, {9, 0, 9}}},
                                                 {{{-9, 0, -9}, {9, 0, 9}, {-9, 0, 9}}},
                                                 {{{-1, 1, -1}, {1, 1, -1}, {1, 1, 1}}},
                                                 {{{-1, 1, -1}, {1, 1, 1}, {-1, 1, 1}}}};
    const std::vector<uint32_t> objects = {0, 0, 1, 1};  // which move apart
    penumbra::Bvh bvh = penumbra::build_bvh(triangles, objects);
    const penumbra::Ray up_from_the_floor{{0.5f, 0.01f, 0.2f}, {0, 1, 0}, 0, 100};
    const bool below = penumbra::occluded(bvh, up_from_the_floor);

    for (size_t t = 2; t < 4; ++t)
        for (auto& vertex : triangles[t].v) vertex[0] += 5;
    const bool fitted = penumbra::refit(bvh, triangles);  // false: build it anew
    const bool beside = penumbra::occluded(bvh, up_from_the_floor);
    std::printf("%zu texels of nodes, %zu of leaves; below the quad %s, beside it %s\n", bvh.nodes.size(),
                bvh.leaves.size(), below ? "shadow" : "light", beside ? "shadow" : "light");
    return below && fitted && !beside ? 0 : 1;
}
