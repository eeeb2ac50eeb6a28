// SPDX-License-Identifier: MIT
// Objects keep their triangles' order, so that a refit needs positions alone.
#include "host/scene_bvh.h"

#include <fmt/format.h>

namespace penumbra {

SceneBvh::SceneBvh(Device& device, const Scene& scene, double frame, bool neighbours)
    : device_(device),
      scene_(scene),
      bvh_(build_bvh(scene.triangles(frame), scene.triangle_objects())),
      with_neighbours_(neighbours) {
    upload_all();
}

void SceneBvh::update(double frame) {
    const std::vector<Triangle> triangles = scene_.triangles(frame);
    if (!refit(bvh_, triangles)) bvh_ = build_bvh(triangles, scene_.triangle_objects());
    upload_all();
}

void SceneBvh::upload_all() {
    nodes_ = upload(bvh_.nodes, "the BVH's nodes");
    leaves_ = upload(bvh_.leaves, "the BVH's leaves");
    if (with_neighbours_) neighbours_ = upload(leaf_neighbours(bvh_), "the BVH's neighbours");
}

SceneBvh::TexelBuffer SceneBvh::upload(const std::vector<Texel>& texels, const char* what) {
    if (texels.size() > device_.limits().maxTexelBufferElements)
        throw DeviceError(fmt::format("{} need {} texels, the device's texel buffers hold {}", what,
                                      texels.size(), device_.limits().maxTexelBufferElements));
    TexelBuffer out;
    out.buffer = upload_buffer(device_, std::as_bytes(std::span(texels)),
                               VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT, what);
    VkBufferViewCreateInfo create{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
    create.buffer = out.buffer.get();
    create.format = VK_FORMAT_R32G32B32A32_UINT;
    create.range = texels.size() * sizeof(Texel);
    VkBufferView view = VK_NULL_HANDLE;
    check(vkCreateBufferView(device_.get(), &create, nullptr, &view), "vkCreateBufferView", what);
    out.view = {device_.get(), view};
    return out;
}

}  // namespace penumbra
